//! Plausibility of records, identified resonances and antiresonances as topics of the summary; measured FRFs with their
//! covariance as CSV.

use super::summary::finite;
use super::uff::{UffRecord, universal_file};
use crate::identify::frf::AXIS_NAMES;
use crate::identify::peaks::Resonance;
use crate::identify::plausibility::{Plausibility, RecordFault, Signal};
use crate::identify::polluted::PollutedLines;
use crate::identify::{Identification, MeasuredFrf, PoleDrift, Reading};
use crate::input::measurement::Hammer;
use serde::Serialize;
use std::fmt::Write as _;

/// `plausibility`: all checks of all records, and the mistakes found.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PlausibilitySummary {
    plausible: bool,
    statements: Vec<String>,
    checks: Vec<CheckSummary>,
    record_faults: Vec<RecordFaultSummary>,
}

#[derive(Clone, Debug, Serialize)]
struct CheckSummary {
    record: String,
    name: &'static str,
    value: Option<f64>,
    expected: String,
    ok: bool,
    words: String,
}

/// A mistake of a record: what it is, its fields, and words.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RecordFaultSummary {
    record: String,
    fault: &'static str,
    #[serde(flatten)]
    fields: FaultFields,
    words: String,
    /// Name of the tool or controller that fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
}

/// Fields of a mistake.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
enum FaultFields {
    ChannelsSwapped {
        a: &'static str,
        b: &'static str,
        signal: &'static str,
    },
    PlanesSwapped {
        signal: &'static str,
    },
    Sign {
        #[serde(skip_serializing_if = "Option::is_none")]
        channel: Option<&'static str>,
        signal: &'static str,
    },
    Unit {
        signal: &'static str,
        factor: f64,
        #[serde(skip_serializing_if = "Option::is_none")]
        channel: Option<&'static str>,
    },
    Factor {
        factor: f64,
    },
    HammerDelay {
        delay_s: f64,
    },
    HammerMass {
        mass_kg: f64,
    },
    SpeedLabel {
        speed_rpm: f64,
    },
    Drift {
        signal: &'static str,
        relative_change: f64,
    },
    Clipping {
        limit: f64,
        signal: &'static str,
    },
    Alias {
        sample_rate_hz: f64,
    },
    Quantity {
        signal: &'static str,
        quantity: &'static str,
    },
    PollutedLines {
        hz: Vec<f64>,
        source: &'static str,
        factor: f64,
    },
    None {},
}

impl PlausibilitySummary {
    /// Of the reports on all records.
    pub(crate) fn of(reports: &[Plausibility]) -> Self {
        let checks = reports.iter().flat_map(|report| {
            let record = file_name(&report.record);
            report.checks.iter().map(|c| CheckSummary {
                record: record.to_owned(),
                name: c.name,
                value: finite(c.value),
                expected: c.expected.clone(),
                ok: c.ok,
                words: c.words.clone(),
            })
        });
        let faults = reports.iter().flat_map(|report| {
            let record = file_name(&report.record);
            let each = report.faults.iter();
            each.map(|fault| RecordFaultSummary::of(record, fault))
        });
        Self {
            plausible: reports.iter().all(Plausibility::plausible),
            statements: reports.iter().filter_map(Plausibility::statement).collect(),
            checks: checks.collect(),
            record_faults: faults.collect(),
        }
    }
}

impl RecordFaultSummary {
    /// A mistake of a record.
    pub(crate) fn of(record: &str, fault: &RecordFault) -> Self {
        Self {
            record: record.to_owned(),
            fault: fault.name(),
            fields: FaultFields::from(fault),
            words: fault.words(),
            name: None,
        }
    }

    /// Lines of a record that something outside the loop disturbs.
    pub(crate) fn of_polluted_lines(record: &str, lines: &PollutedLines) -> Self {
        let (hz, source, factor) = (lines.hz.clone(), lines.source.name(), lines.factor);
        Self {
            record: record.to_owned(),
            fault: "polluted_lines",
            fields: FaultFields::PollutedLines { hz, source, factor },
            words: lines.words(),
            name: None,
        }
    }

    /// With the name of the tool or controller that fits.
    pub(crate) fn naming(self, name: Option<String>) -> Self {
        Self { name, ..self }
    }
}

impl From<&RecordFault> for FaultFields {
    fn from(fault: &RecordFault) -> Self {
        match *fault {
            RecordFault::ChannelsSwapped { a, b, signal } => {
                Self::ChannelsSwapped { a: AXIS_NAMES[a], b: AXIS_NAMES[b], signal: signal.name() }
            }
            RecordFault::PlanesSwapped { signal } => Self::PlanesSwapped { signal: signal.name() },
            RecordFault::Sign { channel, signal } => {
                Self::Sign { channel: channel.map(|k| AXIS_NAMES[k]), signal: signal.name() }
            }
            RecordFault::Unit { signal, decades, channel } => Self::Unit {
                signal: signal.name(),
                factor: 10f64.powi(decades),
                channel: channel.map(|k| AXIS_NAMES[k]),
            },
            RecordFault::Clock { factor } | RecordFault::HammerCalibration { factor } => Self::Factor { factor },
            RecordFault::HammerDelay { delay_s } => Self::HammerDelay { delay_s },
            RecordFault::HammerMass { mass_kg } => Self::HammerMass { mass_kg },
            RecordFault::SpeedLabel { speed_rpm } => Self::SpeedLabel { speed_rpm },
            RecordFault::Drift { signal, relative_change } => Self::Drift { signal: signal.name(), relative_change },
            RecordFault::Clipping { limit, signal } => Self::Clipping { limit, signal: signal.name() },
            RecordFault::Alias { sample_rate_hz } => Self::Alias { sample_rate_hz },
            RecordFault::Quantity(quantity) => {
                Self::Quantity { signal: Signal::Compliance.name(), quantity: quantity.name() }
            }
            RecordFault::Conjugate | RecordFault::Tool | RecordFault::Controller | RecordFault::Disagrees => {
                Self::None {}
            }
        }
    }
}

