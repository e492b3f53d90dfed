//! `muspin diagnose`: find where simulation and measurement disagree, name the missing effect, show the gap shrink.
//! Writes the corrected spindle and tool, `summary.json`, the report and its pictures.

use super::Failure;
use super::choices::PictureArguments;
use super::console::{CommandEnd, Console, REPORT};
use super::machine::{MeasuredMachine, coarse_up_to, say};
use super::progress::Progress;
use super::reading::load_measurement;
use super::timings::Timings;
use crate::input::{Measurement, is_rotor};
use crate::report::diagnosis_words::sentence;
use crate::report::place_words::place_words;
use crate::workflow::diagnose::{diagnose_records, unused_rows, without_unknown_controllers};
use crate::workflow::diagnose_rotor::{diagnose_taps, diagnosed_report, is_explained};
use crate::workflow::plausibility::Records;
use crate::workflow::surroundings::Surroundings;

#[derive(clap::Args, Debug, Default)]
pub(super) struct Arguments {
    /// Measurement folder with measurement.yaml
    #[arg(long)]
    measurement: String,
    #[command(flatten)]
    machine: MeasuredMachine,
    /// Folder for corrected files, summary and report
    #[arg(long, default_value = "results/diagnosis")]
    out: String,
    #[command(flatten)]
    pictures: PictureArguments,
    #[command(flatten)]
    timings: Timings,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let mut loaded = load_measurement(&arguments.measurement, console)?;
    if is_rotor(arguments.machine.files(&loaded).0) {
        return diagnose_rotor(arguments, &loaded, console);
    }
    let machine = arguments.machine.load(&loaded)?;
    let MeasuredMachine { spindle, tool } = &arguments.machine;
    let known = Surroundings::of(&loaded, spindle.as_deref(), tool.as_deref(), &machine);
    console.claim(&arguments.out, &REPORT, &[])?;
    let records = Records::of(&loaded, Some(&machine), &|| {})?;
    records.lines().for_each(|line| eprintln!("{line}"));
    let mut left_out = without_unknown_controllers(&mut loaded);
    left_out.iter().for_each(|record| eprintln!("{}", record.words()));
    left_out.extend(unused_rows(&loaded));
    let progress = Progress::start(console);
    let said = |what: &str| progress.start_stage(what);
    let diagnosed = diagnose_records(&machine, &loaded, &records, &known, &said)?;
    progress.end(arguments.timings);
    diagnosed.unstable.iter().chain(&diagnosed.unjudged).for_each(|line| eprintln!("{line}"));
    let mut report = diagnosed.report(&loaded, &records, &known, &left_out)?;
    console.writing(|| report.write(&arguments.out, &arguments.pictures.formats))?;
    let (found, out) = (&diagnosed.found, arguments.out.as_str());
    let end = CommandEnd::met(diagnosed.is_explained(), format!("verdict {}", found.verdict.name()))
        .json(report.summary.to_json() + "\n")
        .row(["", "before", "after"])
        .row(["gap, σ".to_owned(), format!("{:.2}", found.gap_before), format!("{:.2}", found.gap_after)])
        .file(format!("{out}/report.html"))
        .file(format!("{out}/spindle.yaml"))
        .say(place_words(&machine, sentence(found)));
    let consequences = diagnosed.consequence.iter().map(|consequence| place_words(&machine, consequence.words()));
    Ok(consequences.fold(end, CommandEnd::say))
}

/// The missing change of a rotor without magnets.
fn diagnose_rotor(arguments: &Arguments, loaded: &Measurement, console: &Console) -> Result<CommandEnd, Failure> {
    let rotor = arguments.machine.load_rotor(loaded)?;
    console.claim(&arguments.out, &REPORT, &[])?;
    let records = Records::of(loaded, None, &|| {})?;
    records.lines().for_each(|line| eprintln!("{line}"));
    let progress = Progress::start(console);
    progress.start_stage("resonances, antiresonances and changes that explain them");
    let (found, notes) = diagnose_taps(&rotor, loaded)?;
    progress.end(arguments.timings);
    notes.iter().for_each(|note| eprintln!("{note}"));
    if !is_explained(&found) {
        let last_hz = loaded.hammers.iter().filter_map(|hammer| hammer.frf.frequency_hz.last().copied());
        let (file, tool) = arguments.machine.files(loaded);
        coarse_up_to(&rotor, [file, tool], last_hz.fold(0.0, f64::max))?.iter().for_each(say);
    }
    let mut report = diagnosed_report(&rotor, &found)?;
    console.writing(|| report.write(&arguments.out, &arguments.pictures.formats))?;
    Ok(CommandEnd::met(is_explained(&found), format!("verdict {}", found.verdict.name()))
        .json(report.summary.to_json() + "\n")
        .file(format!("{}/report.html", arguments.out))
        .file(format!("{}/spindle.yaml", arguments.out))
        .say(found.sentence()))
}
