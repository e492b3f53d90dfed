//! Starts for the search of a PID, from the machine alone: rigid-body dynamics on negative stiffness, and filters drawn
//! at random between the first bending mode and Nyquist, screened by the argument principle.
//!
//! With P unstable poles of the plant the phase of det(I − G K), without its integrators, increases by π(P − Z) from
//! zero to the Nyquist frequency, with Z the unstable poles of the loop: a start is stable where it increases by πP, at
//! rest and at top speed.

use super::parameters::{AxisParameters, Biquad, PidParameters};
use crate::controller::polish::line_state::turns_of;
use crate::controller::polish::matrix2::ONE;
use crate::controller::polish::responses::{LoopResponse, Rotor};
use crate::controller::polish::structure::Line;
use crate::linalg::c64;
use crate::spindle::{Machine, Side, SpindleError};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Rigid-body dynamics that a bearing acts on.
#[derive(Clone, Copy, Debug)]
struct Bearing {
    ki: f64,
    ks: f64,
    /// Mass that the rigid rotor shows there, kg.
    mass: f64,
    /// √(k_s/m), or what the first bending mode allows where k_s is small, rad/s.
    omega: f64,
}

/// What starts are drawn from.
pub(super) struct StartRule {
    bearings: [Bearing; 2],
    /// Lowest flexible mode, rad/s.
    bending: f64,
    nyquist: f64,
}

impl StartRule {
    /// The rule of a machine; `bending_rad_s` is its lowest flexible mode.
    ///
    /// # Errors
    /// [`SpindleError`] when the rotor breaks a rule.
    pub(super) fn new(machine: &Machine, bending_rad_s: f64) -> Result<Self, SpindleError> {
        let rigid = machine.rotor()?.mass_properties();
        let bearing = |side: Side, position_m: f64| {
            let b = machine.spindle.bearing(side);
            let lever = position_m - rigid.centre_of_gravity_m;
            let mass = 1.0 / (1.0 / rigid.mass_kg + lever * lever / rigid.diametral_inertia_kg_m2);
            Bearing {
                ki: b.ki_n_per_a,
                ks: b.ks_n_per_m,
                mass,
                omega: (b.ks_n_per_m.abs() / mass).sqrt().max(0.05 * bending_rad_s),
            }
        };
        let planes = &machine.spindle.planes;
        Ok(Self {
            bearings: [
                bearing(Side::Front, planes.front_actuator_m),
                bearing(Side::Rear, planes.rear_actuator_m),
            ],
            bending: bending_rad_s,
            nyquist: PI * machine.spindle.electronics.sample_rate_hz,
        })
    }

    /// One start: stiffness m(aω)² over the negative stiffness and damping ζ as a rigid rotor would have them, corners
    /// and sections drawn. Every other start has flat sections.
    fn draw(&self, random: &mut ChaCha8Rng, flat: bool) -> PidParameters {
        let mut spread = |from: f64, to: f64| from * (to / from).powf(random.random::<f64>());
        // Both bearings alike, up to a factor each.
        let (stiff, damped) = (spread(0.15, 5.0), spread(0.15, 8.0));
        let corners = [spread(0.03, 0.8), spread(0.05, 0.8)];
        let axis = self.bearings.map(|b| {
            let omega = b.omega * stiff * spread(0.7, 1.4);
            let zeta = damped * spread(0.7, 1.4);
            let gain = (b.ks.abs() + b.mass * omega * omega) / b.ki;
            let low = 0.5 * self.bending.min(0.3 * self.nyquist);
            let high = (6.0 * self.bending).clamp(2.0 * low, 0.75 * self.nyquist);
            let mut section = || {
                if flat {
                    let w = spread(low, high);
                    return Biquad {
                        zero_rad_s: w,
                        zero_damping: 0.5,
                        pole_rad_s: w,
                        pole_damping: 0.5,
                    };
                }
                let zero = spread(low, high);
                Biquad {
                    zero_rad_s: zero,
                    zero_damping: spread(0.03, 1.0),
                    pole_rad_s: (zero * spread(0.4, 2.5)).min(0.75 * self.nyquist),
                    pole_damping: spread(0.05, 1.0),
                }
            };
            AxisParameters {
                gain_a_per_m: gain,
                integral_rad_s: 2.0 * PI,
                derivative_s: 2.0 * zeta * b.mass * omega / (b.ki * gain),
                derivative_corner_rad_s: corners[0] * self.nyquist,
                lowpass_rad_s: corners[1] * self.nyquist,
                biquads: [section(), section()],
            }
        });
        PidParameters {
            front: axis[0],
            rear: axis[1],
        }
    }
}

