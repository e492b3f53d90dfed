//! `muspin rehearse`: a measurement folder as the rig would give it, computed from a model with the noise of its
//! sensors, so that identification, updating and diagnosis can be tried before anything is measured.

use super::Failure;
use super::console::{CommandEnd, Console};
use super::machine::load_machine;
use super::progress::Progress;
use super::speeds::SpeedList;
use crate::identify::Rehearsal;
use crate::input::{load_controller, usual_tool};
use crate::pipeline::levitating_pid::levitating_pid;
use crate::report::rehearsed::RehearsedRig;
use crate::spindle::Machine;
use serde_json::json;
use std::path::Path;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Spindle that the folder names as the model: a file or a shipped name
    #[arg(long, default_value = "reference")]
    spindle: String,
    /// Tool that the folder names as the model: a file, a shipped name or `none`; default: none for a spindle with
    /// `output_m`, else the paper's
    #[arg(long)]
    tool: Option<String>,
    /// Spindle that the records come from, with its effects; default: the model, so that nothing is to be found
    #[arg(long)]
    truth: Option<String>,
    /// Tool that the records come from; default: that of the model
    #[arg(long)]
    true_tool: Option<String>,
    /// Controller that levitates the rotor (JSON); default: a textbook PID for the model, or, where that does not float
    /// the machine that the records come from, a PID tuned on it
    #[arg(long)]
    controller: Option<String>,
    /// Speeds of the sweeps in rpm: a list `0,10000`, a range start:step:end `0:1000:5000`, or both
    #[arg(long, alias = "speed", default_value = "0")]
    speeds: SpeedList,
    /// First line, Hz; default: a fiftieth of the first bending mode, at most 20
    #[arg(long)]
    from: Option<f64>,
    /// Last line, Hz; default: a quarter beyond the last mode of the design model, between the end of the stiffness
    /// band (4 kHz) and a fifth of the sample rate
    #[arg(long)]
    to: Option<f64>,
    /// Number of lines, spaced evenly in the logarithm, ends included; default: one for each 0.9 %
    #[arg(long)]
    lines: Option<usize>,
    /// Repeats of each experiment; their scatter is the noise
    #[arg(long, default_value_t = 3)]
    repeats: usize,
    /// Injected current, A; default: a twentieth of the front bias current
    #[arg(long)]
    injection: Option<f64>,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the measurement; it must not hold one already
    #[arg(long, default_value = "results/rehearsal")]
    out: String,
}

/// Most lines: minutes of computation and a file of some hundred megabytes.
const MOST_LINES: usize = 100_000;
/// Most repeats: minutes of computation and a file of a gigabyte.
const MOST_REPEATS: usize = 100;

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    check_numbers(arguments)?;
    let tool = arguments.tool.as_deref().map_or_else(|| usual_tool(&arguments.spindle), Ok)?;
    let model = load_machine(&arguments.spindle, tool)?;
    check_speeds(&arguments.speeds.0, model.spindle.max_rpm)?;
    let truth = load_machine(
        arguments.truth.as_deref().unwrap_or(&arguments.spindle),
        arguments.true_tool.as_deref().unwrap_or(tool),
    )?;
    let also: Vec<&str> = [&arguments.truth, &arguments.true_tool].into_iter().flatten().map(String::as_str).collect();
    console.claim(&arguments.out, &["measurement.yaml"], &also)?;
    let controller = match &arguments.controller {
        Some(file) => load_controller(file)?,
        None => {
            let progress = Progress::start(console);
            progress.stage("PID that floats the rotor");
            levitating_pid(&model, &truth, &arguments.speeds.0, &|| {})?
        }
    };
    let mut rehearsal = Rehearsal::usual(&truth)?;
    set_lines(&mut rehearsal, arguments, &truth)?;
    rehearsal.repeats = arguments.repeats;
    rehearsal.seed = arguments.seed;
    rehearsal.injection_a = arguments.injection.unwrap_or(rehearsal.injection_a);
    let progress = Progress::start(console);
    let watch = || progress.stage("records");
    let (controller, speeds_rpm) = (&controller, &arguments.speeds.0[..]);
    let rig = RehearsedRig { truth: &truth, controller, rehearsal: &rehearsal, speeds_rpm, watch: &watch };
    let (folder, records) = rig.folder(&model)?;
    drop(progress);
    console.writing(|| folder.write(Path::new(&arguments.out)))?;
    let files: Vec<&String> = records.iter().map(|(_, file, _)| file).collect();
    let answer = json!({
        "measurement": arguments.out,
        "records": files,
        "controller": controller.name,
        "sensor_noise_m": truth.spindle.electronics.sensor_noise_m,
        "injection_a": rehearsal.injection_a,
        "repeats": arguments.repeats,
        "seed": arguments.seed,
    });
    Ok(CommandEnd::done(format!("{} records computed, with the noise of the sensors", records.len()))
        .answer(&answer)
        .file(arguments.out.as_str())
        .next(format!("muspin identify --measurement {}", arguments.out))
        .next(format!("muspin diagnose --measurement {}", arguments.out)))
}

/// The lines that were asked for.
fn set_lines(rehearsal: &mut Rehearsal, arguments: &Arguments, truth: &Machine) -> Result<(), Failure> {
    let (first, last) = rehearsal.range_hz();
    let (from, to) = (arguments.from.unwrap_or(first), arguments.to.unwrap_or(last));
    let nyquist_hz = 0.5 * truth.spindle.electronics.sample_rate_hz;
    if !(from > 0.0 && to > from && to <= nyquist_hz) {
        let rule = format!("--from {from} --to {to}: no frequency range of this controller");
        return Err(Failure::new(rule)
            .with_hint(format!("frequencies are in Hz, 0 < from < to ≤ {nyquist_hz}, half the sample rate")));
    }
    let lines = arguments.lines;
    if let Some(count) = lines.filter(|n| !(2..=MOST_LINES).contains(n)) {
        let rule = format!("--lines {count}: 2 to {MOST_LINES} are computed");
        return Err(Failure::new(rule).with_hint("some hundred a decade resolve every peak"));
    }
    rehearsal.spread(from, to, lines);
    Ok(())
}

fn check_numbers(arguments: &Arguments) -> Result<(), Failure> {
    let repeats = arguments.repeats;
    if repeats == 0 || repeats > MOST_REPEATS {
        let rule = format!("--repeats {repeats}: 1 to {MOST_REPEATS} are computed");
        return Err(Failure::new(rule).with_hint("three repeats give the noise"));
    }
    let possible = |a: f64| a.is_finite() && a > 0.0;
    if arguments.injection.is_some_and(|a| !possible(a)) {
        return Err(Failure::new("--injection: must be a positive number of amperes")
            .with_hint("a twentieth of the bias current is usual"));
    }
    Ok(())
}

fn check_speeds(speeds: &[f64], top: f64) -> Result<(), Failure> {
    match speeds.iter().find(|r| !(0.0..=10.0 * top).contains(*r)) {
        None => Ok(()),
        Some(rpm) => {
            Err(Failure::new(format!("--speeds: {rpm} must lie between 0 and ten times the top speed of {top} rpm"))
                .with_hint("speeds are in rpm, for example --speeds 0,20000"))
        }
    }
}
