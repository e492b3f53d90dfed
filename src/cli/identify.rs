//! `muspin identify`: are the records plausible; measured sweeps to FRFs with covariance, resonances and antiresonances
//! of the free-free rotor; resonances of hammer tests (JSON).

use super::Failure;
use super::choices::PictureArguments;
use super::console::{CommandEnd, Console, REPORT};
use super::machine::MeasuredMachine;
use super::reading::load_measurement;
use crate::identify::Reading;
use crate::input::is_rotor;
use crate::workflow::identify::{IdentifiedRecords, identify_records};
use crate::workflow::plausibility::Records;
use std::path::Path;

#[derive(clap::Args, Debug, Default)]
pub(super) struct Arguments {
    /// Measurement folder with measurement.yaml
    #[arg(long)]
    measurement: String,
    #[command(flatten)]
    machine: MeasuredMachine,
    /// Folder for the FRFs with their covariance as CSV, pictures of them and report
    #[arg(long)]
    out: Option<String>,
    #[command(flatten)]
    pictures: PictureArguments,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let out = arguments.pictures.folder(&arguments.out)?;
    let measurement = load_measurement(&arguments.measurement, console)?;
    let machine = if is_rotor(arguments.machine.files(&measurement).0) {
        arguments.machine.load_rotor(&measurement)?;
        None
    } else {
        Some(arguments.machine.load(&measurement)?)
    };
    if let Some(out) = out {
        console.claim(out, if machine.is_some() { &REPORT } else { &[] }, &[])?;
    }
    let records = Records::of(&measurement, machine.as_ref(), &|| {})?;
    records.lines().for_each(|line| eprintln!("{line}"));
    let mut found = identify_records(&measurement, machine.as_ref(), &records, &|| {})?;
    if let Some(out) = out {
        console.writing(|| match &machine {
            Some(machine) => found.report(machine).write(out, &arguments.pictures.formats),
            None => Ok(found.folder.write(Path::new(out))?),
        })?;
    }
    let shown = show_identification(arguments, &found).answer(&found.answer);
    Ok(found.drift.iter().fold(shown, |shown, drift| shown.row([drift.words()])))
}

fn show_identification(arguments: &Arguments, found: &IdentifiedRecords) -> CommandEnd {
    let hammers = &found.hammers;
    let mut shown = match found.verdict() {
        (false, words) => CommandEnd::met(false, format!("{words}; what is wrong with it stands above")),
        (true, words) => CommandEnd::done(words),
    };
    if found.of_hammers() > 0 || found.peaks.is_some() {
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
            let remedy = hammer.remedy.map_or(String::new(), |remedy| format!("; {remedy}"));
            shown = shown.row([format!("{}: no resonance stands out of the noise{remedy}", hammer.record)]);
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
