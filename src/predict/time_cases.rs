//! The four standard time cases and their figures: impulse and step at the tool, unbalance at speed, lift-off.
//! Unbalance of balance grade G (ISO 21940-11, G = e·Ω in m/s): rotating force m G Ω, split over the two actuator
//! planes so that it acts at the centre of gravity. Gravity for lift-off is split the same way and lies between the two
//! axes.

use super::time::{LOADS, Scenario, TimeError, TimeResponse, TimeSettings, simulate};
use crate::controller::arithmetic::Float32Program;
use crate::spindle::plant::AXES;
use crate::spindle::{Machine, SpindleError};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.806_65;
/// Time before zero that lets the rotor come to rest in the backup bearings, s.
const SETTLING_S: f64 = 0.3;

/// Length of a usual push, s.
pub(crate) const PUSH_S: f64 = 5e-4;

/// A standard case with its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StandardCase {
    /// Half-sine push at the tool in x, N and s.
    Impulse {
        /// Peak force, N.
        force_n: f64,
        /// Length of the half sine, s.
        length_s: f64,
    },
    /// Constant force at the tool in x from time zero, N.
    Step {
        /// Force, N.
        force_n: f64,
    },
    /// Unbalance of a balance grade.
    Unbalance {
        /// G in m/s: grade G 0.4 is 4e-4.
        grade_m_s: f64,
    },
    /// From the backup bearings, under gravity.
    LiftOff,
}

/// Figures of a response against its limits.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeFigures {
    /// Largest radial displacement at tool, front and rear actuator, m.
    pub displacement_m: [f64; 3],
    /// The same over the last quarter, m.
    pub settled_displacement_m: [f64; 3],
    /// Largest of the two bearing displacements in parts of the clearance; ISO 14839-2 limits it to 0.3 (zone A/B).
    pub clearance_ratio: f64,
    /// Largest control current front, rear, A.
    pub current_a: [f64; 2],
    /// Largest coil voltage front, rear, V.
    pub voltage_v: [f64; 2],
    /// Largest magnetic force front, rear, N.
    pub force_n: [f64; 2],
    /// Largest contact force, N.
    pub contact_force_n: f64,
}

/// Runs a case for `duration_s` at a speed.
///
/// # Errors
/// As [`simulate`].
pub fn run_case(
    machine: &Machine,
    controller: &Float32Program,
    case: StandardCase,
    speed_rad_s: f64,
    duration_s: f64,
    settings: &TimeSettings,
) -> Result<TimeResponse, TimeError> {
    let shares = bearing_shares(machine)?;
    let weight = machine.rotor().map_err(TimeError::Plant)?.mass_properties().mass_kg * GRAVITY;
    let load = |t: f64| -> [f64; LOADS] {
        let mut f = [0.0; LOADS];
        match case {
            StandardCase::Impulse { force_n, length_s } => {
                if (0.0..length_s).contains(&t) {
                    f[0] = force_n * (PI * t / length_s).sin();
                }
            }
            StandardCase::Step { force_n } => {
                if t >= 0.0 {
                    f[0] = force_n;
                }
            }
            StandardCase::Unbalance { grade_m_s } => {
                let force = weight / GRAVITY * grade_m_s * speed_rad_s;
                let (sin, cos) = (speed_rad_s * t).sin_cos();
                for (k, share) in shares.iter().enumerate() {
                    f[2 + 2 * k] = share * force * cos;
                    f[3 + 2 * k] = share * force * sin;
                }
            }
            StandardCase::LiftOff => {
                for (k, share) in shares.iter().enumerate() {
                    f[2 + 2 * k] = -share * weight * FRAC_1_SQRT_2;
                    f[3 + 2 * k] = -share * weight * FRAC_1_SQRT_2;
                }
            }
        }
        f
    };
    let scenario = Scenario {
        speed_rad_s,
        duration_s,
        rest_s: if case == StandardCase::LiftOff { SETTLING_S } else { 0.0 },
        load_n: &load,
    };
    simulate(machine, controller, &scenario, settings)
}

