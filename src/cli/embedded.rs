//! The stages of a spindle for a program that embeds muspin: what the commands do, with values instead of files.

use super::Failure;
use super::diagnose::{evidence, name_failure, unused_rows, without_unknown_controllers};
use super::identify::identify_records;
use super::plausibility::{Records, controllers};
use super::surroundings::Surroundings;
use super::update::{targets, updated_folder};
use crate::diagnose::{Verdict, diagnose_with};
use crate::input::load_measurement;
use crate::report::corrected_records::record_faults;
use crate::report::diagnosis::stage;
use crate::report::diagnosis_summary::DiagnosisSummary;
use crate::report::diagnosis_words::sentence;
use crate::report::identification::{IdentificationSummary, PlausibilitySummary};
use crate::report::summary::json;
use crate::report::updating::UpdatingSummary;
use crate::report::whole::Report;
use crate::spindle::Machine;
use crate::update::{UpdateSettings, gauss_newton};
use serde_json::Value;

/// The machine with the measured frequencies, and the figures of `muspin update`.
///
/// # Errors
/// [`Failure`] as `muspin update` tells it.
pub(crate) fn update_machine(machine: &Machine, measurement: &str) -> Result<(Machine, Report), Failure> {
    let loaded = load_measurement(measurement)?;
    let records = Records::of(&loaded, Some(machine))?;
    records.refuse_for_updating()?;
    let (targets, identification) = targets(&loaded, &records, machine, None)?;
    let found = gauss_newton(machine, &targets, &UpdateSettings::default())?;
    let mut report = Report::of("update", &found.machine);
    let summary = &mut report.summary;
    if let Some(peaks) = &identification {
        summary.set("identification", IdentificationSummary::from(peaks));
    }
    summary.set("plausibility", PlausibilitySummary::of(&records.reports));
    summary.set("updating", UpdatingSummary::from(&found.fit));
    report.verdict(found.fit.explanation.explained && records.plausible(), &found.fit.explanation.statement);
    report.folder = updated_folder(machine, &found, &[("updated", &found.fit)])?;
    Ok((found.machine, report))
}

/// Resonances, antiresonances and plausibility of a measurement, with the figures of `muspin identify`.
///
/// # Errors
/// [`Failure`] as `muspin identify` tells it.
pub(crate) fn identify_measurement(machine: &Machine, measurement: &str) -> Result<Report, Failure> {
    let loaded = load_measurement(measurement)?;
    let records = Records::of(&loaded, Some(machine))?;
    let found = identify_records(&loaded, Some(machine), &records)?;
    let mut report = Report { folder: found.folder, ..Report::of("identify", machine) };
    let plausible = records.plausible();
    report.verdict(plausible, if plausible { "the records are plausible" } else { "a record contradicts the machine" });
    if let Value::Object(topics) = json(&found.answer) {
        topics.into_iter().for_each(|(key, value)| report.summary.set(&key, value));
    }
    Ok(report)
}

/// The corrected machine, and the figures of `muspin diagnose`; `progress` is called whenever a stage begins.
///
/// # Errors
/// [`Failure`] as `muspin diagnose` tells it.
pub(crate) fn diagnose_machine(
    machine: &Machine,
    measurement: &str,
    progress: &(dyn Fn() + Sync),
) -> Result<(Machine, Report), Failure> {
    let mut loaded = load_measurement(measurement)?;
    let mut left_out = without_unknown_controllers(&mut loaded);
    left_out.extend(unused_rows(&loaded));
    let controllers = controllers(&loaded)?;
    let known = Surroundings::of(&loaded, None, None, machine);
    let records = evidence(&loaded, &controllers);
    let found = diagnose_with(machine, &records, &known.alternatives(), &|_: &str| progress())
        .map_err(|error| name_failure(measurement, error))?;
    let mut report = Report::of("diagnose", machine);
    report.verdict(found.verdict != Verdict::Unexplained, &sentence(&found));
    let summary = &mut report.summary;
    summary.set("diagnosis", DiagnosisSummary::from(&found));
    summary.set("diagnosis.record_faults", record_faults(&found, &known.names));
    if !left_out.is_empty() {
        summary.set("diagnosis.left_out", left_out);
    }
    stage(&mut report.folder, &found)?;
    Ok((found.corrected, report))
}
