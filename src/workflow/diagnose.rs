//! The missing effect of a machine from the records of a measurement, with its verdict.

use super::failure::Failure;
use super::plausibility::Records;
use super::surroundings::Surroundings;
use crate::controller::Controller;
use crate::diagnose::data::measurement::{ControlAxis, HammerTest, RecordSet};
use crate::diagnose::locate::recovered_law::Law;
use crate::diagnose::{DiagnoseError, Diagnosis, Verdict, diagnose_with};
use crate::input::{Measurement, machine_files};
use crate::pipeline::PipelineError;
use crate::pipeline::consequence::{Consequence, LoopOutcome};
use crate::pipeline::loop_stability::unstable_words;
use crate::report::corrected_records::record_faults;
use crate::report::diagnosis::stage;
use crate::report::diagnosis_summary::{consequence_topic, diagnosis_topic};
use crate::report::identification::{file_name, plausibility_topic};
use crate::report::page_summary::diagnosis_verdict;
use crate::report::whole::Report;
use crate::spindle::Machine;
use crate::spindle::correction::{ModelCorrection, RecoveredLaw};
use serde::Serialize;

/// A failure that names the measurement where the error itself does not name a file.
fn name_failure(measurement: &str, error: DiagnoseError) -> Failure {
    let hint = match &error {
        DiagnoseError::NoSweep => "add a record of kind sweep to measurement.yaml",
        _ => return error.into(),
    };
    let file = measurement.trim_end_matches('/');
    Failure::new(format!("{file}/measurement.yaml: {error}")).with_hint(hint)
}

/// A diagnosis with what it says of the records.
pub(crate) struct DiagnosedRecords {
    pub(crate) found: Diagnosis,
    /// Hammer tests whose loop is unstable with the corrected machine, in words.
    pub(crate) unstable: Vec<String>,
    /// Hammer tests of which no arithmetic tells whether their loop is stable, in words.
    pub(crate) unjudged: Vec<String>,
    /// What the corrected machine changes for the first of them, where the records are explained or a model takes the
    /// law that explains them without a name.
    pub(crate) consequence: Option<Consequence>,
}

impl DiagnosedRecords {
    /// Whether the discrepancy is explained. The rotor was levitated: a model that cannot be is no explanation.
    pub(crate) fn is_explained(&self) -> bool {
        self.unstable.is_empty() && self.found.verdict != Verdict::Unexplained
    }

    /// Figures, the corrected files and tables.
    pub(crate) fn report(
        &self,
        loaded: &Measurement,
        records: &Records,
        known: &Surroundings,
        left_out: &[LeftOut],
    ) -> Result<Report, Failure> {
        let found = &self.found;
        let mut report = Report::of("diagnose", &found.corrected);
        let names: Vec<&str> = found.effects.iter().map(|e| e.effect.kind.name()).collect();
        let words = diagnosis_verdict(found.verdict.name(), &names).into_iter().map(|(_, words)| words);
        let words: Vec<String> = words.chain(self.unstable.iter().chain(&self.unjudged).cloned()).collect();
        report.verdict(self.is_explained(), &words.join("; "));
        let summary = &mut report.summary;
        summary.set("plausibility", plausibility_topic(&records.reports));
        summary.set("diagnosis", diagnosis_topic(found));
        summary.set("diagnosis.record_faults", record_faults(found, &known.names));
        if let Some(consequence) = &self.consequence {
            summary.set("diagnosis.consequence", consequence_topic(consequence));
        }
        if !left_out.is_empty() {
            summary.set("diagnosis.left_out", left_out);
        }
        let folder = &mut report.folder;
        for (name, text) in machine_files(&found.corrected) {
            folder.add(name, text)?;
        }
        stage(folder, found)?;
        if !found.record_faults.is_empty() {
            known.stage_records(folder, loaded, found)?;
        }
        Ok(report)
    }
}

/// Diagnoses a machine from records that are estimated already; `said` hears of every stage that begins.
pub(crate) fn diagnose_records(
    machine: &Machine,
    loaded: &Measurement,
    records: &Records,
    known: &Surroundings,
    said: &(dyn Fn(&str) + Sync),
) -> Result<DiagnosedRecords, Failure> {
    let evidence = evidence(loaded, &records.controllers);
    let found = diagnose_with(machine, &evidence, &known.alternatives(), said)
        .map_err(|error| name_failure(&loaded.folder.display().to_string(), error))?;
    let unnamed = with_recovered_law(&found);
    let (mut unstable, mut unjudged, mut consequence) = (vec![], vec![], None);
    for (hammer, controller) in loaded.hammers.iter().zip(&records.controllers) {
        let rpm = hammer.frf.speed_rpm;
        let corrected = match LoopOutcome::of(&found.corrected, controller, rpm) {
            Ok(corrected) => corrected,
            Err(error @ PipelineError::Numeric { .. }) => {
                unjudged.push(format!("{}: its loop is not judged: {error}", hammer.name));
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        if corrected.growth_rate_per_s >= 0.0 {
            let words = unstable_words(corrected.growth_rate_per_s, rpm);
            unstable.push(format!("{}: with the corrected model {words}", hammer.name));
        } else if consequence.is_none() && (unnamed.is_some() || found.verdict != Verdict::Unexplained) {
            let record = file_name(&hammer.name).to_owned();
            let given = LoopOutcome::of(machine, controller, rpm)?;
            let corrected = unnamed.as_ref().map_or(Ok(corrected), |own| LoopOutcome::of(own, controller, rpm))?;
            consequence = Some(Consequence { record, speed_rpm: rpm, given, corrected });
        }
    }
    Ok(DiagnosedRecords { found, unstable, unjudged, consequence })
}

/// The machine with the law that was recovered without a name; none where there is no such law, or where no model takes
/// it.
fn with_recovered_law(found: &Diagnosis) -> Option<Machine> {
    let (_, port) = found.correction.as_ref().zip(found.localisation.named_port())?;
    let laws: Vec<RecoveredLaw> = port.laws.iter().map(Law::to_recovered).collect();
    let correction = ModelCorrection::fit(&port.place.name_in_files(), &laws, String::new()).ok()?;
    found.corrected.clone().with_correction(correction).ok()
}

/// A record that a diagnosis cannot use.
#[derive(Serialize)]
pub(crate) struct LeftOut {
    record: String,
    reason: String,
}

impl LeftOut {
    pub(crate) fn words(&self) -> String {
        let Self { record, reason } = self;
        format!("{record} is left out: {reason}")
    }
}

/// Takes out hammer tests under an unknown controller. A sweep needs none: its currents are measured.
pub(crate) fn without_unknown_controllers(loaded: &mut Measurement) -> Vec<LeftOut> {
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
pub(crate) fn unused_rows(loaded: &Measurement) -> Vec<LeftOut> {
    let notes = loaded.sweeps.iter().flat_map(|sweep| {
        let record = file_name(&sweep.record.name);
        sweep.record.left_out.iter().map(move |note| LeftOut { record: record.to_owned(), reason: note.clone() })
    });
    notes.collect()
}

/// The records as the diagnosis takes them.
fn evidence<'a>(loaded: &Measurement, controllers: &'a [Controller]) -> RecordSet<'a> {
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
