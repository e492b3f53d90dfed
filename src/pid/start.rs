//! Starts for the search of a PID, from the machine alone: rigid-body dynamics on negative stiffness, and filters drawn
//! at random between the first bending mode and Nyquist, screened by the argument principle.
//!
//! With P unstable poles of the plant the phase of det(I − G K), without its integrators, increases by π(P − Z) from
//! zero to the Nyquist frequency, with Z the unstable poles of the loop: a start is stable where it increases by πP, at
//! rest and at top speed.

use super::parameters::{AxisParameters, Biquad, PidParameters, each_gain};
use super::rigid_bearing::{RigidBearing, rigid_bearings};
use crate::controller::polish::phase_count::{PhaseCount, turns_of};
use crate::controller::polish::responses::{LoopResponse, ServedRotor};
use crate::controller::polish::structure::LoopLine;
use crate::linalg::c64;
use crate::linalg::lanes::{Lanes, Reals, WIDTH};
use crate::spindle::{Machine, SpindleError};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;

/// What starts are drawn from.
pub(super) struct StartRule {
    bearings: [RigidBearing; 2],
    /// Lowest flexible mode, rad/s.
    bending: f64,
    nyquist: f64,
}

impl StartRule {
    /// The rule of a machine; `bending_rad_s` is its lowest flexible mode.
    pub(super) fn new(machine: &Machine, bending_rad_s: f64) -> Result<Self, SpindleError> {
        Ok(Self {
            bearings: rigid_bearings(machine, bending_rad_s)?,
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
            let omega = b.omega_rad_s * stiff * spread(0.7, 1.4);
            let zeta = damped * spread(0.7, 1.4);
            let gain = (b.ks_n_per_m.abs() + b.mass_kg * omega * omega) / b.ki_n_per_a;
            let low = 0.5 * self.bending.min(0.3 * self.nyquist);
            let high = (6.0 * self.bending).clamp(2.0 * low, 0.75 * self.nyquist);
            let mut section = || {
                if flat {
                    let w = spread(low, high);
                    return Biquad { zero_rad_s: w, zero_damping: 0.5, pole_rad_s: w, pole_damping: 0.5 };
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
                derivative_s: 2.0 * zeta * b.mass_kg * omega / (b.ki_n_per_a * gain),
                derivative_corner_rad_s: corners[0] * self.nyquist,
                lowpass_rad_s: corners[1] * self.nyquist,
                biquads: [section(), section()],
            }
        });
        PidParameters { front: axis[0], rear: axis[1] }
    }
}

/// A start with what the screening saw of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    pub parameters: PidParameters,
    /// Unstable poles of the loops screened, summed.
    pub unstable: i64,
    /// Largest |S_jj| over them; infinite where one is unstable.
    pub sensitivity: f64,
}

/// Nominal loops of the machine that starts are screened on, four in a pack.
pub(super) struct Screen<'a> {
    lines: &'a [LoopLine],
    /// Packs, each of all lines.
    packs: Vec<Vec<ScreenedLoops>>,
    /// Flat indices of the loops of each rotor, and its unstable poles.
    rotors: Vec<(Range<usize>, i64)>,
}

/// Four loops at a line, as far as a diagonal K shows them.
#[derive(Clone, Copy, Debug)]
struct ScreenedLoops {
    /// G₁₁ and G₂₂.
    own: [Lanes; 2],
    /// G₁₂ G₂₁.
    beside: Lanes,
}

impl ScreenedLoops {
    fn new(list: &[&LoopResponse]) -> Self {
        Self {
            own: [0, 1].map(|j| Lanes::of_list(list, |own| own.loops[j][j])),
            beside: Lanes::of_list(list, |own| own.loops[0][1] * own.loops[1][0]),
        }
    }

    /// 1 − G_jj K_j, and det(I − G K), of a diagonal K.
    #[inline]
    fn close_loops(&self, k: &[c64; 2]) -> ([Lanes; 2], Lanes) {
        let open = [0, 1].map(|j| Lanes::ONE.plus(-k[j], &self.own[j]));
        let determinant = open[0].product(&open[1]);
        (open, determinant.plus(-(k[0] * k[1]), &self.beside))
    }
}

