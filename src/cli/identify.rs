//! `muspin identify`: are the records plausible; measured sweeps to FRFs with covariance, resonances and antiresonances
//! of the free-free rotor (JSON).

use super::console::{CommandEnd, Console};
use super::machine::of_measurement;
use super::output::claim;
use super::reading::load_measurement;
use super::{Failure, Outcome};
use crate::report::summary::json;
use crate::workflow::identify::{IdentifiedRecords, identify_records};
use crate::workflow::plausibility::Records;
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

/// Runs the command.
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let measurement = load_measurement(&arguments.measurement, console)?;
    let machine = of_measurement(&measurement, arguments.spindle.as_deref(), arguments.tool.as_deref())?;
    if let Some(out) = &arguments.out {
        let named = [&arguments.spindle, &arguments.tool].into_iter().flatten();
        let read = named.chain([&arguments.measurement]);
        claim(out, &[], read.map(String::as_str))?;
    }
    let records = Records::of(&measurement, &machine, &|| {})?;
    records.lines().for_each(|line| eprintln!("{line}"));
    let found = identify_records(&measurement, &machine, &records, &|| {})?;
    if let Some(out) = &arguments.out {
        console.writing(|| found.folder.write(Path::new(out)))?;
    }
    let answer = &found.answer;
    console.json(&format!("{:#}\n", json(answer)), || {
        let shown = show_identification(arguments, &found);
        answer.drift.iter().fold(shown, |shown, drift| shown.row([drift.words()]))
    })?;
    Ok(if found.verdict().0 { Outcome::Done } else { Outcome::TargetMissed })
}

fn show_identification(arguments: &Arguments, found: &IdentifiedRecords) -> CommandEnd {
    let mut shown = match found.verdict() {
        (false, words) => CommandEnd::met(false, format!("{words}; what is wrong with it stands above")),
        (true, words) => CommandEnd::done(words),
    };
    if let Some(found) = &found.peaks {
        shown = shown.row(["", "Hz", "standard deviation, Hz", "damping ratio", "standard deviation"]);
        let lists = [
            ("resonance", &found.resonances),
            ("antiresonance, front", &found.front),
            ("antiresonance, rear", &found.rear),
        ];
        for (name, readings) in lists {
            for (k, reading) in readings.iter().enumerate() {
                let number =
                    |x: Option<f64>, digits: usize| x.map_or("not found".to_owned(), |x| format!("{x:.digits$}"));
                let mut row = vec![
                    name.to_owned(),
                    number(reading.frequency_hz(), 2),
                    number(reading.standard_deviation_hz(), 3),
                ];
                if name == "resonance" {
                    let damping = [&found.damping_ratio, &found.damping_standard_deviation];
                    row.extend(damping.map(|list| list.get(k).map_or(String::new(), |z| format!("{z:.6}"))));
                }
                shown = shown.rows([row]);
            }
        }
    }
    if let Some(out) = &arguments.out {
        shown = shown.file(out.as_str());
    }
    shown
        .next(format!("muspin update --measurement {}", arguments.measurement))
        .next(format!("muspin diagnose --measurement {}", arguments.measurement))
}
