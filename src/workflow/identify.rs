//! What the records of a measurement say of the free rotor.

use super::failure::Failure;
use super::plausibility::{Records, name_record};
use crate::identify::{Identification, IdentifyError, identify, pole_drift};
use crate::input::Measurement;
use crate::report::identification::{
    DriftSummary, HammerSummary, identification_topic, plausibility_topic, response_files, roving_sets,
};
use crate::report::pictures::Picture;
use crate::report::plot::measured::measured_plant;
use crate::report::results::ResultsFolder;
use crate::report::summary::omit_absent;
use crate::report::whole::Report;
use crate::spindle::Machine;
use serde_json::{Value, json};

/// What a measurement says of the free rotor, and its responses.
pub(crate) struct IdentifiedRecords {
    /// Plausibility, peaks, drift, hammer tests, files of the responses.
    pub(crate) answer: Value,
    /// Plausibility and responses with their covariance as CSV.
    pub(crate) folder: ResultsFolder,
    /// Resonances and antiresonances, from a sweep at rest.
    pub(crate) peaks: Option<Identification>,
    /// What the resonances did over the repeats.
    pub(crate) drift: Option<DriftSummary>,
    pub(crate) hammers: Vec<HammerSummary>,
    plausible: bool,
}

impl IdentifiedRecords {
    /// Number of resonances in the hammer tests.
    pub(crate) fn of_hammers(&self) -> usize {
        self.hammers.iter().map(|h| h.resonances_hz.len()).sum()
    }

    /// Whether no record contradicts the machine, and the sentence about it.
    pub(crate) fn verdict(&self) -> (bool, String) {
        let words = match (self.plausible, &self.peaks) {
            (false, _) => "a record contradicts the machine".to_owned(),
            (true, None) => format!(
                "{} resonances in the hammer tests; with magnets, antiresonances and the free rotor need a sweep at \
                 rest",
                self.of_hammers()
            ),
            (true, Some(found)) => format!("{} resonances of the free rotor", found.resonances.len()),
        };
        (self.plausible, words)
    }

    /// The report of a machine, with the files.
    pub(crate) fn report(&mut self, machine: &Machine) -> Report {
        let (met, sentence) = self.verdict();
        let mut report = Report::of("identify", machine);
        report.folder = std::mem::take(&mut self.folder);
        report.verdict(met, &sentence);
        for (key, value) in self.answer.as_object().into_iter().flatten() {
            report.summary.set(key, value.clone());
        }
        report
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
    let plausibility = plausibility_topic(&records.reports);
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
    folder.add("plausibility.json", format!("{:#}\n", plausibility))?;
    let mut names = vec![];
    for (name, text) in response_files(frfs, &measurement.hammers) {
        folder.add(&name, text)?;
        names.push(name);
    }
    for (k, frf) in frfs.iter().enumerate() {
        for (detail, figure) in measured_plant(frf) {
            let detail = if k == 0 { detail } else { format!("{detail}-{}", k + 1) };
            folder.add_plot(Picture::Measured.with_detail(detail), &figure)?;
        }
    }
    let hammers: Vec<HammerSummary> =
        roving_sets(&measurement.hammers).iter().map(|set| HammerSummary::of(set)).collect();
    for (k, shapes) in hammers.iter().filter_map(HammerSummary::shapes_csv).enumerate() {
        let name = format!("mode_shapes-{k}.csv");
        folder.add(&name, shapes)?;
        names.push(name);
    }
    let drift = drift.as_ref().map(DriftSummary::from);
    let answer = json!({
        "plausibility": plausibility,
        "identification": peaks.as_ref().map(identification_topic),
        "drift": drift,
        "hammers": (!hammers.is_empty()).then_some(&hammers),
        "records": names,
    });
    let answer = omit_absent(answer, &["identification", "drift", "hammers"]);
    Ok(IdentifiedRecords { answer, folder, peaks, drift, hammers, plausible: records.plausible() })
}

/// File of the first sweep at standstill.
pub(crate) fn record_at_rest(measurement: &Measurement) -> String {
    let mut sweeps = measurement.sweeps.iter().map(|s| &s.record);
    let found = sweeps.find(|r| r.speed_rpm == 0.0);
    found.map_or(String::new(), |r| r.name.clone())
}
