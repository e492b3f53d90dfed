//! The worst case of a closed-loop response over uncertain natural frequencies, bounded from both sides at every
//! frequency.
//!
//! The modal stiffness of flexible mode k is ω_k²(1 + κ_k) with κ_k real in [(1−r_k)² − 1, (1+r_k)² − 1]: natural
//! frequency within ±r_k, the same κ_k in both planes. With the modal ports of the plant and u = K y closed,
//!   f(κ) = N₂₂ + N₂₁ D(κ) (I − N₁₁ D(κ))⁻¹ N₁₂,   D(κ) = diag(κ_k I₂),
//! for the compliance at the tool and the sensitivity of every axis; max |f| over the box by branch and bound
//! (`worst_search`).
//! Limits: dampers 2ζω of the modes keep their values; bounds hold at the frequencies asked, not between them.

use super::closed_loop::AXES;
use super::worst_search::ChannelSearch;
pub use super::worst_search::{Extreme, SETTLED};
use crate::linalg::{Mat, c64, solve_complex};
use crate::lti::{FrequencyGrid, HeldResponse, Response};
use crate::spindle::Plant;
use crate::spindle::plant::CHANNELS;
use rayon::prelude::*;

/// Natural-frequency uncertainty of the first flexible modes, relative (0.01 for ±1 %); zeros are left out of the
/// search.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeUncertainty {
    /// r of each mode in order.
    pub relative: Vec<f64>,
}

impl ModeUncertainty {
    /// Frequency factors of the corners of the box, and its centre first.
    pub fn corners(&self) -> Vec<Vec<f64>> {
        let uncertain: Vec<usize> = (0..self.relative.len()).filter(|k| self.relative[*k] > 0.0).collect();
        let mut all = vec![vec![1.0; self.relative.len()]];
        for signs in 0..1usize << uncertain.len() {
            let mut factors = vec![1.0; self.relative.len()];
            for (bit, k) in uncertain.iter().enumerate() {
                let sign = if (signs >> bit) & 1 == 0 { -1.0 } else { 1.0 };
                factors[*k] += sign * self.relative[*k];
            }
            all.push(factors);
        }
        if uncertain.is_empty() {
            all.truncate(1);
        }
        all
    }
}

/// Worst case over frequency of one channel.
#[derive(Clone, Debug)]
pub struct WorstCurve {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Bounds at each line.
    pub lines: Vec<Extreme>,
}

impl WorstCurve {
    /// Drops the lines at other frequencies than these.
    pub(crate) fn retain_lines(&mut self, counts: impl Fn(f64) -> bool) {
        let both = std::mem::take(&mut self.frequency_hz).into_iter().zip(std::mem::take(&mut self.lines));
        (self.frequency_hz, self.lines) = both.filter(|(hz, _)| counts(*hz)).unzip();
    }

    /// The line with the largest upper bound and its frequency, Hz; `None` on an empty grid.
    pub(crate) fn peak(&self) -> Option<(f64, &Extreme)> {
        let all = self.frequency_hz.iter().copied().zip(&self.lines);
        all.max_by(|a, b| a.1.upper.total_cmp(&b.1.upper))
    }

    /// The bounds at the line nearest to a frequency; `None` on an empty grid.
    pub(crate) fn near(&self, frequency_hz: f64) -> Option<&Extreme> {
        let all = self.frequency_hz.iter().zip(&self.lines);
        all.min_by(|a, b| (a.0 - frequency_hz).abs().total_cmp(&(b.0 - frequency_hz).abs())).map(|(_, line)| line)
    }
}

/// Worst cases of a loop: compliance at the tool per axis (m/N), sensitivity per control axis.
#[derive(Clone, Debug)]
pub struct WorstCase {
    /// Tool compliance, x and y.
    pub compliance: [WorstCurve; 2],
    /// |S_jj| of front_x, front_y, rear_x, rear_y.
    pub sensitivity: [WorstCurve; AXES],
}

/// Channels in the order of [`WorstCase`]: two of the tool, four of the sensors.
const OUTPUTS: usize = 2 + AXES;
/// Channels of the planes count as equal when they differ by less than this fraction of the larger: then one is
/// searched.
const SAME: f64 = 1e-9;

