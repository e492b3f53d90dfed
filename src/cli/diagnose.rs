//! `muspin diagnose`: find where simulation and measurement disagree, name the missing effect, show the gap shrink.
//! Writes the corrected spindle and tool, `summary.json`, the report and its pictures.

use super::console::{CommandEnd, Console};
use super::machine::of_measurement;
use super::output::{REPORT, claim};
use super::plausibility::Records;
use super::progress::Progress;
use super::reading::load_measurement;
use super::surroundings::Surroundings;
use super::timings::Timings;
use super::{Failure, Outcome};
use crate::controller::Controller;
use crate::diagnose::data::measurement::{ControlAxis, HammerTest, RecordSet};
use crate::diagnose::{DiagnoseError, Verdict, diagnose_with};
use crate::input::{Measurement as Loaded, spindle_yaml, tool_yaml};
use crate::pipeline::loop_stability::{growth_rate_at, unstable_words};
use crate::report::corrected_records::record_faults;
use crate::report::diagnosis::stage;
use crate::report::diagnosis_summary::DiagnosisSummary;
use crate::report::diagnosis_words::sentence;
use crate::report::identification::{PlausibilitySummary, file_name};
use crate::report::results::ResultsFolder;
use crate::report::summary::Summary;
use crate::report::whole::Report;
use serde::Serialize;

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

impl From<DiagnoseError> for Failure {
    fn from(error: DiagnoseError) -> Self {
        if let DiagnoseError::Record(record) = error {
            return record.into();
        }
        Self::new(error.to_string()).with_hint("check spindle, tool and measurement")
    }
}

/// A failure that names the measurement where the error itself does not name a file.
pub(super) fn name_failure(measurement: &str, error: DiagnoseError) -> Failure {
    let hint = match &error {
        DiagnoseError::NoSweep => "add a record of kind sweep to measurement.yaml",
        _ => return error.into(),
    };
    let file = measurement.trim_end_matches('/');
    Failure::new(format!("{file}/measurement.yaml: {error}")).with_hint(hint)
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let mut loaded = load_measurement(&arguments.measurement, console)?;
    let machine = of_measurement(&loaded, arguments.spindle.as_deref(), arguments.tool.as_deref())?;
    let known = Surroundings::of(&loaded, arguments.spindle.as_deref(), arguments.tool.as_deref(), &machine);
    let named = [&arguments.spindle, &arguments.tool].into_iter().flatten();
    let read = named.chain([&arguments.measurement]);
    claim(&arguments.out, &REPORT, read.map(String::as_str))?;
    let records = Records::of(&loaded, Some(&machine))?;
    records.say();
    let mut left_out = without_unknown_controllers(&mut loaded);
    left_out.iter().for_each(|record| eprintln!("{}", record.words()));
    left_out.extend(unused_rows(&loaded));
    let measurement = evidence(&loaded, &records.controllers);
    let progress = Progress::start(console);
    let alternatives = known.alternatives();
    let said = |what: &str| progress.start_stage(what);
    let found = diagnose_with(&machine, &measurement, &alternatives, &said)
        .map_err(|error| name_failure(&arguments.measurement, error))?;
    let mut unstable = vec![];
    for (hammer, controller) in loaded.hammers.iter().zip(&records.controllers) {
        let rpm = hammer.frf.speed_rpm;
        let growth = growth_rate_at(&found.corrected, controller, rpm)?;
        if growth >= 0.0 {
            let words = unstable_words(growth, rpm);
            unstable.push(format!("{}: with the corrected model {words}", hammer.name));
        }
    }
    arguments.timings.print(&progress.times());
    drop(progress);
    unstable.iter().for_each(|line| eprintln!("{line}"));
    let mut summary = Summary::new();
    summary.set("plausibility", PlausibilitySummary::of(&records.reports));
    summary.set("diagnosis", DiagnosisSummary::from(&found));
    let faults = record_faults(&found, &known.names);
    summary.set("diagnosis.record_faults", faults);
    if !left_out.is_empty() {
        summary.set("diagnosis.left_out", left_out);
    }
    let mut folder = ResultsFolder::new();
    folder.add("spindle.yaml", spindle_yaml(&found.corrected.spindle))?;
    folder.add("tool.yaml", tool_yaml(&found.corrected.tool))?;
    stage(&mut folder, &found)?;
    if !found.record_faults.is_empty() {
        known.stage_records(&mut folder, &loaded, &found)?;
    }
    let mut report = Report { folder, summary };
    console.writing(|| report.write(&arguments.out))?;
    let ended = match found.verdict {
        // The rotor was levitated: a model that cannot be is no explanation.
        _ if !unstable.is_empty() => Outcome::TargetMissed,
        Verdict::Unexplained => Outcome::TargetMissed,
        _ => Outcome::Done,
    };
    let out = arguments.out.as_str();
    console.json(&(report.summary.to_json() + "\n"), || {
        CommandEnd::met(ended == Outcome::Done, format!("verdict {}", found.verdict.name()))
            .row(["", "before", "after"])
            .row(["gap, σ".to_owned(), format!("{:.2}", found.gap_before), format!("{:.2}", found.gap_after)])
            .file(format!("{out}/report.html"))
            .file(format!("{out}/spindle.yaml"))
    })?;
    eprintln!("{}", sentence(&found));
    Ok(ended)
}

/// A record that a diagnosis cannot use.
#[derive(Serialize)]
pub(super) struct LeftOut {
    record: String,
    reason: String,
}

impl LeftOut {
    fn words(&self) -> String {
        let Self { record, reason } = self;
        format!("{record} is left out: {reason}")
    }
}

/// Takes out hammer tests under an unknown controller. A sweep needs none: its currents are measured.
pub(super) fn without_unknown_controllers(loaded: &mut Loaded) -> Vec<LeftOut> {
    let unknown = loaded.hammers.iter().filter(|h| h.controller.is_none());
    let left_out = unknown.map(|h| LeftOut {
        record: file_name(&h.name).to_owned(),
        reason:
            "its controller is unknown, and the levitated compliance depends on it; name the controller that levitated \
                 the rotor in `controller:`"
                .to_owned(),
    });
    let left_out = left_out.collect();
    loaded.hammers.retain(|h| h.controller.is_some());
    left_out
}

/// What of the sweeps their reader did not use.
pub(super) fn unused_rows(loaded: &Loaded) -> Vec<LeftOut> {
    let notes = loaded.sweeps.iter().flat_map(|sweep| {
        let record = file_name(&sweep.record.name);
        sweep.record.left_out.iter().map(move |note| LeftOut { record: record.to_owned(), reason: note.clone() })
    });
    notes.collect()
}

/// The records as the diagnosis takes them.
pub(super) fn evidence<'a>(loaded: &Loaded, controllers: &'a [Controller]) -> RecordSet<'a> {
    RecordSet {
        sweeps: loaded.sweeps.iter().map(|s| s.record.clone()).collect(),
        taps: loaded
            .hammers
            .iter()
            .zip(controllers)
            .map(|(h, k)| HammerTest {
                frf: h.frf.clone(),
                axis: if h.axis == 0 { ControlAxis::X } else { ControlAxis::Y },
                controller: k,
            })
            .collect(),
    }
}
