//! The stages of a spindle for a program that embeds muspin: what the commands do, with values instead of files.

use super::Failure;
use super::diagnose::{evidence, name_failure, unused_rows, without_unknown_controllers};
use super::plausibility::{Records, controllers};
use super::surroundings::Surroundings;
use super::update::targets;
use crate::augment::weights::Weights;
use crate::diagnose::diagnose_with;
use crate::input::load_measurement;
use crate::pipeline::comparison::predict;
use crate::pipeline::design::{Design, design};
use crate::pipeline::settings::DesignSettings;
use crate::report::corrected_records::record_faults;
use crate::report::design_summary::DesignSummary;
use crate::report::diagnosis_summary::DiagnosisSummary;
use crate::report::identification::{IdentificationSummary, PlausibilitySummary};
use crate::report::prediction_summary::{SensitivitySummary, StiffnessSummary};
use crate::report::summary::{Summary, json};
use crate::report::updating::UpdatingSummary;
use crate::spindle::Machine;
use crate::update::{UpdateSettings, gauss_newton};
use serde_json::Value;

/// The machine with the measured frequencies, and the figures of `muspin update`.
///
/// # Errors
/// [`Failure`] as `muspin update` tells it.
pub(crate) fn update_machine(machine: &Machine, measurement: &str) -> Result<(Machine, Value), Failure> {
    let loaded = load_measurement(measurement)?;
    let records = Records::of(&loaded, machine)?;
    records.refuse_for_updating()?;
    let (targets, identification) = targets(&loaded, &records, machine, None)?;
    let found = gauss_newton(machine, &targets, &UpdateSettings::default())?;
    let mut summary = Summary::new();
    if let Some(peaks) = &identification {
        summary.set("identification", IdentificationSummary::from(peaks));
    }
    summary.set("plausibility", PlausibilitySummary::of(&records.reports));
    summary.set("updating", UpdatingSummary::from(&found.fit));
    Ok((found.machine, summary.value()))
}

/// A design and the figures of `muspin design`; `progress` is called whenever a stage or a step has ended.
///
/// # Errors
/// [`Failure`] as `muspin design` tells it.
pub(crate) fn design_controller(
    machine: &Machine,
    weights: &Weights,
    polish: bool,
    progress: &(dyn Fn() + Sync),
) -> Result<(Design, Value), Failure> {
    let settings = if polish { DesignSettings::with_polish() } else { DesignSettings::default() };
    let found = design(machine, weights, &settings, &mut |_| progress())?;
    let rest = predict(machine, &found.delivery.controller, 0.0)?;
    let mut summary = Summary::new();
    summary.set("design", DesignSummary::from(&found));
    summary.set("stiffness.mu", StiffnessSummary::of(&rest));
    summary.set("sensitivity.mu", SensitivitySummary::of(&rest));
    Ok((found, summary.value()))
}

/// The corrected machine, and the figures of `muspin diagnose`; `progress` is called whenever a stage begins.
///
/// # Errors
/// [`Failure`] as `muspin diagnose` tells it.
pub(crate) fn diagnose_machine(
    machine: &Machine,
    measurement: &str,
    progress: &(dyn Fn() + Sync),
) -> Result<(Machine, Value), Failure> {
    let mut loaded = load_measurement(measurement)?;
    let mut left_out = without_unknown_controllers(&mut loaded);
    left_out.extend(unused_rows(&loaded));
    let controllers = controllers(&loaded)?;
    let known = Surroundings::of(&loaded, None, None, machine);
    let records = evidence(&loaded, &controllers);
    let found = diagnose_with(machine, &records, &known.alternatives(), &|_: &str| progress())
        .map_err(|error| name_failure(measurement, error))?;
    let mut summary = json(DiagnosisSummary::from(&found));
    if let Value::Object(map) = &mut summary {
        let faults = record_faults(&found, &known.names);
        map.insert("record_faults".into(), json(faults));
        if !left_out.is_empty() {
            map.insert("left_out".into(), json(left_out));
        }
    }
    Ok((found.corrected, summary))
}