impl<'a> Screen<'a> {
    /// The nominal ones of some rotors on their lines.
    pub(super) fn new(lines: &'a [LoopLine], rotors: &[ServedRotor]) -> Self {
        let nominal = rotors.iter().filter(|rotor| rotor.role.is_nominal());
        let mut list: Vec<&Vec<LoopResponse>> = vec![];
        let mut sides = vec![];
        for rotor in nominal {
            sides.push((list.len()..list.len() + rotor.directions.len(), rotor.unstable_poles));
            list.extend(&rotor.directions);
        }
        let pack = |four: &[&Vec<LoopResponse>]| {
            let at = |k: usize| four.iter().map(|side| &side[k]).collect::<Vec<_>>();
            let lines = 0..lines.len();
            lines.map(|k| ScreenedLoops::new(&at(k))).collect()
        };
        Self { lines, packs: list.chunks(WIDTH).map(pack).collect(), rotors: sides }
    }

    /// Of both axes −C at each line.
    fn gains(&self, parameters: &PidParameters) -> Vec<[c64; 2]> {
        let mut gains = Vec::with_capacity(self.lines.len());
        let axes = [&parameters.front, &parameters.rear].map(Some);
        each_gain(axes, self.lines, |both| gains.push(both));
        gains
    }

    /// Counts the unstable poles of the loops with a PID.
    pub(super) fn start(&self, parameters: PidParameters) -> Start {
        let (front, rear) = (&parameters.front, &parameters.rear);
        let gains = self.gains(&parameters);
        let determinant = |(line, (loops, k)): (&LoopLine, (&ScreenedLoops, &[c64; 2]))| {
            // The product of both axes without integrators over that with them, but for its size.
            let corners = (line.s + front.integral_rad_s) * (line.s + rear.integral_rad_s);
            Lanes::ZERO.plus(-corners.conj(), &loops.close_loops(k).1)
        };
        let mut phases = Vec::with_capacity(WIDTH * self.packs.len());
        for pack in &self.packs {
            let loops = self.lines.iter().zip(pack.iter().zip(&gains));
            let mut determinants = loops.map(determinant);
            let mut count = determinants.next().as_ref().map(PhaseCount::new);
            if let Some(count) = &mut count {
                determinants.for_each(|next| count.add(&next));
            }
            phases.extend(PhaseCount::phases(count.iter()));
        }
        let mut unstable = 0;
        for (sides, unstable_poles) in &self.rotors {
            let turns = turns_of(phases[sides.clone()].iter().copied());
            unstable += (unstable_poles - turns).abs();
        }
        // Only stable loops are ordered by their sensitivity.
        let sensitivity = match unstable {
            0 => self.largest_sensitivity(&gains),
            _ => f64::INFINITY,
        };
        Start { parameters, unstable, sensitivity }
    }

    /// Largest |S_jj| of the loops with a diagonal K; what fills up a pack has one.
    fn largest_sensitivity(&self, gains: &[[c64; 2]]) -> f64 {
        let mut largest = Reals::splat(0.0);
        for pack in &self.packs {
            for (loops, k) in pack.iter().zip(gains) {
                let (open, determinant) = loops.close_loops(k);
                let square = determinant.squares();
                for own in open {
                    largest = largest.max(own.squares() / square);
                }
            }
        }
        largest.to_array().into_iter().fold(0.0, f64::max).sqrt()
    }
}

/// `count` starts drawn from `seed` and screened, best first: fewest unstable poles, then smallest sensitivity. `shape`
/// puts each into the form searched for.
pub(super) fn starts(
    rule: &StartRule,
    (count, seed): (usize, u64),
    screen: &Screen,
    shape: &(dyn Fn(PidParameters) -> Option<PidParameters> + Sync),
) -> Vec<Start> {
    let mut found: Vec<Start> = (0..count)
        .into_par_iter()
        .filter_map(|k| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(k as u64);
            let parameters = shape(rule.draw(&mut random, k % 2 == 0))?;
            Some(screen.start(parameters))
        })
        .collect();
    // The sort is stable: equal starts stay in the order drawn.
    found.sort_by(|a, b| a.unstable.cmp(&b.unstable).then(a.sensitivity.total_cmp(&b.sensitivity)));
    found
}
