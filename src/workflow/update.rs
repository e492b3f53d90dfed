//! The moduli of a machine from the frequencies of a measurement, with their verdict.

use super::failure::Failure;
use super::identify::record_at_rest;
use super::plausibility::{Records, name_record};
use crate::identify::{Identification, identify};
use crate::input::{Measurement, rotor_yaml, spindle_yaml, tool_yaml};
use crate::report::identification::{file_name, identification_topic, plausibility_topic};
use crate::report::updating::{error_table, errors_of, figures, shape_table, updating_topic};
use crate::report::whole::Report;
use crate::rotor::Rotor;
use crate::spindle::{Machine, RotorOnSupports};
use crate::update::machine::identified_targets;
use crate::update::{PlacedTap, Target, Targets, UpdateError, Updated, UpdatedMachine, front_and_rear, hammer_targets};
use serde_json::Value;

/// Whether moduli explain the frequencies of plausible records, and the sentence about it.
fn verdict<'a>(fit: &'a Updated, records: &Records) -> (bool, &'a str) {
    (fit.explanation.explained && records.plausible(), &fit.explanation.statement)
}

/// What moduli are fitted to.
pub(crate) struct FitTargets {
    /// Frequencies and mode shapes.
    pub(crate) targets: Targets,
    /// What the sweep at rest says, where there is one.
    pub(crate) identification: Option<Identification>,
    /// Records that are left out, in words.
    pub(crate) notes: Vec<String>,
}

/// What to fit: the standstill sweep where there is one, else frequencies that were read off. The crossed FRFs of a
/// sweep are held out.
pub(crate) fn targets(
    measurement: &Measurement,
    records: &Records,
    machine: &Machine,
    relative_deviation: Option<f64>,
) -> Result<FitTargets, Failure> {
    let (mut identification, mut notes) = (None, vec![]);
    let mut targets = if let Some((frf, _)) = records.standstill() {
        let found = identify(frf, machine).map_err(|e| name_record(e, &record_at_rest(measurement)))?;
        let targets = identified_targets(machine, &found);
        identification = Some(found);
        targets
    } else if let Some(read) = measurement.frequencies.first() {
        let list = |frequencies: &[Option<f64>]| read_off(frequencies, relative_deviation);
        front_and_rear(machine, list(&read.resonances_hz), list(&read.front_hz), list(&read.rear_hz))
    } else if records.frfs.is_empty() {
        let plane_m = machine.tool_plane_m();
        let springs = |axis| machine.supports().iter().map(|support| support.spring(axis)).collect();
        let (found, left_out) = taps_of(measurement, &machine.rotor()?, plane_m, &springs)?;
        notes = left_out;
        found
    } else {
        return Err(UpdateError::NoTargets { what: "neither a sweep at 0 rpm nor frequencies" }.into());
    };
    targets.mode_shapes = measurement.mode_shapes.clone();
    Ok(FitTargets { targets, identification, notes })
}

/// Targets that a person has read off.
pub(crate) fn read_off(frequencies: &[Option<f64>], relative_deviation: Option<f64>) -> Vec<Option<Target>> {
    let target = |f: f64| Target::free(f, relative_deviation.map(|r| r * f));
    frequencies.iter().map(|f| f.map(target)).collect()
}

/// Targets of the hammer tests at rest that no controller levitates, and which of these are left out. `springs` are
/// those of the model in an axis.
pub(crate) fn taps_of(
    measurement: &Measurement,
    rotor: &Rotor,
    tool_plane_m: f64,
    springs: &dyn Fn(usize) -> Vec<(f64, f64)>,
) -> Result<(Targets, Vec<String>), Failure> {
    let mut free = measurement.hammers.iter().filter(|h| h.controller.is_none() && h.frf.speed_rpm == 0.0);
    let Some(first) = free.next() else {
        return Err(UpdateError::NoTargets {
            what: "neither a sweep at 0 rpm nor frequencies nor a hammer test at 0 rpm without a controller",
        }
        .into());
    };
    let (mut taps, mut notes) = (vec![first], vec![]);
    for hammer in free {
        if hammer.axis == first.axis && hammer.frf.frequency_hz == first.frf.frequency_hz {
            taps.push(hammer);
        } else {
            notes.push(format!("note: {}: axis or lines differ from those of {}: left out", hammer.name, first.name));
        }
    }
    let placed: Vec<PlacedTap> = taps
        .iter()
        .map(|hammer| PlacedTap {
            name: file_name(&hammer.name),
            frf: &hammer.frf,
            places_m: hammer.places_m.unwrap_or([tool_plane_m; 2]),
        })
        .collect();
    Ok((hammer_targets(rotor, springs(first.axis), &placed)?, notes))
}

pub(crate) struct MachineUpdate<'a> {
    pub(crate) before: &'a Machine,
    pub(crate) delivered: &'a UpdatedMachine,
    /// The fits by name, the delivered one first.
    pub(crate) models: &'a [(&'a str, &'a Updated)],
    pub(crate) records: &'a Records,
    pub(crate) identification: Option<&'a Identification>,
}

impl MachineUpdate<'_> {
    /// Figures, the updated files, tables and pictures; `updating` is that topic.
    pub(crate) fn report(&self, updating: Value) -> Result<Report, Failure> {
        let Machine { spindle, tool, .. } = &self.delivered.machine;
        let mut report = Report::of("update", &self.delivered.machine);
        let summary = &mut report.summary;
        if let Some(found) = self.identification {
            summary.set("identification", identification_topic(found));
        }
        if !self.records.reports.is_empty() {
            summary.set("plausibility", plausibility_topic(&self.records.reports));
        }
        summary.set("updating", updating);
        let (met, sentence) = verdict(&self.delivered.fit, self.records);
        report.verdict(met, sentence);
        add_fits(&mut report, Some(self.before), self.models)?;
        report.folder.add("spindle.yaml", spindle_yaml(spindle))?;
        if tool.sections.iter().any(|s| s.region.is_some()) {
            report.folder.add("tool.yaml", tool_yaml(tool))?;
        }
        Ok(report)
    }
}

/// Figures, the updated files, tables and pictures of a rotor without magnets.
pub(crate) fn updated_rotor_report(rotor: &RotorOnSupports, fit: &Updated) -> Result<Report, Failure> {
    let mut report = Report::of_rotor("update", rotor);
    report.summary.set("updating", updating_topic(fit));
    report.verdict(fit.explanation.explained, &fit.explanation.statement);
    add_fits(&mut report, None, &[("updated", fit)])?;
    let mut updated = rotor.clone();
    fit.scale(&mut updated.sections);
    report.folder.add("spindle.yaml", rotor_yaml(&updated))?;
    if let Some(tool) = &mut updated.tool {
        fit.scale(&mut tool.sections);
        report.folder.add("tool.yaml", tool_yaml(tool))?;
    }
    Ok(report)
}

/// Adds tables and pictures of fits, the delivered one first.
fn add_fits(report: &mut Report, before: Option<&Machine>, models: &[(&str, &Updated)]) -> Result<(), Failure> {
    report.folder.add_table("errors.csv", &error_table(&errors_of(models)))?;
    if let Some((_, fit)) = models.first().filter(|(_, fit)| !fit.shapes.is_empty()) {
        report.folder.add_table("mode_shapes.csv", &shape_table(&fit.shapes))?;
    }
    Ok(report.figures(figures(before, models))?)
}
