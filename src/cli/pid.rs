//! `muspin pid`: a PID that is tuned within amplifier limits, or one with given numbers, on the full machine.

use super::Failure;
use super::choices::PictureArguments;
use super::console::{CommandEnd, Console, REPORT};
use super::controlled_machine::MachineArguments;
use super::design::say_unstable;
use super::design_arguments::PidArguments;
use super::progress::Progress;
use super::speeds::SpeedList;
use super::timings::Timings;
use crate::controller::speed_proof::SpeedProof;
use crate::controller::verification::rate_words;
use crate::export::json::AXIS_NAMES;
use crate::input::pid::load_pid;
use crate::pid::settings::TuneSettings;
use crate::pipeline::pid_loop::{PidController, PidLoop, PidOrigin, tune_pid};
use crate::predict::stiffness::stiffness_words;
use crate::report::margins::loop_rows;
use crate::report::pid::pid_report;
use crate::spindle::Machine;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Numbers of the PID (YAML); without a file they are searched within the limits below
    #[arg(conflicts_with_all = ["effort", "seed", "noise_current", "high_frequency_gain"])]
    file: Option<String>,
    #[command(flatten)]
    machine: MachineArguments,
    /// Speeds in rpm: a list `0,10000`, a range start:step:end `0:1000:5000`, or both; default: standstill, half of the
    /// top speed and the top speed
    #[arg(long, alias = "speed")]
    speeds: Option<SpeedList>,
    #[command(flatten)]
    search: PidArguments,
    /// Largest rms current that sensor noise may cause, A
    #[arg(long, default_value_t = TuneSettings::quick().noise_current_a)]
    noise_current: f64,
    /// Largest gain of the PID above the modes of the model, A/m
    #[arg(long, default_value_t = TuneSettings::quick().high_frequency_gain_a_per_m)]
    high_frequency_gain: f64,
    /// Folder for the controller, summary, pictures and report
    #[arg(long, default_value = "results/pid")]
    out: String,
    #[command(flatten)]
    pictures: PictureArguments,
    #[command(flatten)]
    timings: Timings,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let machine = arguments.machine.alone()?;
    let settings = arguments.settings()?;
    let given = match &arguments.file {
        Some(file) => Some(load_pid(file, machine.spindle.electronics.sample_rate_hz)?.sample(&machine)?),
        None => None,
    };
    console.claim(&arguments.out, &REPORT, &[])?;
    let progress = Progress::start(console);
    let pid = match given {
        Some(controller) => PidController { controller, origin: PidOrigin::Given, further: None },
        None => {
            progress.start_stage("search");
            tune_pid(&machine, &settings)?
        }
    };
    progress.start_stage("predictions");
    let speeds_rpm = arguments.speeds_rpm(&machine);
    let found = PidLoop::close(&machine, pid, &speeds_rpm, settings.mode_shift)?;
    progress.start_stage("report");
    let mut report = pid_report(&machine, &found, &settings)?;
    console.writing(|| report.write(&arguments.out, &arguments.pictures.formats))?;
    progress.end(arguments.timings);
    say_unstable(console, found.instability.is_some(), &found.words(&settings));
    Ok(show_pid(&found, &settings, &arguments.out).json(report.summary.to_json()))
}

impl Arguments {
    fn settings(&self) -> Result<TuneSettings, Failure> {
        let limits = [("noise-current", self.noise_current), ("high-frequency-gain", self.high_frequency_gain)];
        for (name, value) in limits {
            if !(value.is_finite() && value > 0.0) {
                return Err(Failure::new(format!("--{name}: {value} must be a positive number")));
            }
        }
        Ok(TuneSettings {
            noise_current_a: self.noise_current,
            high_frequency_gain_a_per_m: self.high_frequency_gain,
            ..self.search.settings()
        })
    }

    fn speeds_rpm(&self, machine: &Machine) -> Vec<f64> {
        let top_rpm = machine.spindle.max_rpm;
        self.speeds.as_ref().map_or_else(|| vec![0.0, 0.5 * top_rpm, top_rpm], |speeds| speeds.0.clone())
    }
}

fn show_pid(found: &PidLoop, settings: &TuneSettings, out: &str) -> CommandEnd {
    let dash = || "-".to_owned();
    let number = |x: f64, digits: usize| if x.is_finite() { format!("{x:.digits$}") } else { dash() };
    let speeds = found.predictions.iter().map(|p| {
        let stable = p.is_stable();
        let growth = rate_words(p.growth_rate_per_s, 1);
        let stiffness = if stable { stiffness_words(p.minimum.0) } else { dash() };
        let peak_db = if stable { number(p.sensitivity_peak_db(), 1) } else { dash() };
        let zone = p.zone_word().to_owned();
        vec![number(p.speed_rpm, 0), growth, stiffness, number(p.minimum.1, 0), peak_db, zone]
    });
    let margins = found.curves.stable.iter().flat_map(|stable| {
        AXIS_NAMES.into_iter().enumerate().map(move |(k, name)| {
            let own = stable.gain.margin(k);
            let [low, high] = [own.smallest_gain_factor, own.largest_gain_factor];
            let phase = [(own.phase_deg, 0), (own.phase_hz, 0), (own.crossover_hz, 0)];
            let cells = [(low, 2), (high, 2)].into_iter().chain(phase);
            let cells = cells.map(|(value, digits)| number(value, digits));
            std::iter::once(name.to_owned()).chain(cells).collect()
        })
    });
    let proven = found.verification.proof.as_ref().map_or(0.0, SpeedProof::proven_to_rpm);
    let shown = CommandEnd::met(found.meets(settings), found.words(settings))
        .row(["proven stable to, rpm".to_owned(), number(proven, 0)])
        .row(["rpm", "growth, 1/s", "smallest stiffness", "at Hz", "peak of S, dB", "zone"])
        .rows(speeds)
        .file(format!("{out}/report.html"))
        .file(format!("{out}/controller/discrete.json"));
    if found.instability.is_some() {
        return shown;
    }
    let next = |command: &str| format!("muspin {command} --controller {out}/controller/discrete.json");
    let shown = shown
        .rows(loop_rows(found.ends.each_ref(), found.curves.stable.as_ref()))
        .row(["margins at rest", "gain down to", "gain up to", "phase, °", "at Hz", "highest crossover, Hz"])
        .rows(margins);
    shown.next(next("simulate --case impulse")).next(next("export --out firmware"))
}
