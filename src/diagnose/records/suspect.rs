//! Faults of a record that have one number, and where their fits start.

use super::super::data::evidence::{Evidence, SweepEvidence};
use super::super::data::measurement::{RecordId, RecordSet};
use crate::identify::plausibility::{RecordFault, Signal};
use crate::spindle::Machine;

/// Unit of a speed in a fit, rpm.
const SPEED_UNIT_RPM: f64 = 1000.0;
/// Unit of a delay in a fit, s.
const DELAY_UNIT_S: f64 = 1e-5;
/// Unit of a mass at the tool in a fit, kg.
const MASS_UNIT_KG: f64 = 1e-3;
/// Starts of the logarithm of a clock factor: a crystal, and a sample rate that was rounded or taken for another.
const CLOCKS: [f64; 3] = [0.0, -0.03, 0.03];

/// Share of the response within an axis that reaches the other one in some line where a rotor turns.
const CROSSED: f64 = 0.03;
/// Lines on either side among which the response within an axis is the largest.
const NEIGHBOURS: usize = 5;

/// A kind of fault with one number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Family {
    /// Speed, in 1000 rpm.
    Speed,
    /// Logarithm of the factor on the frequencies.
    Clock,
    /// Relative change of all sensor signals over the record.
    Drift,
    /// Logarithm of the factor on a compliance.
    Calibration,
    /// Delay of the response of a hammer test, in 10 µs.
    Delay,
    /// Mass at the tool in a hammer test, g.
    Mass,
    /// Logarithm of the sample rate of the logger in Hz.
    Alias,
}

/// A fault of one record with its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Suspect {
    pub record: RecordId,
    pub family: Family,
    /// Where its number starts.
    pub start: f64,
}

impl Suspect {
    /// The suspect of a fault that was found, starting where that ended; none for a fault without such a number.
    pub(crate) fn of(record: RecordId, fault: RecordFault) -> Option<Self> {
        let (family, start) = match fault {
            RecordFault::SpeedLabel { speed_rpm } => (Family::Speed, speed_rpm / SPEED_UNIT_RPM),
            RecordFault::Clock { factor } => (Family::Clock, factor.ln()),
            RecordFault::Drift { relative_change, .. } => (Family::Drift, relative_change),
            RecordFault::HammerCalibration { factor } => (Family::Calibration, factor.ln()),
            RecordFault::HammerDelay { delay_s } => (Family::Delay, delay_s / DELAY_UNIT_S),
            RecordFault::HammerMass { mass_kg } => (Family::Mass, mass_kg / MASS_UNIT_KG),
            RecordFault::Alias { sample_rate_hz } => (Family::Alias, sample_rate_hz.ln()),
            _ => return None,
        };
        Some(Self { record, family, start })
    }

    /// The number of a record that has no such fault.
    pub(crate) fn present(&self, measurement: &RecordSet) -> f64 {
        match self.family {
            Family::Speed => measurement.speed_rpm(self.record) / SPEED_UNIT_RPM,
            _ => 0.0,
        }
    }

    pub(crate) fn to_fault(self, number: f64) -> RecordFault {
        match self.family {
            Family::Speed => RecordFault::SpeedLabel { speed_rpm: (SPEED_UNIT_RPM * number).max(0.0) },
            Family::Clock => RecordFault::Clock { factor: number.exp() },
            // A signal does not vanish on the way.
            Family::Drift => RecordFault::Drift { signal: Signal::Displacement, relative_change: number.max(-0.9) },
            Family::Calibration => RecordFault::HammerCalibration { factor: number.exp() },
            Family::Delay => RecordFault::HammerDelay { delay_s: DELAY_UNIT_S * number },
            Family::Mass => RecordFault::HammerMass { mass_kg: MASS_UNIT_KG * number },
            Family::Alias => RecordFault::Alias { sample_rate_hz: number.exp() },
        }
    }

    /// Difference over which a record is differentiated to the number: far above rounding, far below what is told.
    pub(crate) fn difference(&self) -> f64 {
        match self.family {
            Family::Speed | Family::Delay | Family::Mass => 1e-2,
            Family::Clock | Family::Alias => 1e-6,
            Family::Drift | Family::Calibration => 1e-4,
        }
    }

    /// Longest step of the number in a fit.
    pub(crate) fn longest(&self) -> f64 {
        match self.family {
            Family::Speed | Family::Delay | Family::Mass => 10.0,
            Family::Clock | Family::Alias => 0.02,
            Family::Drift | Family::Calibration => 0.3,
        }
    }

    /// Least size worth a name: five times what calibrated instruments and crystals leave.
    pub(crate) fn matters(&self, number: f64, measurement: &RecordSet) -> bool {
        match self.family {
            Family::Speed => {
                let label = measurement.speed_rpm(self.record);
                (SPEED_UNIT_RPM * number - label).abs() > 0.02 * label.max(SPEED_UNIT_RPM)
            }
            Family::Clock => number.abs() > 1e-3,
            Family::Drift => number.abs() > 5e-3,
            Family::Calibration => number.abs() > 0.03,
            // 3 µs, and half a gram.
            Family::Delay => number.abs() > 0.3,
            Family::Mass => number.abs() > 0.5,
            // A sample rate at which nothing is folded is no fault.
            Family::Alias => {
                let own = match self.record {
                    RecordId::Sweep(s) => measurement.sweeps.get(s),
                    RecordId::Hammer(_) => None,
                };
                let top = own.and_then(|s| s.frequency_hz.last());
                top.is_some_and(|top| number.exp() < 2.0 * top)
            }
        }
    }
}

/// All suspects of a measurement, the starts of one fault behind each other.
pub(crate) fn suspects(machine: &Machine, evidence: &Evidence, measurement: &RecordSet) -> Vec<Suspect> {
    let mut all = vec![];
    let top = machine.spindle.max_rpm / SPEED_UNIT_RPM;
    let turns = machine.effective().gyroscopic_factor != 0.0 && evidence.sweeps.iter().any(turns);
    for record in measurement.records() {
        let mut add = |family, start| {
            all.push(Suspect { record, family, start });
        };
        if turns {
            let label = measurement.speed_rpm(record) / SPEED_UNIT_RPM;
            for start in [label.max(0.05 * top), 0.3 * top, 0.6 * top, top] {
                add(Family::Speed, start);
            }
        }
        match record {
            RecordId::Sweep(_) => {
                CLOCKS.into_iter().for_each(|start| add(Family::Clock, start));
                add(Family::Drift, 0.0);
            }
            RecordId::Hammer(_) => {
                add(Family::Clock, 0.0);
                add(Family::Calibration, 0.0);
                add(Family::Delay, 0.0);
                add(Family::Mass, 0.0);
            }
        }
    }
    all
}

/// Whether a sweep shows a turning rotor: somewhere x answers to y.
fn turns(sweep: &SweepEvidence) -> bool {
    let lines = sweep.response.len();
    let size = |k: usize, i: usize, j: usize| sweep.response[k][4 * i + j].norm();
    (0..lines).any(|k| {
        // An antiresonance within the axis is no answer across.
        let near = k.saturating_sub(NEIGHBOURS)..(k + NEIGHBOURS + 1).min(lines);
        (0..2).any(|b| {
            let (x, y) = (2 * b, 2 * b + 1);
            let own = near.clone().map(|l| size(l, x, x)).fold(0.0, f64::max);
            size(k, x, y) > CROSSED * own
        })
    })
}
