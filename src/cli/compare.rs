//! `muspin compare`: dynamic stiffness and sensitivity of controllers, and of measured hammer tests, side by side.

use super::Failure;
use super::choices::PictureArguments;
use super::console::{CommandEnd, Console, REPORT};
use super::controlled_machine::other_machine;
use super::design_arguments::{DesignArguments, PidArguments};
use super::design_progress::told;
use super::machine::Remarks;
use super::progress::Progress;
use super::reading::load_measurement;
use super::speeds::SpeedList;
use super::timings::Timings;
use crate::augment::weights::Weights;
use crate::controller::Controller;
use crate::input::{Measurement, load_tagged_controller, load_weights};
use crate::pipeline::compared::{Compared, Ground, KnownFigures, compare_controller, own_controllers};
use crate::pipeline::loop_stability::unstable_words;
use crate::predict::chatter::{CuttingMaterial, Engagement, USUAL_TEETH, USUAL_WIDTH};
use crate::predict::stiffness::stiffness_words;
use crate::report::compared::{HammerCurve, add_compared, add_own, all_acceptable, controller_keys};
use crate::report::plot::Role;
use crate::report::whole::Report;
use crate::spindle::Machine;
use crate::workflow::plausibility::Records;
use rayon::prelude::*;
use serde_json::Value;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    #[command(flatten)]
    machine: DesignArguments,
    /// Controllers (JSON), any number; default: the μ design, the tuned and the textbook PID for this machine
    #[arg(long)]
    controller: Vec<String>,
    /// Measurement folder whose hammer tests are shown beside the predictions
    #[arg(long)]
    measurement: Option<String>,
    /// Speeds in rpm: a list `0,10000`, a range start:step:end `0:1000:5000`, or both; default: standstill and the top
    /// speed
    #[arg(long, alias = "speed")]
    speeds: Option<SpeedList>,
    #[command(flatten)]
    pid: PidArguments,
    /// Uncertainty of the natural frequencies for the worst case in percent, mode by mode; default: that of the weights
    #[arg(long, value_delimiter = ',')]
    mode_uncertainty: Vec<f64>,
    /// Tangential cutting force coefficient of the workpiece for the stability lobes, Pa (aluminium 8e8, steel 2e9)
    #[arg(long, default_value_t = CuttingMaterial::ALUMINIUM.tangential_pa)]
    tangential_pa: f64,
    /// Radial over tangential cutting force
    #[arg(long, default_value_t = CuttingMaterial::ALUMINIUM.radial_ratio)]
    radial_ratio: f64,
    /// Teeth of the cutter; default: those of the tool, else 2
    #[arg(long)]
    teeth: Option<usize>,
    /// Radial width of cut over diameter, down milling; 1 is a slot
    #[arg(long, default_value_t = USUAL_WIDTH)]
    radial_width: f64,
    /// Folder for summary, pictures and report
    #[arg(long, default_value = "results/compare")]
    out: String,
    #[command(flatten)]
    pictures: PictureArguments,
    #[command(flatten)]
    timings: Timings,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let weights = load_weights(&arguments.machine.weights)?;
    let (machine, mut controllers, used, remarks) = read_inputs(arguments)?;
    let weights = weights.on(&machine)?;
    let (material, cut) = cut(arguments, &machine)?;
    let ends_rpm = [0.0, machine.spindle.max_rpm];
    let ground = Ground {
        machine: &machine,
        speeds_rpm: arguments.speeds.as_ref().map_or(&ends_rpm, |speeds| &speeds.0),
        mode_uncertainty: &mode_uncertainty(arguments, &weights)?,
        material: &material,
        cut: &cut,
    };
    let taps = match &arguments.measurement {
        Some(source) => at_the_tool(load_measurement(source, console)?),
        None => Measurement::default(),
    };
    let records = Records::of(&taps, Some(&machine), &|| ())?;
    records.lines().for_each(|line| eprintln!("{line}"));
    console.claim(&arguments.out, &REPORT, &[])?;
    let progress = Progress::start(console);
    let mut report = Report::of("compare", &machine);
    if let Some(used) = used {
        report.summary.set("machine", used);
    }
    let mut met = true;
    if controllers.is_empty() {
        let pid = arguments.pid.settings();
        let own = own_controllers(&machine, &weights, pid, &mut |event| told(&progress, event))?;
        met = own.design.meets_targets();
        controllers = add_own(&mut report.summary, own);
    }
    let list = all_compared(&ground, &controllers, &progress, arguments.timings.are_asked())?;
    let met = met && all_acceptable(&list) && records.plausible();
    let hammers = HammerCurve::of_all(&taps.hammers);
    let sentence = add_compared(&mut report, &ground, &list, hammers, met)?;
    progress.start_stage("report");
    console.writing(|| report.write(&arguments.out, &arguments.pictures.formats))?;
    progress.end(arguments.timings);
    for (_, each) in &list {
        if let Some((growth, rpm)) = each.unstable() {
            eprintln!("{}: {}", each.name, unstable_words(growth, rpm));
        }
    }
    drop(remarks);
    Ok(show_comparison(sentence, met, &list, &arguments.out).json(report.summary.to_json()))
}

