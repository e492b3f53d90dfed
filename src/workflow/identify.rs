//! What the records of a measurement say of the free rotor.

use super::failure::Failure;
use super::plausibility::{Records, name_record};
use crate::identify::{Identification, IdentifyError, identify, pole_drift};
use crate::input::Measurement;
use crate::report::identification::{
    DriftSummary, HammerSummary, IdentificationSummary, PlausibilitySummary, response_files,
};
use crate::report::results::ResultsFolder;
use crate::report::summary::json;
use crate::spindle::Machine;
use serde::Serialize;

/// What a measurement says of the free rotor, and its responses.
pub(crate) struct IdentifiedRecords {
    pub(crate) answer: Answer,
    /// Plausibility and responses with their covariance as CSV.
    pub(crate) folder: ResultsFolder,
    /// Resonances and antiresonances, from a sweep at rest.
    pub(crate) peaks: Option<Identification>,
    plausible: bool,
}

impl IdentifiedRecords {
    /// Number of resonances in the hammer tests.
    pub(crate) fn of_hammers(&self) -> usize {
        self.answer.hammers.iter().map(|h| h.resonances_hz.len()).sum()
    }

    /// Whether no record contradicts the machine, and the sentence about it.
    pub(crate) fn verdict(&self) -> (bool, String) {
        let words = match (self.plausible, &self.peaks) {
            (false, _) => "a record contradicts the machine".to_owned(),
            (true, None) => format!(
                "{} resonances in the hammer tests; antiresonances, and the rotor without its magnets, need a sweep at \
                 rest",
                self.of_hammers()
            ),
            (true, Some(found)) => format!("{} resonances of the free rotor", found.resonances.len()),
        };
        (self.plausible, words)
    }
}

/// Identifies the free rotor from records that are estimated already; a rotor without magnets has no machine.
/// `watch` is called on the way.
pub(crate) fn identify_records(
    measurement: &Measurement,
    machine: Option<&Machine>,
    records: &Records,
    watch: &dyn Fn(),
) -> Result<IdentifiedRecords, Failure> {
    let frfs = &records.frfs;
    if frfs.is_empty() && measurement.hammers.is_empty() {
        let folder = measurement.folder.display();
        return Err(Failure::new(format!("{folder}: no record of kind sweep or hammer")).with_hint(
            "identification needs a sweep; frequencies that are known already go straight into `muspin \
            update`",
        ));
    }
    let plausibility = PlausibilitySummary::of(&records.reports);
    let (mut peaks, mut drift) = (None, None);
    if let (Some((frf, report)), Some(machine)) = (records.standstill(), machine) {
        // Units and order of channels decide what the magnets' stiffness shifts: no peaks from an implausible record.
        if report.plausible() {
            let at_rest = |e| name_record(e, &record_at_rest(measurement));
            watch();
            let found = identify(frf, machine).map_err(at_rest)?;
            if let Some(sweep) = measurement.sweeps.iter().find(|s| s.record.speed_rpm == 0.0) {
                watch();
                drift = pole_drift(&sweep.record, frf, machine, &found).map_err(at_rest)?;
            }
            peaks = Some(found);
        }
    } else if let Some(frf) = frfs.first() {
        return Err(IdentifyError::NotAtRest { speed_rpm: frf.speed_rpm }.into());
    }
    let mut folder = ResultsFolder::new();
    folder.add("plausibility.json", format!("{:#}\n", json(&plausibility)))?;
    let mut names = vec![];
    for (name, text) in response_files(frfs, &measurement.hammers) {
        folder.add(&name, text)?;
        names.push(name);
    }
    let answer = Answer {
        plausibility,
        identification: peaks.as_ref().map(IdentificationSummary::from),
        drift: drift.as_ref().map(DriftSummary::from),
        hammers: measurement.hammers.iter().map(HammerSummary::of).collect(),
        records: names,
    };
    Ok(IdentifiedRecords { answer, folder, peaks, plausible: records.plausible() })
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct Answer {
    plausibility: PlausibilitySummary,
    #[serde(skip_serializing_if = "Option::is_none")]
    identification: Option<IdentificationSummary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) drift: Option<DriftSummary>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) hammers: Vec<HammerSummary>,
    /// Files of the responses.
    records: Vec<String>,
}

/// File of the first sweep at standstill.
pub(crate) fn record_at_rest(measurement: &Measurement) -> String {
    let mut sweeps = measurement.sweeps.iter().map(|s| &s.record);
    let found = sweeps.find(|r| r.speed_rpm == 0.0);
    found.map_or(String::new(), |r| r.name.clone())
}
