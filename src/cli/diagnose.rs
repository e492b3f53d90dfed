//! `muspin diagnose`: find where simulation and measurement disagree, name the missing effect, show the gap shrink.
//! Writes the corrected spindle and tool, `summary.json`, the report and its pictures.

use super::console::{CommandEnd, Console};
use super::machine::{files_of_measurement, of_measurement, rotor_of_measurement};
use super::output::{REPORT, claim};
use super::progress::Progress;
use super::reading::load_measurement;
use super::timings::Timings;
use super::{Failure, Outcome};
use crate::input::{Measurement, is_rotor};
use crate::report::diagnosis_words::sentence;
use crate::report::place_words::place_words;
use crate::workflow::diagnose::{diagnose_records, unused_rows, without_unknown_controllers};
use crate::workflow::diagnose_rotor::{diagnose_taps, diagnosed_folder, diagnosis_topic, is_explained};
use crate::workflow::plausibility::Records;
use crate::workflow::surroundings::Surroundings;
use serde_json::json;
use std::path::Path;

/// Arguments of `muspin diagnose`.
#[derive(clap::Args, Debug, Default)]
pub(super) struct Arguments {
    /// Measurement folder with measurement.yaml
    #[arg(long)]
    measurement: String,
    /// Spindle file or shipped name; default: that of the measurement
    #[arg(long)]
    spindle: Option<String>,
    /// Tool file or shipped name; default: that of the measurement
    #[arg(long)]
    tool: Option<String>,
    /// Folder for corrected files, summary and report
    #[arg(long, default_value = "results/diagnosis")]
    out: String,
    #[command(flatten)]
    timings: Timings,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let mut loaded = load_measurement(&arguments.measurement, console)?;
    if is_rotor(files_of_measurement(&loaded, arguments.spindle.as_deref(), arguments.tool.as_deref()).0) {
        return diagnose_rotor(arguments, &loaded, console);
    }
    let machine = of_measurement(&loaded, arguments.spindle.as_deref(), arguments.tool.as_deref())?;
    let known = Surroundings::of(&loaded, arguments.spindle.as_deref(), arguments.tool.as_deref(), &machine);
    let named = [&arguments.spindle, &arguments.tool].into_iter().flatten();
    let read = named.chain([&arguments.measurement]);
    claim(&arguments.out, &REPORT, read.map(String::as_str))?;
    let records = Records::of(&loaded, Some(&machine), &|| {})?;
    records.lines().for_each(|line| eprintln!("{line}"));
    let mut left_out = without_unknown_controllers(&mut loaded);
    left_out.iter().for_each(|record| eprintln!("{}", record.words()));
    left_out.extend(unused_rows(&loaded));
    let progress = Progress::start(console);
    let said = |what: &str| progress.start_stage(what);
    let diagnosed = diagnose_records(&machine, &loaded, &records, &known, &said)?;
    arguments.timings.print(&progress.times());
    drop(progress);
    diagnosed.unstable.iter().for_each(|line| eprintln!("{line}"));
    let mut report = diagnosed.report(&loaded, &records, &known, &left_out)?;
    console.writing(|| report.write(&arguments.out))?;
    let found = &diagnosed.found;
    let ended = if diagnosed.is_explained() { Outcome::Done } else { Outcome::TargetMissed };
    let out = arguments.out.as_str();
    console.json(&(report.summary.to_json() + "\n"), || {
        CommandEnd::met(ended == Outcome::Done, format!("verdict {}", found.verdict.name()))
            .row(["", "before", "after"])
            .row(["gap, σ".to_owned(), format!("{:.2}", found.gap_before), format!("{:.2}", found.gap_after)])
            .file(format!("{out}/report.html"))
            .file(format!("{out}/spindle.yaml"))
    })?;
    eprintln!("{}", place_words(&machine, sentence(found)));
    diagnosed.consequence.iter().for_each(|c| eprintln!("{}", place_words(&machine, c.words())));
    Ok(ended)
}

/// The missing change of a rotor without magnets.
fn diagnose_rotor(arguments: &Arguments, loaded: &Measurement, console: &Console) -> Result<Outcome, Failure> {
    let rotor = rotor_of_measurement(loaded, arguments.spindle.as_deref(), arguments.tool.as_deref())?;
    let given = [&arguments.spindle, &arguments.tool].into_iter().flatten();
    let read = given.chain([&arguments.measurement]);
    claim(&arguments.out, &["summary.json", "spindle.yaml"], read.map(String::as_str))?;
    let records = Records::of(loaded, None, &|| {})?;
    records.lines().for_each(|line| eprintln!("{line}"));
    let progress = Progress::start(console);
    progress.start_stage("resonances, antiresonances and changes that explain them");
    let (found, notes) = diagnose_taps(&rotor, loaded)?;
    arguments.timings.print(&progress.times());
    drop(progress);
    notes.iter().for_each(|note| eprintln!("{note}"));
    let folder = diagnosed_folder(&rotor, &found)?;
    console.writing(|| folder.write(Path::new(&arguments.out)))?;
    let text = format!("{:#}\n", json!({ "diagnosis": diagnosis_topic(&found) }));
    let met = is_explained(&found);
    console.json(&text, || {
        CommandEnd::met(met, format!("verdict {}", found.verdict.name()))
            .file(format!("{}/summary.json", arguments.out))
            .file(format!("{}/spindle.yaml", arguments.out))
    })?;
    eprintln!("{}", found.sentence());
    Ok(if met { Outcome::Done } else { Outcome::TargetMissed })
}
