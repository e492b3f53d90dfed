//! Plausibility of records, identified resonances and antiresonances as topics of the summary; measured FRFs with their
//! covariance as CSV.

use super::summary::omit_absent;
use super::uff::{UffRecord, universal_file};
use crate::identify::frf::AXIS_NAMES;
use crate::identify::peaks::Resonance;
use crate::identify::plausibility::{Plausibility, RecordFault, Signal};
use crate::identify::polluted::PollutedLines;
use crate::identify::{HammerFrf, Identification, MeasuredFrf, PoleDrift, Reading, shared_resonances};
use crate::input::measurement::Hammer;
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// `plausibility`: all checks of all records, and the mistakes found.
pub(crate) fn plausibility_topic(reports: &[Plausibility]) -> Value {
    let checks = reports.iter().flat_map(|report| {
        let record = file_name(&report.record);
        report.checks.iter().map(move |c| {
            json!({
                "record": record,
                "name": c.name,
                "value": c.value,
                "expected": c.expected,
                "ok": c.ok,
                "words": c.words,
            })
        })
    });
    let faults = reports.iter().flat_map(|report| {
        let record = file_name(&report.record);
        report.faults.iter().map(move |fault| fault_topic(record, fault, None))
    });
    json!({
        "plausible": reports.iter().all(Plausibility::plausible),
        "statements": reports.iter().filter_map(Plausibility::statement).collect::<Vec<_>>(),
        "checks": checks.collect::<Vec<_>>(),
        "record_faults": faults.collect::<Vec<_>>(),
    })
}

/// A mistake of a record: what it is, its fields, words, and the name of the tool or controller that fits.
pub(crate) fn fault_topic(record: &str, fault: &RecordFault, name: Option<&str>) -> Value {
    let mut topic = with_fields(record, fault.name(), fault_fields(fault), &fault.words());
    if let Some(name) = name {
        topic["name"] = json!(name);
    }
    topic
}

/// Lines of a record that something outside the loop disturbs.
pub(crate) fn polluted_lines_topic(record: &str, lines: &PollutedLines) -> Value {
    let fields = json!({ "hz": lines.hz, "source": lines.source.name(), "factor": lines.factor });
    with_fields(record, "polluted_lines", fields, &lines.words())
}

fn with_fields(record: &str, fault: &str, fields: Value, words: &str) -> Value {
    let mut topic = json!({ "record": record, "fault": fault });
    for (key, value) in fields.as_object().into_iter().flatten() {
        topic[key] = value.clone();
    }
    topic["words"] = json!(words);
    topic
}

fn fault_fields(fault: &RecordFault) -> Value {
    let fields = match *fault {
        RecordFault::ChannelsSwapped { a, b, signal } => {
            json!({ "a": AXIS_NAMES[a], "b": AXIS_NAMES[b], "signal": signal.name() })
        }
        RecordFault::PlanesSwapped { signal } => json!({ "signal": signal.name() }),
        RecordFault::Sign { channel, signal } => {
            json!({ "channel": channel.map(|k| AXIS_NAMES[k]), "signal": signal.name() })
        }
        RecordFault::Unit { signal, decades, channel } => {
            let (factor, channel) = (10f64.powi(decades), channel.map(|k| AXIS_NAMES[k]));
            json!({ "signal": signal.name(), "factor": factor, "channel": channel })
        }
        RecordFault::Clock { factor } | RecordFault::HammerCalibration { factor } => json!({ "factor": factor }),
        RecordFault::HammerDelay { delay_s } => json!({ "delay_s": delay_s }),
        RecordFault::HammerMass { mass_kg } => json!({ "mass_kg": mass_kg }),
        RecordFault::SpeedLabel { speed_rpm } => json!({ "speed_rpm": speed_rpm }),
        RecordFault::Drift { signal, relative_change } => {
            json!({ "signal": signal.name(), "relative_change": relative_change })
        }
        RecordFault::Clipping { limit, signal } => json!({ "limit": limit, "signal": signal.name() }),
        RecordFault::Alias { sample_rate_hz } => json!({ "sample_rate_hz": sample_rate_hz }),
        RecordFault::Quantity(quantity) => {
            json!({ "signal": Signal::Compliance.name(), "quantity": quantity.name() })
        }
        RecordFault::Conjugate | RecordFault::Tool | RecordFault::Controller | RecordFault::Disagrees => json!({}),
    };
    omit_absent(fields, &["channel"])
}

/// The file without its folder, as `measurement.yaml` names it.
pub(crate) fn file_name(record: &str) -> &str {
    record.rsplit(['/', '\\']).next().unwrap_or(record)
}

