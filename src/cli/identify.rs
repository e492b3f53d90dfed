//! `muspin identify`: measured sweeps to FRFs with covariance, resonances and antiresonances of the free-free rotor (JSON).

use super::{Failure, Outcome, stdout};
use crate::identify::{Identification, IdentifyError, MeasuredFrf, Reading, identify, open_loop};
use crate::input::load_measurement;
use crate::report::atomic::write_file;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;

/// Arguments of `muspin identify`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {
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
            IdentifyError::Singular { .. } => {
                "the four injections must differ: one axis each, at every line"
            }
            IdentifyError::NotAtRest { .. } => "add a sweep taken at 0 rpm to the measurement",
            IdentifyError::NoResonance { .. } => {
                "check frequency range, line spacing and excitation of the sweep"
            }
            _ => "check the record",
        };
        Self::new(error.to_string()).with_hint(hint)
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let measurement = load_measurement(&arguments.measurement)?;
    let machine = measurement.machine(arguments.spindle.as_deref(), arguments.tool.as_deref())?;
    let frfs = measurement
        .sweeps
        .iter()
        .map(|s| open_loop(&s.record))
        .collect::<Result<Vec<_>, _>>()?;
    if frfs.is_empty() && measurement.hammers.is_empty() {
        return Err(Failure::new(format!(
            "{}: no record of kind sweep or hammer",
            arguments.measurement
        ))
        .with_hint("identification needs a sweep; frequencies that are known already go straight into `muspin update`"));
    }
    let mut answer = serde_json::Map::new();
    if let Some(frf) = standstill(&frfs) {
        let found = identify(frf, &machine)?;
        answer.insert("identification".into(), identification_json(&found));
    } else if let Some(frf) = frfs.first() {
        return Err(IdentifyError::NotAtRest {
            speed_rpm: frf.speed_rpm,
        }
        .into());
    }
    let mut files = vec![];
    for (k, frf) in frfs.iter().enumerate() {
        files.push((format!("frf-{k}.csv"), frf_csv(frf)));
    }
    for (k, hammer) in measurement.hammers.iter().enumerate() {
        let mut text = String::from("frequency_hz,h_re,h_im,sigma\n");
        for (l, (f, h)) in hammer
            .frf
            .frequency_hz
            .iter()
            .zip(&hammer.frf.compliance)
            .enumerate()
        {
            let sigma = hammer.frf.sigma(l, 0.0);
            let _ = writeln!(text, "{f},{:e},{:e},{sigma:e}", h.re, h.im);
        }
        files.push((format!("hammer-{k}.csv"), text));
    }
    if let Some(out) = &arguments.out {
        for (name, text) in &files {
            let path = Path::new(out).join(name);
            write_file(&path, text.as_bytes())
                .map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
        }
    }
    let names: Vec<&String> = files.iter().map(|(n, _)| n).collect();
    answer.insert("records".into(), json!(names));
    let text = serde_json::to_string_pretty(&Value::Object(answer))
        .map_err(|e| Failure::new(e.to_string()))?;
    stdout::data(|out| writeln!(out, "{text}"))?;
    Ok(Outcome::Done)
}

/// The first sweep at standstill.
pub(super) fn standstill(frfs: &[MeasuredFrf]) -> Option<&MeasuredFrf> {
    frfs.iter().find(|f| f.speed_rpm == 0.0)
}

/// The `identification` object of `summary.json`.
pub(super) fn identification_json(found: &Identification) -> Value {
    let hz = |l: &[Reading]| -> Vec<Value> { l.iter().map(|r| json!(r.frequency_hz())).collect() };
    let sd = |l: &[Reading]| -> Vec<Value> {
        l.iter().map(|r| json!(r.standard_deviation_hz())).collect()
    };
    let shift = |l: &[Reading]| -> Vec<Value> {
        l.iter()
            .map(|r| match r {
                Reading::Found {
                    magnet_shift_hz, ..
                } => json!(magnet_shift_hz),
                Reading::NotIdentified { .. } => Value::Null,
            })
            .collect()
    };
    let why = |l: &[Reading]| -> Vec<Value> {
        l.iter()
            .map(|r| match r {
                Reading::Found { .. } => Value::Null,
                Reading::NotIdentified { reason } => json!(reason),
            })
            .collect()
    };
    json!({
        "resonances_hz": hz(&found.resonances),
        "resonances_standard_deviation_hz": sd(&found.resonances),
        "damping_ratio": found.damping_ratio,
        "antiresonances_hz": {"front": hz(&found.front), "rear": hz(&found.rear)},
        "antiresonances_standard_deviation_hz": {"front": sd(&found.front), "rear": sd(&found.rear)},
        "not_identified": {"front": why(&found.front), "rear": why(&found.rear)},
        "magnet_shift_removed_hz": {
            "resonances": shift(&found.resonances),
            "front": shift(&found.front),
            "rear": shift(&found.rear),
        },
        "refers_to": "free-free rotor at rest: levitation loop, amplifier, delay, sensor and negative stiffness removed",
    })
}

/// FRF with covariance: entries, then the upper triangle of Cov(vec G) (index = output + 4·input, from 1).
fn frf_csv(frf: &MeasuredFrf) -> String {
    let mut text = String::from("frequency_hz");
    for i in 1..=4 {
        for j in 1..=4 {
            let _ = write!(text, ",g_{i}{j}_re,g_{i}{j}_im");
        }
    }
    for a in 1..=16 {
        for b in a..=16 {
            let _ = write!(text, ",cov_{a}_{b}_re,cov_{a}_{b}_im");
        }
    }
    text.push('\n');
    for (l, f) in frf.frequency_hz.iter().enumerate() {
        let _ = write!(text, "{f}");
        for i in 0..4 {
            for j in 0..4 {
                let g = frf.response[(l, i, j)];
                let _ = write!(text, ",{:e},{:e}", g.re, g.im);
            }
        }
        for a in 0..16 {
            for b in a..16 {
                let c = frf.covariance[(l, a, b)];
                let _ = write!(text, ",{:e},{:e}", c.re, c.im);
            }
        }
        text.push('\n');
    }
    text
}
