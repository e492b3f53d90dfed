//! `muspin run`: the whole pipeline, from drawing and measurement to firmware tables and a report.

use super::Failure;
use super::choices::PictureArguments;
use super::console::{CommandEnd, Console, REPORT};
use super::controlled_machine::MachineArguments;
use super::design::{DesignEnd, say_unstable};
use super::design_progress::told;
use super::earlier::EarlierArgument;
use super::machine::MeasuredMachine;
use super::progress::Progress;
use super::reading::show;
use super::timings::Timings;
use crate::identify::Identification;
use crate::input::{load_measurement_watched, load_weights};
use crate::pid::settings::TuneSettings;
use crate::pipeline::run::{Extent, Task, run as run_chain};
use crate::pipeline::settings::DesignSettings;
use crate::report::run::run_report;
use crate::spindle::Machine;
use crate::update::Targets;
use crate::workflow::plausibility::Records;
use crate::workflow::update::targets;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Spindle file or shipped name; default: that of the measurement, or the reference
    #[arg(long)]
    spindle: Option<String>,
    /// Tool file or shipped name; default: that of the measurement, or the paper's
    #[arg(long)]
    tool: Option<String>,
    /// Weights file, or the name of a shipped one
    #[arg(long, default_value = "benchmark")]
    weights: String,
    /// Measurement folder or file of frequencies to update the model with; default: the published frequencies for the
    /// reference spindle, none for another
    #[arg(long)]
    measurement: Option<String>,
    /// The controller with its proofs and files only: no PID to compare with, no pictures, no push into the backup
    /// bearings
    #[arg(long)]
    quick: bool,
    /// Folder for the results
    #[arg(long, default_value = "results/reference")]
    out: String,
    #[command(flatten)]
    pictures: PictureArguments,
    #[command(flatten)]
    from: EarlierArgument,
    #[command(flatten)]
    timings: Timings,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let weights = load_weights(&arguments.weights)?;
    console.claim(&arguments.out, &REPORT, &[])?;
    let progress = Progress::start(console);
    progress.start_stage("records");
    let given = read_inputs(arguments, &progress)?;
    let task = Task {
        nominal: &given.nominal,
        targets: given.targets.as_ref(),
        weights: &weights,
        settings: &DesignSettings { earlier: arguments.from.design(&given.nominal)?, ..DesignSettings::with_polish() },
        pid: TuneSettings::quick(),
        extent: if arguments.quick { Extent::Controller } else { Extent::Everything },
    };
    let found = run_chain(&task, &mut |event| told(&progress, event))?;
    progress.start_stage("report");
    let identification = given.identification.as_ref();
    let (mut report, words) = run_report(&found, &weights.name, identification)?;
    let pid = found.pid().map(|p| &p.controller);
    report.controller("controller/", &found.machine, &found.design, pid)?;
    console.writing(|| report.write(&arguments.out, &arguments.pictures.formats))?;
    progress.end(arguments.timings);
    let (design, out) = (&found.design, arguments.out.as_str());
    say_unstable(console, design.instability.is_some(), &words);
    let stable = found.curves.as_ref().and_then(|curves| curves.closed_loop.stable.as_ref());
    let shown = DesignEnd { design, delivered: found.delivered.each_ref(), stable, out };
    Ok(shown.end(&words).data(format!("{words}\nresults in {out}\n"), report.summary.value()))
}

/// The machine as drawn, and what was measured of it.
struct Given {
    nominal: Machine,
    targets: Option<Targets>,
    identification: Option<Identification>,
}

fn read_inputs(arguments: &Arguments, progress: &Progress) -> Result<Given, Failure> {
    let source = match (&arguments.measurement, &arguments.spindle) {
        (Some(given), _) => given.as_str(),
        (None, None) => "paper-frequencies",
        (None, Some(_)) => {
            let files =
                MachineArguments { spindle: arguments.spindle.clone(), tool: arguments.tool.clone(), correction: None };
            return Ok(Given { nominal: files.alone()?, targets: None, identification: None });
        }
    };
    let measurement = load_measurement_watched(source, &|share| show(progress, share))?;
    let files = MeasuredMachine { spindle: arguments.spindle.clone(), tool: arguments.tool.clone() };
    let nominal = files.load(&measurement)?;
    let records = Records::of(&measurement, Some(&nominal), &|| {})?;
    records.refuse_for_updating()?;
    records.lines().for_each(|line| eprintln!("{line}"));
    let found = targets(&measurement, &records, &nominal, None)?;
    found.notes.iter().for_each(|note| eprintln!("{note}"));
    Ok(Given { nominal, targets: Some(found.targets), identification: found.identification })
}
