//! The moduli of a machine from the frequencies of a measurement, with their verdict.

use super::failure::Failure;
use super::identify::record_at_rest;
use super::plausibility::{Records, name_record};
use crate::identify::{Identification, identify};
use crate::input::{Measurement, spindle_yaml, tool_yaml};
use crate::report::results::ResultsFolder;
use crate::report::updating::{error_table, figures, shape_table};
use crate::spindle::Machine;
use crate::update::machine::identified_targets;
use crate::update::{Target, Targets, UpdateError, Updated, UpdatedMachine, front_and_rear};

/// Whether moduli explain the frequencies of plausible records, and the sentence about it.
pub(crate) fn verdict<'a>(fit: &'a Updated, records: &Records) -> (bool, &'a str) {
    (fit.explanation.explained && records.plausible(), &fit.explanation.statement)
}

/// What to fit: the standstill sweep where there is one, else frequencies that were read off. The crossed FRFs of a
/// sweep are held out.
pub(crate) fn targets(
    measurement: &Measurement,
    records: &Records,
    machine: &Machine,
    relative_deviation: Option<f64>,
) -> Result<(Targets, Option<Identification>), Failure> {
    let mut identification = None;
    let mut targets = if let Some((frf, _)) = records.standstill() {
        let found = identify(frf, machine).map_err(|e| name_record(e, &record_at_rest(measurement)))?;
        let targets = identified_targets(machine, &found);
        identification = Some(found);
        targets
    } else if let Some(read) = measurement.frequencies.first() {
        let list = |frequencies: &[Option<f64>]| {
            let each = |f: &Option<f64>| {
                f.map(|f| Target { frequency_hz: f, standard_deviation_hz: relative_deviation.map(|r| r * f) })
            };
            frequencies.iter().map(each).collect()
        };
        front_and_rear(machine, list(&read.resonances_hz), list(&read.front_hz), list(&read.rear_hz))
    } else {
        return Err(UpdateError::NoTargets { what: "neither a sweep at 0 rpm nor frequencies" }.into());
    };
    targets.mode_shapes = measurement.mode_shapes.clone();
    Ok((targets, identification))
}

/// The updated files, tables and pictures.
///
/// # Errors
/// [`Failure`] when a picture cannot be drawn.
pub(crate) fn updated_folder(
    before: &Machine,
    delivered: &UpdatedMachine,
    models: &[(&str, &Updated)],
) -> Result<ResultsFolder, Failure> {
    let mut folder = ResultsFolder::new();
    folder.add("spindle.yaml", spindle_yaml(&delivered.machine.spindle))?;
    folder.add_table("errors.csv", &error_table(models))?;
    let tool = &delivered.machine.tool;
    if tool.sections.iter().any(|s| s.region.is_some()) {
        folder.add("tool.yaml", tool_yaml(tool))?;
    }
    if !delivered.fit.shapes.is_empty() {
        let table = shape_table(&delivered.fit.shapes);
        folder.add_table("mode_shapes.csv", &table)?;
    }
    for (name, figure) in figures(before, models) {
        folder.add_plot(name, &figure)?;
    }
    Ok(folder)
}