/// Parts of a force at the centre of gravity that the front and rear actuator planes take; they sum to one.
fn bearing_shares(machine: &Machine) -> Result<[f64; 2], SpindleError> {
    let centre = machine.rotor()?.mass_properties().centre_of_gravity_m;
    let planes = &machine.spindle.planes;
    let front = (planes.rear_actuator_m - centre) / planes.bearing_span_m();
    Ok([front, 1.0 - front])
}

/// What the steps of the digitised sensors leave of a response that has settled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantisation {
    /// One step, m.
    pub quantum_m: f64,
    /// Largest radial difference from the response without steps over the last quarter, at tool, front and rear
    /// actuator, m.
    pub displacement_m: [f64; 3],
    /// The same as part of what is left at the tool.
    pub part: f64,
}

impl Quantisation {
    /// A response beside that of the same case with sensors of no steps.
    pub fn of(quantum_m: f64, stepped: &TimeResponse, smooth: &TimeResponse) -> Self {
        let count = stepped.samples.len().min(smooth.samples.len());
        let last = count - count / 4..count;
        let both = || {
            let pairs = stepped.samples[last.clone()].iter();
            pairs.zip(&smooth.samples[last.clone()])
        };
        let difference = |plane: usize| {
            both()
                .map(|(a, b)| {
                    let along = |k: usize| a.displacements_m[k] - b.displacements_m[k];
                    along(2 * plane).hypot(along(2 * plane + 1))
                })
                .fold(0.0, f64::max)
        };
        let left = both().map(|(a, _)| a.displacements_m[0].hypot(a.displacements_m[1])).fold(0.0, f64::max);
        let displacement_m = [0, 1, 2].map(difference);
        Self { quantum_m, displacement_m, part: if left > 0.0 { displacement_m[0] / left } else { 0.0 } }
    }

    /// True when more than half of what is left at the tool comes from the steps.
    pub fn dominates(&self) -> bool {
        self.part > 0.5
    }

    pub(crate) fn sentence(&self) -> String {
        format!(
            "what is left at the tool, {:.0} nm, is the limit cycle of the sensors' step of {:.0} nm",
            1e9 * self.displacement_m[0],
            1e9 * self.quantum_m
        )
    }
}

/// Peaks of a response.
pub fn figures(machine: &Machine, response: &TimeResponse) -> TimeFigures {
    let samples = &response.samples;
    let radial = |from: usize, plane: usize| {
        samples[from.min(samples.len())..]
            .iter()
            .map(|s| s.displacements_m[2 * plane].hypot(s.displacements_m[2 * plane + 1]))
            .fold(0.0, f64::max)
    };
    let last = samples.len() - samples.len() / 4;
    let displacement_m = [0, 1, 2].map(|plane| radial(0, plane));
    let largest = |value: &dyn Fn(usize) -> f64, bearing: usize| -> f64 {
        (0..samples.len())
            .map(|k| value(AXES * k + 2 * bearing).max(value(AXES * k + 2 * bearing + 1)))
            .fold(0.0, f64::max)
    };
    let current = |k: usize| samples[k / AXES].currents_a[k % AXES].abs();
    let voltage = |k: usize| samples[k / AXES].voltages_v[k % AXES].abs();
    let force = |k: usize| samples[k / AXES].forces_n[k % AXES].abs();
    let contact = |k: usize| samples[k / AXES].contact_n[k % AXES].abs();
    TimeFigures {
        settled_displacement_m: [0, 1, 2].map(|plane| radial(last, plane)),
        clearance_ratio: displacement_m[1].max(displacement_m[2]) / machine.spindle.backup_clearance_m,
        displacement_m,
        current_a: [0, 1].map(|b| largest(&current, b)),
        voltage_v: [0, 1].map(|b| largest(&voltage, b)),
        force_n: [0, 1].map(|b| largest(&force, b)),
        contact_force_n: largest(&contact, 0).max(largest(&contact, 1)),
    }
}
