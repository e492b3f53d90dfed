//! `muspin identify`: are the records plausible; measured sweeps to FRFs with covariance, resonances and antiresonances
//! of the free-free rotor; resonances of hammer tests (JSON).

use super::console::{CommandEnd, Console};
use super::machine::{of_measurement, rotor_of_measurement};
use super::output::claim;
use super::plausibility::{Records, name_record};
use super::reading::load_measurement;
use super::{Failure, Outcome};
use crate::identify::{Identification, IdentifyError, Reading, identify, pole_drift};
use crate::input::{Measurement, is_rotor};
use crate::report::identification::{
    DriftSummary, HammerSummary, IdentificationSummary, PlausibilitySummary, response_files,
};
use crate::report::results::ResultsFolder;
use crate::report::summary::json;
use crate::spindle::Machine;
use serde::Serialize;
use std::path::Path;

/// Arguments of `muspin identify`.
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
    /// Folder for the FRFs with their covariance as CSV
    #[arg(long)]
    out: Option<String>,
}

impl From<IdentifyError> for Failure {
    fn from(error: IdentifyError) -> Self {
        let hint = match &error {
            IdentifyError::Singular { .. } => "the four injections must differ: one axis each, at every line",
            IdentifyError::NotAtRest { .. } => "add a sweep taken at 0 rpm to the measurement",
            IdentifyError::NoResonance { .. } => "check frequency range, line spacing and excitation of the sweep",
            _ => "check the record",
        };
        Self::new(error.to_string()).with_hint(hint)
    }
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let measurement = load_measurement(&arguments.measurement, console)?;
    let (spindle, tool) = (arguments.spindle.as_deref(), arguments.tool.as_deref());
    let machine = if is_rotor(spindle.unwrap_or(&measurement.spindle)) {
        rotor_of_measurement(&measurement, spindle, tool)?;
        None
    } else {
        Some(of_measurement(&measurement, spindle, tool)?)
    };
    if let Some(out) = &arguments.out {
        let named = [&arguments.spindle, &arguments.tool].into_iter().flatten();
        let read = named.chain([&arguments.measurement]);
        claim(out, &[], read.map(String::as_str))?;
    }
    let records = Records::of(&measurement, machine.as_ref())?;
    records.say();
    let found = identify_records(&measurement, machine.as_ref(), &records)?;
    if let Some(out) = &arguments.out {
        console.writing(|| found.folder.write(Path::new(out)))?;
    }
    let answer = &found.answer;
    console.json(&format!("{:#}\n", json(answer)), || {
        let shown = show_identification(arguments, &records, &found);
        answer.drift.iter().fold(shown, |shown, drift| shown.row([drift.words()]))
    })?;
    Ok(if records.plausible() { Outcome::Done } else { Outcome::TargetMissed })
}

/// What a measurement says of the free rotor, and its responses.
pub(super) struct IdentifiedRecords {
    /// As the command answers.
    pub(super) answer: Answer,
    /// Plausibility and responses with their covariance as CSV.
    pub(super) folder: ResultsFolder,
    peaks: Option<Identification>,
}

/// Identifies the free rotor from records that are estimated already; a rotor without magnets has no machine.
///
/// # Errors
/// [`Failure`] as `muspin identify` tells it.
pub(super) fn identify_records(
    measurement: &Measurement,
    machine: Option<&Machine>,
    records: &Records,
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
            let found = identify(frf, machine).map_err(at_rest)?;
            if let Some(sweep) = measurement.sweeps.iter().find(|s| s.record.speed_rpm == 0.0) {
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
    Ok(IdentifiedRecords { answer, folder, peaks })
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Answer {
    plausibility: PlausibilitySummary,
    #[serde(skip_serializing_if = "Option::is_none")]
    identification: Option<IdentificationSummary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    drift: Option<DriftSummary>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    hammers: Vec<HammerSummary>,
    /// Files of the responses.
    records: Vec<String>,
}

/// File of the first sweep at standstill.
pub(super) fn record_at_rest(measurement: &Measurement) -> String {
    let mut sweeps = measurement.sweeps.iter().map(|s| &s.record);
    let found = sweeps.find(|r| r.speed_rpm == 0.0);
    found.map_or(String::new(), |r| r.name.clone())
}

fn show_identification(arguments: &Arguments, records: &Records, found: &IdentifiedRecords) -> CommandEnd {
    let hammers = &found.answer.hammers;
    let of_hammers: usize = hammers.iter().map(|h| h.resonances_hz.len()).sum();
    let mut shown = match (records.plausible(), &found.peaks) {
        (false, _) => CommandEnd::met(false, "a record contradicts the machine; what is wrong with it stands above"),
        (true, Some(peaks)) => CommandEnd::done(format!("{} resonances of the free rotor", peaks.resonances.len())),
        (true, None) => CommandEnd::done(format!(
            "{of_hammers} resonances in the hammer tests; antiresonances, and the rotor without its magnets, need a \
             sweep at rest"
        )),
    };
    if of_hammers > 0 || found.peaks.is_some() {
        shown = shown.row(["", "Hz", "standard deviation, Hz", "damping ratio", "standard deviation"]);
    }
    if let Some(peaks) = &found.peaks {
        let number = |x: Option<f64>, digits: usize| x.map_or("not found".to_owned(), |x| format!("{x:.digits$}"));
        let row = |name: &str, reading: &Reading| {
            vec![name.to_owned(), number(reading.frequency_hz(), 2), number(reading.standard_deviation_hz(), 3)]
        };
        for (k, reading) in peaks.resonances.iter().enumerate() {
            let damping = [peaks.damping_ratio[k], peaks.damping_standard_deviation[k]];
            let damping = damping.map(|z| format!("{z:.6}"));
            shown = shown.rows([[row("resonance", reading), damping.to_vec()].concat()]);
        }
        for (name, readings) in [("antiresonance, front", &peaks.front), ("antiresonance, rear", &peaks.rear)] {
            shown = shown.rows(readings.iter().map(|reading| row(name, reading)));
        }
    }
    for hammer in hammers {
        if hammer.resonances_hz.is_empty() {
            shown = shown.row([format!("{}: no resonance stands out of the noise", hammer.record)]);
        }
        for (k, hz) in hammer.resonances_hz.iter().enumerate() {
            let digits = |x: f64, digits: usize| format!("{x:.digits$}");
            shown = shown.rows([vec![
                format!("resonance, {}", hammer.record),
                digits(*hz, 2),
                digits(hammer.resonances_standard_deviation_hz[k], 3),
                digits(hammer.damping_ratio[k], 6),
                digits(hammer.damping_ratio_standard_deviation[k], 6),
            ]]);
        }
    }
    if let Some(out) = &arguments.out {
        shown = shown.file(out.as_str());
    }
    shown
        .next(format!("muspin update --measurement {}", arguments.measurement))
        .next(format!("muspin diagnose --measurement {}", arguments.measurement))
}