/// The hammer tests at the tool plane alone; of the others it is said that they are left out.
fn at_the_tool(measurement: Measurement) -> Measurement {
    let (elsewhere, hammers): (Vec<_>, Vec<_>) = measurement.hammers.into_iter().partition(|h| h.places_m.is_some());
    for hammer in elsewhere {
        eprintln!("note: {}: not shown, as it was not taken at the tool plane (response_m, force_m)", hammer.name);
    }
    Measurement { hammers, ..Measurement::default() }
}

/// All controllers compared, in their order; one at a time where the time of each is asked for.
fn all_compared(
    ground: &Ground<'_>,
    controllers: &[(Role, Controller, KnownFigures)],
    progress: &Progress,
    timed: bool,
) -> Result<Vec<(Role, Compared)>, Failure> {
    let keys = controller_keys(controllers);
    let one = |(name, (role, controller, known)): (&String, &(Role, Controller, KnownFigures))| {
        if timed {
            progress.start_stage(format!("predictions for {name}"));
        }
        let found = compare_controller(ground, name, controller, known);
        Ok((*role, found.map_err(|error| Failure::from(error).naming(std::slice::from_ref(name)))?))
    };
    if timed {
        return keys.iter().zip(controllers).map(one).collect();
    }
    progress.start_stage("predictions");
    keys.par_iter().zip(controllers).map(one).collect()
}

type Given = (Machine, Vec<(Role, Controller, KnownFigures)>, Option<Value>, Remarks);

/// The machine, the controllers of the command line, which machine was used for them, and what looks wrong in its
/// files.
fn read_inputs(arguments: &Arguments) -> Result<Given, Failure> {
    let files = &arguments.machine.machine;
    let Some((first, others)) = arguments.controller.split_first() else {
        return Ok((files.alone()?, vec![], None, Remarks::default()));
    };
    let (found, mut remarks) = files.with_controller(first)?;
    let used = found.used_machine();
    let mut controllers = vec![(Role::Other(0), found.controller, KnownFigures::default())];
    for file in others {
        let loaded = load_tagged_controller(file)?;
        let other = other_machine(file, loaded.machine.as_ref(), &found.used);
        remarks.0.extend(other);
        let role = Role::Other(controllers.len());
        controllers.push((role, loaded.controller, KnownFigures::default()));
    }
    Ok((found.machine, controllers, Some(used), remarks))
}

/// Relative uncertainty per mode: from the command line in percent, else from the weights.
fn mode_uncertainty(arguments: &Arguments, weights: &Weights) -> Result<Vec<f64>, Failure> {
    // Beyond a fifth of its frequency a mode is not uncertain but unknown.
    if let Some(bad) = arguments.mode_uncertainty.iter().find(|r| !(0.0..=20.0).contains(*r)) {
        return Err(Failure::new(format!("--mode-uncertainty: {bad} must lie between 0 and 20 percent"))
            .with_hint("one number a mode, for example --mode-uncertainty 1,1,0"));
    }
    Ok(if arguments.mode_uncertainty.is_empty() {
        weights.mode_uncertainty.clone()
    } else {
        arguments.mode_uncertainty.iter().map(|r| 0.01 * r).collect()
    })
}

fn cut(arguments: &Arguments, machine: &Machine) -> Result<(CuttingMaterial, Engagement), Failure> {
    let width = arguments.radial_width;
    if !(width > 0.0 && width <= 1.0) {
        return Err(Failure::new(format!("--radial-width: {width} must lie between 0 and 1"))
            .with_hint("1 is a slot, 0.5 half the diameter"));
    }
    let material = CuttingMaterial { tangential_pa: arguments.tangential_pa, radial_ratio: arguments.radial_ratio };
    Ok((material, Engagement::down_milling(arguments.teeth.or(machine.tool.teeth).unwrap_or(USUAL_TEETH), width)))
}

fn show_comparison(sentence: &str, met: bool, list: &[(Role, Compared)], out: &str) -> CommandEnd {
    let head = ["controller", "rpm", "smallest stiffness", "at Hz", "zone"];
    let rows = list.iter().flat_map(|(_, c)| &c.predictions).map(|p| {
        vec![
            p.name.clone(),
            format!("{:.0}", p.speed_rpm),
            stiffness_words(p.minimum.0),
            format!("{:.0}", p.minimum.1),
            p.zone_word().to_owned(),
        ]
    });
    CommandEnd::met(met, sentence).row(head).rows(rows).file(format!("{out}/report.html"))
}