/// A start with what the screening saw of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    /// Parameters.
    pub parameters: PidParameters,
    /// Unstable poles of the loops screened, summed.
    pub unstable: i64,
    /// Largest |S_jj| over them; infinite where one is unstable.
    pub sensitivity: f64,
}

/// `count` starts drawn from `seed` and screened on `rotors`, best first: fewest unstable poles, then smallest
/// sensitivity. `shape` puts each into the form searched for; `unstable_poles` is P of one plane.
pub(super) fn starts(
    rule: &StartRule,
    (count, seed): (usize, u64),
    (lines, rotors): (&[Line], &[&Rotor]),
    unstable_poles: i64,
    shape: &(dyn Fn(PidParameters) -> Option<PidParameters> + Sync),
) -> Vec<Start> {
    let mut found: Vec<Start> = (0..count)
        .into_par_iter()
        .filter_map(|k| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(k as u64);
            let parameters = shape(rule.draw(&mut random, k % 2 == 0))?;
            Some(screen(parameters, lines, rotors, unstable_poles))
        })
        .collect();
    // The sort is stable: equal starts stay in the order drawn.
    found.sort_by(|a, b| {
        a.unstable
            .cmp(&b.unstable)
            .then(a.sensitivity.total_cmp(&b.sensitivity))
    });
    found
}

/// Counts the unstable poles of the loops with a PID.
pub(super) fn screen(
    parameters: PidParameters,
    lines: &[Line],
    rotors: &[&Rotor],
    unstable_poles: i64,
) -> Start {
    // Of both axes −C, and their product without integrators over that with them.
    let gains: Vec<([c64; 2], c64)> = lines
        .iter()
        .map(|line| {
            let (front, rear) = (&parameters.front, &parameters.rear);
            let gain = [front, rear].map(|a| -a.response_on_axis(line.s.im));
            let corners = (line.s + front.integral_rad_s) * (line.s + rear.integral_rad_s);
            (gain, line.s * line.s / corners)
        })
        .collect();
    let mut unstable = 0;
    for rotor in rotors {
        let turns = turns_of(rotor.directions.iter().map(|side| {
            let loops = side.iter().zip(&gains);
            loops.map(|(g, (k, free))| loop_at(g, k).0 * free)
        }));
        let right = if turns.is_finite() {
            turns as i64
        } else {
            i64::MIN / 4
        };
        unstable += (unstable_poles - right).abs();
    }
    // Only stable loops are ordered by their sensitivity.
    let mut sensitivity = f64::INFINITY;
    if unstable == 0 {
        let sides = rotors.iter().flat_map(|rotor| &rotor.directions);
        let squares = sides
            .flat_map(|side| side.iter().zip(&gains))
            .map(|(g, (k, _))| {
                let (determinant, larger) = loop_at(g, k);
                larger / determinant.norm_sqr()
            });
        sensitivity = squares.fold(0.0, f64::max).sqrt();
    }
    Start {
        parameters,
        unstable,
        sensitivity,
    }
}

/// det(I − G K) of a diagonal K, and the larger |S_jj|² times its square.
fn loop_at(g: &LoopResponse, k: &[c64; 2]) -> (c64, f64) {
    let (a, b) = (ONE - g.loops[0][0] * k[0], ONE - g.loops[1][1] * k[1]);
    let determinant = a * b - g.loops[0][1] * g.loops[1][0] * (k[0] * k[1]);
    (determinant, a.norm_sqr().max(b.norm_sqr()))
}