/// `identification`: one value a reading, none where the peak was not identified.
pub(crate) fn identification_topic(found: &Identification) -> Value {
    let hz = |readings: &[Reading]| json!(readings.iter().map(Reading::frequency_hz).collect::<Vec<_>>());
    let sd_hz = |readings: &[Reading]| json!(readings.iter().map(Reading::standard_deviation_hz).collect::<Vec<_>>());
    let shift = |r: &Reading| match r {
        Reading::Found { magnet_shift_hz, .. } => Some(*magnet_shift_hz),
        Reading::NotIdentified { .. } => None,
    };
    let shifts = |readings: &[Reading]| json!(readings.iter().map(shift).collect::<Vec<_>>());
    let reason = |r: &Reading| match r {
        Reading::Found { .. } => None,
        Reading::NotIdentified { reason } => Some(reason.to_string()),
    };
    let reasons = |readings: &[Reading]| json!(readings.iter().map(reason).collect::<Vec<_>>());
    // Antiresonances between the bearings, by output and input axis.
    let (front_over_rear, rear_over_front) = (&found.front_over_rear, &found.rear_over_front);
    json!({
        "resonances_hz": hz(&found.resonances),
        "resonances_standard_deviation_hz": sd_hz(&found.resonances),
        "damping_ratio": found.damping_ratio,
        "damping_ratio_standard_deviation": found.damping_standard_deviation,
        "antiresonances_hz": { "front": hz(&found.front), "rear": hz(&found.rear) },
        "antiresonances_standard_deviation_hz": { "front": sd_hz(&found.front), "rear": sd_hz(&found.rear) },
        "cross_antiresonances_hz": { "13": hz(front_over_rear), "31": hz(rear_over_front) },
        "cross_antiresonances_standard_deviation_hz": { "13": sd_hz(front_over_rear), "31": sd_hz(rear_over_front) },
        "not_identified": { "front": reasons(&found.front), "rear": reasons(&found.rear) },
        "magnet_shift_removed_hz": {
            "resonances": shifts(&found.resonances),
            "front": shifts(&found.front),
            "rear": shifts(&found.rear),
        },
        "refers_to": "free-free rotor at rest: levitation loop, amplifier, delay, sensor and negative stiffness \
                      removed",
    })
}

/// One of `hammers`: the resonances of a hammer test, or those that the tests of a roving hammer share.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct HammerSummary {
    pub(crate) record: String,
    pub(crate) resonances_hz: Vec<f64>,
    pub(crate) resonances_standard_deviation_hz: Vec<f64>,
    pub(crate) damping_ratio: Vec<f64>,
    pub(crate) damping_ratio_standard_deviation: Vec<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    mode_shapes: Vec<ShapeSummary>,
    refers_to: String,
    /// What is to be done about a record without resonances whose conjugate has some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) remedy: Option<&'static str>,
}

/// Amplitudes of a mode at the points of a roving hammer, the largest one.
#[derive(Clone, Debug, Serialize)]
struct ShapeSummary {
    mode: usize,
    position_m: Vec<f64>,
    amplitude: Vec<f64>,
}

impl HammerSummary {
    /// Of a hammer test, or of those of a roving hammer, whose responses are fitted together.
    pub(crate) fn of(taps: &[&Hammer]) -> Self {
        let frfs: Vec<&HammerFrf> = taps.iter().map(|tap| &tap.frf).collect();
        let found = shared_resonances(&frfs);
        let is_conjugate = found.is_empty() && {
            let turned: Vec<HammerFrf> = frfs.iter().map(|frf| frf.conjugate()).collect();
            !shared_resonances(&turned.iter().collect::<Vec<_>>()).is_empty()
        };
        let list = |of: fn(&Resonance) -> f64| found.iter().map(of).collect();
        let names: Vec<&str> = taps.iter().map(|tap| file_name(&tap.name)).collect();
        let held = match taps.first().and_then(|tap| tap.controller.as_ref()) {
            Some(controller) => format!("the spindle that {} levitates", file_name(controller)),
            None => "the rotor as it was held when it was hit".to_owned(),
        };
        let positions_m = roving_positions_m(taps);
        let shape = |(k, resonance): (usize, &Resonance)| {
            let position_m = positions_m.clone()?;
            Some(ShapeSummary { mode: k + 1, position_m, amplitude: resonance.shape() })
        };
        Self {
            record: names.join(", "),
            resonances_hz: list(|r| r.frequency_hz),
            resonances_standard_deviation_hz: list(|r| r.standard_deviation_hz),
            damping_ratio: list(|r| r.damping_ratio),
            damping_ratio_standard_deviation: list(|r| r.standard_deviation_hz / r.frequency_hz),
            mode_shapes: found.iter().enumerate().filter_map(shape).collect(),
            refers_to: format!("{held}, at {} rpm", frfs.first().map_or(0.0, |frf| frf.speed_rpm)),
            remedy: is_conjugate.then_some("its conjugate has resonances: multiply the column h_im by -1"),
        }
    }

