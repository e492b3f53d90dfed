//! Loop gain of each control channel: the loop opened at one sensor, the others closed. L_j = 1/S_jj − 1, so that the
//! critical point is −1; where it crosses a gain of one and the negative real axis, and the margins there.

use super::closed_loop::{AXES, sensitivity};
use crate::linalg::c64;
use crate::lti::{FrequencyGrid, HeldResponse, Response};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Loop gain of the four channels.
#[derive(Clone, Debug)]
pub struct LoopGain {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// L of front x, front y, rear x and rear y.
    pub channels: [Vec<c64>; AXES],
    /// L far below the lowest line, which stands for that of a constant displacement.
    constant: [c64; AXES],
}

/// What one channel may change by while the others stay as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelMargin {
    /// Largest factor below 1 on the gain at which the loop is no longer stable; 0 where every smaller gain is stable.
    pub smallest_gain_factor: f64,
    /// Smallest factor above 1 of that kind; infinite where every larger gain is stable.
    pub largest_gain_factor: f64,
    /// Smallest phase by which the loop may lag or lead, degrees; not a number without a crossover.
    pub phase_deg: f64,
    /// The gain crossover at which it is smallest, Hz; not a number without one.
    pub phase_hz: f64,
    /// Highest frequency at which |L| = 1, Hz; not a number where there is none.
    pub crossover_hz: f64,
}

/// The line that stands for a constant displacement, as a share of the lowest line: an integrator that acts within
/// minutes still shows there.
const CONSTANT: f64 = 1e-3;

impl LoopGain {
    /// On the lines of a grid.
    pub fn new(plant: &dyn Response, controller: &dyn HeldResponse, grid: &FrequencyGrid) -> Self {
        let at = |omega: f64| {
            let s = sensitivity(plant, controller, omega);
            std::array::from_fn::<c64, AXES, _>(|j| s[(j, j)].inv() - 1.0)
        };
        let lines = grid.omega_rad_s();
        let all: Vec<[c64; AXES]> = lines.par_iter().map(|w| at(*w)).collect();
        Self {
            frequency_hz: grid.hz(),
            channels: std::array::from_fn(|j| all.iter().map(|l| l[j]).collect()),
            constant: at(CONSTANT * lines.first().copied().unwrap_or(TAU)),
        }
    }

    /// Margins of a channel, L linear between lines.
    pub fn margin(&self, channel: usize) -> ChannelMargin {
        let mut margin = ChannelMargin {
            smallest_gain_factor: 0.0,
            largest_gain_factor: f64::INFINITY,
            phase_deg: f64::NAN,
            phase_hz: f64::NAN,
            crossover_hz: f64::NAN,
        };
        // A constant gain is real; that of an integrator is not.
        let constant = self.constant[channel];
        if constant.im.abs() < constant.re.abs() {
            margin.cross_axis(constant.re);
        }
        let lines = self.frequency_hz.iter().zip(&self.channels[channel]);
        for ((f0, l0), (f1, l1)) in lines.clone().zip(lines.skip(1)) {
            let between = |share: f64| l0 + (l1 - l0) * share;
            if (l0.im < 0.0) != (l1.im < 0.0) {
                margin.cross_axis(between(l0.im / (l0.im - l1.im)).re);
            }
            let (a, b) = (l0.norm().ln(), l1.norm().ln());
            if (a < 0.0) != (b < 0.0) {
                let share = a / (a - b);
                margin.cross_one(between(share), f0 * (f1 / f0).powf(share));
            }
        }
        margin
    }
}

impl ChannelMargin {
    /// L is real there.
    fn cross_axis(&mut self, real: f64) {
        let factor = -1.0 / real;
        if factor > 1.0 {
            self.largest_gain_factor = self.largest_gain_factor.min(factor);
        } else if factor > 0.0 {
            self.smallest_gain_factor = self.smallest_gain_factor.max(factor);
        }
    }

    /// |L| is one there.
    fn cross_one(&mut self, gain: c64, hz: f64) {
        let phase_deg = (-gain).arg().abs().to_degrees();
        if self.phase_deg.is_nan() || phase_deg < self.phase_deg {
            (self.phase_deg, self.phase_hz) = (phase_deg, hz);
        }
        self.crossover_hz = self.crossover_hz.max(hz);
    }
}
