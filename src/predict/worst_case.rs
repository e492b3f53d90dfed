//! The worst case of a closed-loop response over uncertain natural frequencies, bounded from both sides at every
//! frequency.
//!
//! The modal stiffness of flexible mode k is ω_k²(1 + κ_k) with κ_k real in [(1−r_k)² − 1, (1+r_k)² − 1]: natural
//! frequency within ±r_k, the same κ_k in both planes. With the modal ports of the plant and u = K y closed,
//!   f(κ) = N₂₂ + N₂₁ D(κ) (I − N₁₁ D(κ))⁻¹ N₁₂,   D(κ) = diag(κ_k I₂),
//! for the compliance at the tool and the sensitivity of every axis. max |f| over the box by branch and bound (a box is
//! halved until the bounds meet): below, f at a point of the box; above, in coordinates κ = c + ρδ, |δ| ≤ 1, of a box,
//!   |f| ≤ max over the corners of |N₂₂ + Σ N₂₁ρδN₁₂| + |N₂₁|ρ A (I − A)⁻¹ |N₁₂|,  A = |N₁₁|ρ with spectral radius
//!   below one,
//! the first order exactly and the rest by moduli (Neumann series), so that the gap closes with the square of the box.
//! Limits: dampers 2ζω of the modes keep their values; bounds hold at the frequencies asked, not between them.

use super::closed_loop::AXES;
use crate::linalg::{Mat, c64, solve, solve_complex};
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
        let uncertain: Vec<usize> = (0..self.relative.len())
            .filter(|k| self.relative[*k] > 0.0)
            .collect();
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

/// Both bounds of max |f| at a frequency, the nominal value, and a κ that attains the lower bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Extreme {
    /// |f(0)|.
    pub nominal: f64,
    /// Attained.
    pub lower: f64,
    /// Never exceeded; infinite when the search ended before the loop was seen to stay regular.
    pub upper: f64,
    /// Frequency factors √(1 + κ) of the point that attains `lower`.
    pub factors: Vec<f64>,
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
    /// The line with the largest upper bound and its frequency, Hz; `None` on an empty grid.
    pub(crate) fn peak(&self) -> Option<(f64, &Extreme)> {
        let all = self.frequency_hz.iter().copied().zip(&self.lines);
        all.max_by(|a, b| a.1.upper.total_cmp(&b.1.upper))
    }

    /// The bounds at the line nearest to a frequency; `None` on an empty grid.
    pub(crate) fn near(&self, frequency_hz: f64) -> Option<&Extreme> {
        let all = self.frequency_hz.iter().zip(&self.lines);
        all.min_by(|a, b| {
            (a.0 - frequency_hz)
                .abs()
                .total_cmp(&(b.0 - frequency_hz).abs())
        })
        .map(|(_, line)| line)
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
/// A bound is settled when upper and lower differ by less than this fraction.
pub const SETTLED: f64 = 2e-3;
/// Boxes at most at one frequency and channel; two dozen are usual.
const MOST_BOXES: usize = 3000;
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
    let lines: Vec<[Extreme; OUTPUTS]> = grid
        .omega_rad_s()
        .par_iter()
        .map(|w| at_frequency(&with_ports, controller, uncertainty, omega, *w))
        .collect();
    let curve = |channel: usize| WorstCurve {
        frequency_hz: grid.hz(),
        lines: lines.iter().map(|l| l[channel].clone()).collect(),
    };
    WorstCase {
        compliance: [0, 1].map(curve),
        sensitivity: [2, 3, 4, 5].map(curve),
    }
}

/// All channels at one frequency.
fn at_frequency(
    plant: &Plant,
    controller: &dyn HeldResponse,
    uncertainty: &ModeUncertainty,
    omega_rad_s: &[f64],
    omega: f64,
) -> [Extreme; OUTPUTS] {
    let n = closed(plant, controller, omega_rad_s, omega);
    let m = 2 * omega_rad_s.len();
    let kappa: Vec<[f64; 2]> = uncertainty
        .relative
        .iter()
        .take(omega_rad_s.len())
        .map(|r| [(1.0 - r).powi(2) - 1.0, (1.0 + r).powi(2) - 1.0])
        .collect();
    let one = |channel: usize| Search::new(&n, m, channel).run(&kappa);
    let same = |a: usize, b: usize| alike(&n, m, a, b);
    let tool = one(0);
    let front = one(2);
    let rear = one(4);
    let other = |first: usize, found: &Extreme| {
        if same(first, first + 1) {
            found.clone()
        } else {
            one(first + 1)
        }
    };
    let (tool_y, front_y, rear_y) = (other(0, &tool), other(2, &front), other(4, &rear));
    [tool, tool_y, front, front_y, rear, rear_y]
}

