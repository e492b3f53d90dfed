//! What the repeats of a sweep differ by: the gain of every sensor axis (levitated anew), and noise.
//!
//! The gains are estimated repeat by repeat, a_pi = argmin Σ|y_p − (1+a_pi)(Ĝu_p)_i|²/S_i, and leave the scatter. S_i
//! is the scatter as the caller smooths it over the lines. What the experiments of a repeat have in common answers to
//! no injection: run-out and unbalance leak into every line of a turning rotor, and with each repeat in another phase.

use super::frf::{AXES, MeasuredFrf, SweepRecord};
use crate::linalg::c64;

/// Probability of noise to count as more than noise, as −ln p: one record in a thousand has one such line among a
/// thousand.
const RARE: f64 = 14.0;
/// Rounds of gains and weights, which depend on each other only weakly.
const ROUNDS: usize = 3;

/// Gains and scatter of a record; zero with a single repeat.
pub(crate) struct RepeatScatter {
    /// Relative gain error of every axis in each repeat, with mean zero.
    pub gains: Vec<[f64; AXES]>,
    /// Mean square of y − (1 + a)Ĝu over repeats and experiments, of every line and axis.
    pub scatter: Vec<[f64; AXES]>,
    /// The same, smoothed over the lines.
    pub smooth: Vec<[f64; AXES]>,
    /// Whether the experiments of a repeat share a disturbance of an axis.
    pub shares: [bool; AXES],
}

impl RepeatScatter {
    /// Of a record with its open-loop response; `smooth` smooths the scatter of one axis over the lines.
    pub(crate) fn of(record: &SweepRecord, frf: &MeasuredFrf, smooth: &dyn Fn(&[f64]) -> Vec<f64>) -> Self {
        let (lines, experiments, repeats, _) = record.current.dim();
        let nothing = vec![[0.0; AXES]; lines];
        let mut found = Self {
            gains: vec![[0.0; AXES]; repeats],
            scatter: nothing.clone(),
            smooth: nothing,
            shares: [false; AXES],
        };
        if repeats < 2 {
            return found;
        }
        // y of a repeat as Ĝ makes it of its u.
        let predicted = |k: usize, e: usize, p: usize, i: usize| {
            (0..AXES).fold(c64::new(0.0, 0.0), |sum, j| sum + frf.response[(k, i, j)] * record.current[(k, e, p, j)])
        };
        let off = |gains: &[[f64; AXES]], (k, e, p, i): (usize, usize, usize, usize)| {
            record.signal[(k, e, p, i)] - predicted(k, e, p, i) * (1.0 + gains[p][i])
        };
        let freedom = (experiments * (repeats - 1)).max(1) as f64;
        for _ in 0..ROUNDS {
            for i in 0..AXES {
                let raw: Vec<f64> = (0..lines)
                    .map(|k| {
                        let mut sum = 0.0;
                        for e in 0..experiments {
                            for p in 0..repeats {
                                sum += off(&found.gains, (k, e, p, i)).norm_sqr();
                            }
                        }
                        sum / freedom
                    })
                    .collect();
                for (k, (own, smoothed)) in raw.iter().zip(smooth(&raw)).enumerate() {
                    (found.scatter[k][i], found.smooth[k][i]) = (*own, smoothed);
                }
                for (p, gain) in found.gains.iter_mut().enumerate() {
                    let (mut top, mut bottom) = (0.0, f64::MIN_POSITIVE);
                    for k in 0..lines {
                        let weight = found.smooth[k][i].max(f64::MIN_POSITIVE).recip();
                        for e in 0..experiments {
                            let y = predicted(k, e, p, i);
                            top += weight * (y.conj() * (record.signal[(k, e, p, i)] - y)).re;
                            bottom += weight * y.norm_sqr();
                        }
                    }
                    gain[i] = top / bottom;
                }
                let mean = found.gains.iter().map(|gain| gain[i]).sum::<f64>() / repeats as f64;
                for gain in &mut found.gains {
                    gain[i] -= mean;
                }
            }
        }
        found.shares = std::array::from_fn(|i| {
            let mut common = 0.0;
            for k in 0..lines {
                let scatter = found.smooth[k][i].max(f64::MIN_POSITIVE) * freedom;
                for p in 0..repeats {
                    let all = (0..experiments).map(|e| off(&found.gains, (k, e, p, i)));
                    common += all.fold(c64::new(0.0, 0.0), |sum, r| sum + r).norm_sqr() / scatter;
                }
            }
            // Of independent experiments the square of the sum is the sum of the squares, on average over the lines
            // and repeats; each is distributed exponentially.
            common / lines as f64 > rare_ratio((lines * (repeats - 1)) as f64)
        });
        found
    }
}

/// The ratio t that a mean of n exponentially distributed squares exceeds with the probability e^(−[`RARE`]) at most:
/// n (t − 1 − ln t) = [`RARE`] (Chernoff's bound).
pub(super) fn rare_ratio(n: f64) -> f64 {
    let mut t = 1.0 + (2.0 * RARE / n).sqrt();
    // Newton's steps on a convex function from its right side.
    for _ in 0..20 {
        t -= (t - 1.0 - t.ln() - RARE / n) / (1.0 - 1.0 / t);
    }
    t
}
