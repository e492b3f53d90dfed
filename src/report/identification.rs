//! Plausibility of records, identified resonances and antiresonances as JSON; measured FRFs with their covariance
//! as CSV.

use super::summary::number;
use crate::identify::frf::AXIS_NAMES;
use crate::identify::plausibility::{Plausibility, RecordFault, Signal};
use crate::identify::{Identification, MeasuredFrf, Reading};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// The `plausibility` object of `summary.json`: all checks of all records, and the mistakes found.
pub fn plausibility_json(reports: &[Plausibility]) -> Value {
    let check = |report: &Plausibility| {
        let record = file_name(&report.record).to_owned();
        let each = |c: &crate::identify::plausibility::Check| {
            json!({
                "record": record,
                "name": c.name,
                "value": number(c.value),
                "expected": c.expected,
                "ok": c.ok,
                "words": c.words,
            })
        };
        report.checks.iter().map(each).collect::<Vec<_>>()
    };
    json!({
        "plausible": reports.iter().all(Plausibility::plausible),
        "statements": reports.iter().filter_map(Plausibility::statement).collect::<Vec<_>>(),
        "checks": reports.iter().flat_map(check).collect::<Vec<_>>(),
        "record_faults": record_faults(reports),
    })
}

/// Mistakes of all records, one object each: `record`, `fault`, the fields of the fault, `words`.
pub fn record_faults(reports: &[Plausibility]) -> Vec<Value> {
    let of = |report: &Plausibility| {
        let each = |f: &RecordFault| fault_json(file_name(&report.record), f);
        report.faults.iter().map(each).collect::<Vec<_>>()
    };
    reports.iter().flat_map(of).collect()
}

/// One mistake of a record: `record`, `fault`, the fields of the fault, `words`.
pub fn fault_json(record: &str, fault: &RecordFault) -> Value {
    let mut map = serde_json::Map::new();
    map.insert("record".into(), json!(record));
    map.insert("fault".into(), json!(fault.name()));
    let fields: Vec<(&str, Value)> = match *fault {
        RecordFault::ChannelsSwapped { a, b, signal } => vec![
            ("a", json!(AXIS_NAMES[a])),
            ("b", json!(AXIS_NAMES[b])),
            ("signal", json!(signal.name())),
        ],
        RecordFault::PlanesSwapped { signal } => vec![("signal", json!(signal.name()))],
        RecordFault::Sign { channel, signal } => {
            let channel = channel.map(|k| ("channel", json!(AXIS_NAMES[k])));
            let signal = ("signal", json!(signal.name()));
            channel.into_iter().chain([signal]).collect()
        }
        RecordFault::Unit {
            signal,
            decades,
            channel,
        } => {
            let channel = channel.map(|k| ("channel", json!(AXIS_NAMES[k])));
            let rest = [
                ("signal", json!(signal.name())),
                ("factor", json!(10f64.powi(decades))),
            ];
            rest.into_iter().chain(channel).collect()
        }
        RecordFault::Conjugate => vec![],
        RecordFault::Clock { factor } | RecordFault::HammerCalibration { factor } => {
            vec![("factor", json!(factor))]
        }
        RecordFault::SpeedLabel { speed_rpm } => vec![("speed_rpm", json!(speed_rpm))],
        RecordFault::Drift {
            signal,
            relative_change,
        } => vec![
            ("signal", json!(signal.name())),
            ("relative_change", json!(relative_change)),
        ],
        RecordFault::Clipping { limit, signal } => {
            vec![("limit", json!(limit)), ("signal", json!(signal.name()))]
        }
        RecordFault::Alias { sample_rate_hz } => vec![("sample_rate_hz", json!(sample_rate_hz))],
        RecordFault::Tool | RecordFault::Controller | RecordFault::Disagrees => vec![],
        RecordFault::Quantity(quantity) => vec![
            ("signal", json!(Signal::Compliance.name())),
            ("quantity", json!(quantity.name())),
        ],
    };
    map.extend(fields.into_iter().map(|(k, v)| (k.to_owned(), v)));
    map.insert("words".into(), json!(fault.words()));
    Value::Object(map)
}

/// The file without its folder, as `measurement.yaml` names it.
fn file_name(record: &str) -> &str {
    record.rsplit(['/', '\\']).next().unwrap_or(record)
}

/// The `identification` object of `summary.json`.
pub fn identification_json(found: &Identification) -> Value {
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
        "cross_antiresonances_hz": {"13": hz(&found.front_over_rear), "31": hz(&found.rear_over_front)},
        "cross_antiresonances_standard_deviation_hz": {
            "13": sd(&found.front_over_rear),
            "31": sd(&found.rear_over_front),
        },
        "not_identified": {"front": why(&found.front), "rear": why(&found.rear)},
        "magnet_shift_removed_hz": {
            "resonances": shift(&found.resonances),
            "front": shift(&found.front),
            "rear": shift(&found.rear),
        },
        "refers_to": "free-free rotor at rest: levitation loop, amplifier, delay, sensor and negative stiffness \
         removed",
    })
}

/// FRF with covariance: entries, then the upper triangle of Cov(vec G) (index = output + 4·input, from 1).
pub fn frf_csv(frf: &MeasuredFrf) -> String {
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