/// N: outputs (q, tool, signals) × inputs (forces of the stiffness changes per κ, tool forces, disturbances at the
/// sensors).
fn closed(
    plant: &Plant,
    controller: &dyn HeldResponse,
    omega_rad_s: &[f64],
    omega: f64,
) -> Mat<c64> {
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
    let disturbed = Mat::from_fn(AXES, m + OUTPUTS, |i, j| {
        inputs(i, j) + if j == m + 2 + i { one } else { zero }
    });
    let signals = solve_complex(&difference, &disturbed);
    let currents = &k * &signals;
    Mat::from_fn(m + OUTPUTS, m + OUTPUTS, |i, j| {
        let row = match i {
            i if i < m => CHANNELS + i,
            i if i < m + 2 => AXES + i - m,
            _ => return signals[(i - m - 2, j)],
        };
        (0..AXES).fold(inputs(row, j), |sum, l| {
            sum + p[(row, l)] * currents[(l, j)]
        })
    })
}

/// Whether channel b is channel a with x and y exchanged and y reversed, as in an isotropic machine.
fn alike(n: &Mat<c64>, m: usize, a: usize, b: usize) -> bool {
    let turned = |i: usize| {
        if i < m {
            i ^ 1
        } else {
            m + (if i == m + a { b } else { a })
        }
    };
    // x stands at even places everywhere; a quarter turn takes (x, y) to (−y, x).
    let sign = |i: usize| if i.is_multiple_of(2) { -1.0 } else { 1.0 };
    let own: Vec<usize> = (0..m).chain([m + a]).collect();
    own.iter().all(|i| {
        own.iter().all(|j| {
            let (x, y) = (
                n[(*i, *j)],
                n[(turned(*i), turned(*j))] * (sign(*i) * sign(*j)),
            );
            (x - y).norm() <= SAME * x.norm().max(y.norm()) + f64::MIN_POSITIVE
        })
    })
}

/// One channel at one frequency.
struct Search {
    n11: Mat<c64>,
    n12: Mat<c64>,
    n21: Mat<c64>,
    n22: c64,
}

/// A box with its upper bound.
struct Branch {
    centre: Vec<f64>,
    half: Vec<f64>,
    upper: f64,
    split: usize,
}

impl Search {
    fn new(n: &Mat<c64>, m: usize, channel: usize) -> Self {
        Self {
            n11: n.submatrix(0, 0, m, m).to_owned(),
            n12: n.submatrix(0, m + channel, m, 1).to_owned(),
            n21: n.submatrix(m + channel, 0, 1, m).to_owned(),
            n22: n[(m + channel, m + channel)],
        }
    }

    fn run(&self, kappa: &[[f64; 2]]) -> Extreme {
        let nominal = self.n22.norm();
        let centre: Vec<f64> = kappa.iter().map(|k| 0.5 * (k[0] + k[1])).collect();
        let half: Vec<f64> = kappa.iter().map(|k| 0.5 * (k[1] - k[0])).collect();
        let mut best = (nominal, vec![0.0; kappa.len()]);
        if half.iter().all(|h| *h == 0.0) {
            return extreme(nominal, nominal, best);
        }
        let mut open = vec![self.bound(centre, half, &mut best)];
        let mut settled = 0.0f64;
        for _ in 0..MOST_BOXES {
            // The box with the largest bound; ties fall to the first, so that the order is fixed.
            let Some(k) =
                (0..open.len()).reduce(|a, b| if open[b].upper > open[a].upper { b } else { a })
            else {
                break;
            };
            if open[k].upper <= best.0 * (1.0 + SETTLED) {
                break;
            }
            let parent = open.swap_remove(k);
            for side in [-1.0, 1.0] {
                let (mut centre, mut half) = (parent.centre.clone(), parent.half.clone());
                half[parent.split] *= 0.5;
                centre[parent.split] += side * half[parent.split];
                let child = self.bound(centre, half, &mut best);
                if child.upper > best.0 * (1.0 + SETTLED) {
                    open.push(child);
                } else {
                    settled = settled.max(child.upper);
                }
            }
        }
        let upper = open
            .iter()
            .map(|b| b.upper)
            .fold(settled.max(best.0), f64::max);
        extreme(nominal, upper, best)
    }

