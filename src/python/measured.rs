//! The stages that begin with a measurement folder; each ends where it reports its progress after an interruption.

use super::compute::Stop;
use crate::input::{Measurement, load_measurement_watched};
use crate::report::updating::updating_topic;
use crate::report::whole::Report;
use crate::spindle::Machine;
use crate::update::{UpdateSettings, gauss_newton};
use crate::workflow::Failure;
use crate::workflow::diagnose::{diagnose_records, unused_rows, without_unknown_controllers};
use crate::workflow::identify::identify_records;
use crate::workflow::plausibility::Records;
use crate::workflow::surroundings::Surroundings;
use crate::workflow::update::{FitTargets, MachineUpdate, targets};

fn load(measurement: &str, stop: &Stop) -> Result<Measurement, Failure> {
    Ok(load_measurement_watched(measurement, &|_| stop.here())?)
}

/// Resonances, antiresonances and plausibility.
pub(super) fn identify(machine: &Machine, measurement: &str, stop: &Stop) -> Result<Report, Failure> {
    let loaded = load(measurement, stop)?;
    let records = Records::of(&loaded, Some(machine), &|| stop.here())?;
    Ok(identify_records(&loaded, Some(machine), &records, &|| stop.here())?.report(machine))
}

/// The machine with the measured frequencies.
pub(super) fn update(machine: &Machine, measurement: &str, stop: &Stop) -> Result<(Machine, Report), Failure> {
    let loaded = load(measurement, stop)?;
    let records = Records::of(&loaded, Some(machine), &|| stop.here())?;
    records.refuse_for_updating()?;
    let FitTargets { targets, identification, .. } = targets(&loaded, &records, machine, None)?;
    stop.here();
    let found = gauss_newton(machine, &targets, &UpdateSettings::default())?;
    let update = MachineUpdate {
        before: machine,
        delivered: &found,
        models: &[("updated", &found.fit)],
        records: &records,
        identification: identification.as_ref(),
    };
    let report = update.report(updating_topic(&found.fit))?;
    Ok((found.machine, report))
}

/// The corrected machine.
pub(super) fn diagnose(machine: &Machine, measurement: &str, stop: &Stop) -> Result<(Machine, Report), Failure> {
    let mut loaded = load(measurement, stop)?;
    let records = Records::of(&loaded, Some(machine), &|| stop.here())?;
    let mut left_out = without_unknown_controllers(&mut loaded);
    left_out.extend(unused_rows(&loaded));
    let known = Surroundings::of(&loaded, None, None, machine);
    let found = diagnose_records(machine, &loaded, &records, &known, &|_| stop.here())?;
    let report = found.report(&loaded, &records, &known, &left_out)?;
    Ok((found.found.corrected, report))
}