/// Worst case over `uncertainty` on a grid. The plant is the one of the prediction, without modal ports.
pub fn worst_case(
    plant: &Plant,
    controller: &dyn HeldResponse,
    uncertainty: &ModeUncertainty,
    grid: &FrequencyGrid,
) -> WorstCase {
    let modes = uncertainty.relative.len();
    let with_ports = plant.with_modal_ports(modes);
    let omega = &plant.flexible_rad_s()[..modes.min(plant.flexible_rad_s().len())];
    let lines: Vec<[Extreme; OUTPUTS]> =
        grid.omega_rad_s().par_iter().map(|w| at_frequency(&with_ports, controller, uncertainty, omega, *w)).collect();
    let curve = |channel: usize| WorstCurve {
        frequency_hz: grid.hz(),
        lines: lines.iter().map(|l| l[channel].clone()).collect(),
    };
    WorstCase { compliance: [0, 1].map(curve), sensitivity: [2, 3, 4, 5].map(curve) }
}

fn at_frequency(
    plant: &Plant,
    controller: &dyn HeldResponse,
    uncertainty: &ModeUncertainty,
    omega_rad_s: &[f64],
    omega: f64,
) -> [Extreme; OUTPUTS] {
    let n = close_plant(plant, controller, omega_rad_s, omega);
    let m = 2 * omega_rad_s.len();
    let kappa: Vec<[f64; 2]> = uncertainty
        .relative
        .iter()
        .take(omega_rad_s.len())
        .map(|r| [(1.0 - r).powi(2) - 1.0, (1.0 + r).powi(2) - 1.0])
        .collect();
    let both = |x: usize| {
        if alike(&n, m, x, x + 1) {
            let found = ChannelSearch::of_equal_planes(&n, m, x).run(&kappa);
            [found.clone(), found]
        } else {
            [x, x + 1].map(|channel| ChannelSearch::new(&n, m, channel).run(&kappa))
        }
    };
    let [[tool_x, tool_y], [front_x, front_y], [rear_x, rear_y]] = [0, 2, 4].map(both);
    [tool_x, tool_y, front_x, front_y, rear_x, rear_y]
}

/// N: outputs (q, tool, signals) × inputs (forces of the stiffness changes per κ, tool forces, disturbances at the
/// sensors).
fn close_plant(plant: &Plant, controller: &dyn HeldResponse, omega_rad_s: &[f64], omega: f64) -> Mat<c64> {
    let p = plant.at(omega);
    let k = controller.held_at(omega);
    let m = 2 * omega_rad_s.len();
    let zero = c64::new(0.0, 0.0);
    let one = c64::new(1.0, 0.0);
    // A stiffness change κ pushes mode k by −ω_k² κ q.
    let inputs = |row: usize, column: usize| match column {
        c if c < m => p[(row, CHANNELS + c)] * -omega_rad_s[c / 2].powi(2),
        c if c < m + 2 => p[(row, AXES + c - m)],
        _ => zero,
    };
    let difference = Mat::from_fn(AXES, AXES, |i, j| {
        let own = if i == j { one } else { zero };
        (0..AXES).fold(own, |sum, l| sum - p[(i, l)] * k[(l, j)])
    });
    let disturbed = Mat::from_fn(AXES, m + OUTPUTS, |i, j| inputs(i, j) + if j == m + 2 + i { one } else { zero });
    let signals = solve_complex(&difference, &disturbed);
    let currents = &k * &signals;
    Mat::from_fn(m + OUTPUTS, m + OUTPUTS, |i, j| {
        let row = match i {
            i if i < m => CHANNELS + i,
            i if i < m + 2 => AXES + i - m,
            _ => return signals[(i - m - 2, j)],
        };
        (0..AXES).fold(inputs(row, j), |sum, l| sum + p[(row, l)] * currents[(l, j)])
    })
}

/// Whether channel b is channel a with x and y exchanged and y reversed, as in an isotropic machine.
fn alike(n: &Mat<c64>, m: usize, a: usize, b: usize) -> bool {
    let turned = |i: usize| {
        if i < m { i ^ 1 } else { m + (if i == m + a { b } else { a }) }
    };
    // x stands at even places everywhere; a quarter turn takes (x, y) to (−y, x).
    let sign = |i: usize| if i.is_multiple_of(2) { -1.0 } else { 1.0 };
    let own: Vec<usize> = (0..m).chain([m + a]).collect();
    own.iter().all(|i| {
        own.iter().all(|j| {
            let (x, y) = (n[(*i, *j)], n[(turned(*i), turned(*j))] * (sign(*i) * sign(*j)));
            (x - y).norm_sqr() <= SAME * SAME * x.norm_sqr().max(y.norm_sqr()) + f64::MIN_POSITIVE
        })
    })
}