/// The file without its folder, as `measurement.yaml` names it.
pub(crate) fn file_name(record: &str) -> &str {
    record.rsplit(['/', '\\']).next().unwrap_or(record)
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct IdentificationSummary {
    resonances_hz: Frequencies,
    resonances_standard_deviation_hz: Frequencies,
    damping_ratio: Vec<f64>,
    damping_ratio_standard_deviation: Vec<f64>,
    antiresonances_hz: FrontRear<Frequencies>,
    antiresonances_standard_deviation_hz: FrontRear<Frequencies>,
    cross_antiresonances_hz: Crossed,
    cross_antiresonances_standard_deviation_hz: Crossed,
    not_identified: FrontRear<Vec<Option<String>>>,
    magnet_shift_removed_hz: MagnetShift,
    refers_to: &'static str,
}

/// One value a reading; none where the peak was not identified.
type Frequencies = Vec<Option<f64>>;

#[derive(Clone, Debug, Serialize)]
struct FrontRear<T> {
    front: T,
    rear: T,
}

/// Antiresonances between the bearings, by output and input axis.
#[derive(Clone, Debug, Serialize)]
struct Crossed {
    #[serde(rename = "13")]
    front_over_rear: Frequencies,
    #[serde(rename = "31")]
    rear_over_front: Frequencies,
}

#[derive(Clone, Debug, Serialize)]
struct MagnetShift {
    resonances: Frequencies,
    front: Frequencies,
    rear: Frequencies,
}

impl From<&Identification> for IdentificationSummary {
    fn from(found: &Identification) -> Self {
        let each = |readings: &[Reading], of: fn(&Reading) -> Option<f64>| -> Frequencies {
            readings.iter().map(of).collect()
        };
        let shift = |readings: &[Reading]| {
            each(readings, |r| match r {
                Reading::Found { magnet_shift_hz, .. } => Some(*magnet_shift_hz),
                Reading::NotIdentified { .. } => None,
            })
        };
        let why = |readings: &[Reading]| -> Vec<Option<String>> {
            let reason = |r: &Reading| match r {
                Reading::Found { .. } => None,
                Reading::NotIdentified { reason } => Some(reason.to_string()),
            };
            readings.iter().map(reason).collect()
        };
        let both =
            |of: fn(&Reading) -> Option<f64>| FrontRear { front: each(&found.front, of), rear: each(&found.rear, of) };
        let crossed = |of: fn(&Reading) -> Option<f64>| Crossed {
            front_over_rear: each(&found.front_over_rear, of),
            rear_over_front: each(&found.rear_over_front, of),
        };
        Self {
            resonances_hz: each(&found.resonances, Reading::frequency_hz),
            resonances_standard_deviation_hz: each(&found.resonances, Reading::standard_deviation_hz),
            damping_ratio: found.damping_ratio.clone(),
            damping_ratio_standard_deviation: found.damping_standard_deviation.clone(),
            antiresonances_hz: both(Reading::frequency_hz),
            antiresonances_standard_deviation_hz: both(Reading::standard_deviation_hz),
            cross_antiresonances_hz: crossed(Reading::frequency_hz),
            cross_antiresonances_standard_deviation_hz: crossed(Reading::standard_deviation_hz),
            not_identified: FrontRear { front: why(&found.front), rear: why(&found.rear) },
            magnet_shift_removed_hz: MagnetShift {
                resonances: shift(&found.resonances),
                front: shift(&found.front),
                rear: shift(&found.rear),
            },
            refers_to: "free-free rotor at rest: levitation loop, amplifier, delay, sensor and negative stiffness \
                        removed",
        }
    }
}

/// One of `hammers`: the resonances that a hammer test shows by itself.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct HammerSummary {
    pub(crate) record: String,
    pub(crate) resonances_hz: Vec<f64>,
    pub(crate) resonances_standard_deviation_hz: Vec<f64>,
    pub(crate) damping_ratio: Vec<f64>,
    pub(crate) damping_ratio_standard_deviation: Vec<f64>,
    pub(crate) refers_to: String,
}

impl HammerSummary {
    /// Of a hammer test, whose response is fitted.
    pub(crate) fn of(hammer: &Hammer) -> Self {
        let found = hammer.frf.resonances();
        let list = |of: fn(&Resonance) -> f64| found.iter().map(of).collect();
        let held = match &hammer.controller {
            Some(controller) => format!("the spindle that {} levitates", file_name(controller)),
            None => "the rotor as it was held when it was hit".to_owned(),
        };
        Self {
            record: file_name(&hammer.name).to_owned(),
            resonances_hz: list(|r| r.frequency_hz),
            resonances_standard_deviation_hz: list(|r| r.standard_deviation_hz),
            damping_ratio: list(|r| r.damping_ratio),
            damping_ratio_standard_deviation: list(|r| r.standard_deviation_hz / r.frequency_hz),
            refers_to: format!("{held}, at {} rpm", hammer.frf.speed_rpm),
        }
    }
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
    /// A sentence.
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
        for (l, (f, h)) in frequency_hz.iter().zip(compliance).enumerate() {
            let sigma = hammer.frf.sigma(l, 0.0);
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