    /// f recentred at κ = c: (I − N₁₁C)⁻¹ applied to N₁₁ and N₁₂, N₂₁ and N₂₂ to fit.
    fn recentred(&self, centre: &[f64]) -> (Mat<c64>, Mat<c64>, Vec<c64>, c64) {
        let m = self.n11.nrows();
        let c = |k: usize| centre[k / 2];
        let unit = Mat::from_fn(m, m, |i, j| {
            c64::new(f64::from(u8::from(i == j)), 0.0) - self.n11[(i, j)] * c(j)
        });
        let both = Mat::from_fn(m, m + 1, |i, j| {
            if j < m {
                self.n11[(i, j)]
            } else {
                self.n12[(i, 0)]
            }
        });
        let solved = solve_complex(&unit, &both);
        let n11 = solved.submatrix(0, 0, m, m).to_owned();
        let n12 = solved.submatrix(0, m, m, 1).to_owned();
        let n21 = (0..m)
            .map(|j| {
                (0..m).fold(self.n21[(0, j)], |sum, i| {
                    sum + self.n21[(0, i)] * c(i) * n11[(i, j)]
                })
            })
            .collect();
        let n22 = (0..m).fold(self.n22, |sum, i| {
            sum + self.n21[(0, i)] * c(i) * n12[(i, 0)]
        });
        (n11, n12, n21, n22)
    }

    /// Upper bound over a box; points met on the way raise `best`.
    fn bound(&self, centre: Vec<f64>, half: Vec<f64>, best: &mut (f64, Vec<f64>)) -> Branch {
        let m = self.n11.nrows();
        let (n11, n12, n21, n22) = self.recentred(&centre);
        let mut raise = |value: f64, at: &[f64]| {
            if value > best.0 {
                *best = (value, at.to_vec());
            }
        };
        raise(n22.norm(), &centre);
        let a = Mat::from_fn(m, m, |i, j| n11[(i, j)].norm() * half[j / 2]);
        let b = Mat::from_fn(m, 1, |i, _| n12[(i, 0)].norm());
        let c: Vec<f64> = (0..m).map(|j| n21[j].norm() * half[j / 2]).collect();
        // First order: convex in δ, largest at a corner.
        let slope: Vec<c64> = (0..centre.len())
            .map(|k| {
                (n21[2 * k] * n12[(2 * k, 0)] + n21[2 * k + 1] * n12[(2 * k + 1, 0)]) * half[k]
            })
            .collect();
        let free: Vec<usize> = (0..half.len()).filter(|k| half[*k] > 0.0).collect();
        let (mut first, mut corner) = (n22.norm(), centre.clone());
        for signs in 0..1usize << free.len() {
            let sign = |bit: usize| if (signs >> bit) & 1 == 0 { -1.0 } else { 1.0 };
            let value = free
                .iter()
                .enumerate()
                .fold(n22, |sum, (bit, k)| sum + slope[*k] * sign(bit))
                .norm();
            if value > first {
                first = value;
                for (bit, k) in free.iter().enumerate() {
                    corner[*k] = centre[*k] + sign(bit) * half[*k];
                }
            }
        }
        if first > n22.norm() {
            raise(self.recentred(&corner).3.norm(), &corner);
        }
        let rest = remainder(&a, &b, &c);
        // The parameter that feeds most of the remainder, or of A when its series does not converge, is halved.
        let weight = |k: usize| -> f64 {
            [2 * k, 2 * k + 1]
                .map(|j| match &rest {
                    Some((x, _)) => {
                        (0..m).map(|i| c[i] * a[(i, j)]).sum::<f64>() * x[(j, 0)]
                            + c[j] * x[(j, 0)] * 1e-3
                    }
                    None => (0..m).map(|i| a[(i, j)]).sum::<f64>(),
                })
                .iter()
                .sum()
        };
        let split = free
            .iter()
            .copied()
            .reduce(|p, q| if weight(q) > weight(p) { q } else { p })
            .unwrap_or(0);
        Branch {
            upper: rest.map_or(f64::INFINITY, |(_, r)| first + r),
            centre,
            half,
            split,
        }
    }
}

/// x = (I − A)⁻¹b for nonnegative A with spectral radius below one, and c A x; `None` when the radius is not seen to
/// be.
fn remainder(a: &Mat<f64>, b: &Mat<f64>, c: &[f64]) -> Option<(Mat<f64>, f64)> {
    let m = a.nrows();
    // A positive right-hand side makes x > A x a proof of the radius (Collatz and Wielandt); its size is below
    // rounding.
    let floor = 1e-14 * b.norm_max() + f64::MIN_POSITIVE;
    let unit = Mat::from_fn(m, m, |i, j| f64::from(u8::from(i == j)) - a[(i, j)]);
    let right = Mat::from_fn(m, 1, |i, _| b[(i, 0)] + floor);
    let x = solve(&unit, &right).ok()?;
    let ax = a * &x;
    let proved = (0..m).all(|i| x[(i, 0)] > 0.0 && ax[(i, 0)] < x[(i, 0)]);
    if !proved {
        return None;
    }
    let value = (0..m).map(|i| c[i] * ax[(i, 0)]).sum();
    Some((x, value))
}

fn extreme(nominal: f64, upper: f64, (lower, at): (f64, Vec<f64>)) -> Extreme {
    Extreme {
        nominal,
        lower,
        upper,
        factors: at.iter().map(|k| (1.0 + k).max(0.0).sqrt()).collect(),
    }
}