    /// The mode shapes as the CSV of a record of that kind; none without a roving hammer.
    pub(crate) fn shapes_csv(&self) -> Option<String> {
        let mut text = String::from("mode,position_m,amplitude\n");
        for shape in &self.mode_shapes {
            for (z, amplitude) in shape.position_m.iter().zip(&shape.amplitude) {
                let _ = writeln!(text, "{},{z},{amplitude:e}", shape.mode);
            }
        }
        (!self.mode_shapes.is_empty()).then_some(text)
    }
}

/// Hammer tests by sets: those of a roving hammer together, every other one alone.
pub(crate) fn roving_sets(hammers: &[Hammer]) -> Vec<Vec<&Hammer>> {
    let mut sets: Vec<Vec<&Hammer>> = vec![];
    for hammer in hammers {
        let roves = |set: &&mut Vec<&Hammer>| {
            let with: Vec<&Hammer> = set.iter().copied().chain([hammer]).collect();
            roving_positions_m(&with).is_some()
        };
        match sets.iter_mut().find(roves) {
            Some(set) => set.push(hammer),
            None => sets.push(vec![hammer]),
        }
    }
    sets
}

/// The places that differ between tests of one free rotor on the same lines whose other place is one: where the hammer
/// roves, or the sensor does; none where the tests are no such set.
fn roving_positions_m(taps: &[&Hammer]) -> Option<Vec<f64>> {
    let (first, others) = taps.split_first()?;
    let alike = |tap: &&Hammer| {
        let (own, other) = (&tap.frf, &first.frf);
        tap.axis == first.axis && own.speed_rpm == other.speed_rpm && own.frequency_hz == other.frequency_hz
    };
    if others.is_empty() || taps.iter().any(|tap| tap.controller.is_some()) || !others.iter().all(alike) {
        return None;
    }
    let places = taps.iter().map(|tap| tap.places_m).collect::<Option<Vec<[f64; 2]>>>()?;
    let differ = |side: usize| {
        let mut all: Vec<f64> = places.iter().map(|place| place[side]).collect();
        all.sort_by(f64::total_cmp);
        all.windows(2).all(|pair| pair[0] < pair[1])
    };
    let one = |side: usize| places.iter().all(|place| place[side] == places[0][side]);
    let roving = (0..2).find(|side| differ(*side) && one(1 - side))?;
    Some(places.iter().map(|place| place[roving]).collect())
}

/// `drift`: what the resonances did over the repeats.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct DriftSummary {
    relative_change: f64,
    standard_deviation: f64,
    words: String,
}

impl From<&PoleDrift> for DriftSummary {
    fn from(drift: &PoleDrift) -> Self {
        let (change, sd) = (drift.relative_change, drift.standard_deviation);
        let words = if drift.is_seen() {
            format!(
                "the resonances drift by {change:.1e} ± {sd:.1e} of their frequency from the first repeat to the last"
            )
        } else {
            format!("no drift of the resonances over the repeats beyond {:.1e} of their frequency", 3.0 * sd)
        };
        Self { relative_change: change, standard_deviation: sd, words }
    }
}

impl DriftSummary {
    pub(crate) fn words(&self) -> &str {
        &self.words
    }
}

/// Files of the responses: name and text of `frf-<k>.csv` for each sweep, `hammer-<k>.csv` and `hammer-<k>.uff` for
/// each hammer test.
pub(crate) fn response_files(frfs: &[MeasuredFrf], hammers: &[Hammer]) -> Vec<(String, String)> {
    let sweeps = frfs.iter().enumerate();
    let mut files: Vec<(String, String)> = sweeps.map(|(k, frf)| (format!("frf-{k}.csv"), frf_csv(frf))).collect();
    for (k, hammer) in hammers.iter().enumerate() {
        let (frequency_hz, compliance) = (&hammer.frf.frequency_hz, &hammer.frf.compliance);
        let mut text = String::from("frequency_hz,h_re,h_im,sigma\n");
        for ((f, h), sigma) in frequency_hz.iter().zip(compliance).zip(hammer.frf.sigmas(0.0)) {
            let _ = writeln!(text, "{f},{:e},{:e},{sigma:e}", h.re, h.im);
        }
        files.push((format!("hammer-{k}.csv"), text));
        let direction = 1 + hammer.axis as i64;
        let record = UffRecord {
            description: "compliance at the tool plane",
            response: (1, direction),
            reference: (1, direction),
            frequency_hz,
            compliance,
        };
        files.push((format!("hammer-{k}.uff"), universal_file(&[record])));
    }
    files
}

/// FRF with covariance: entries, none in a column that is not determined, then the upper triangle of Cov(vec G) (index
/// = output + 4·input, from 1).
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
                let _ = if frf.determined[j] { write!(text, ",{:e},{:e}", g.re, g.im) } else { write!(text, ",,") };
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
