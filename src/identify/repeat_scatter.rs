//! What the repeats of a sweep differ by: the gain of every sensor axis (levitated anew), and noise.
//!
//! The gains are estimated repeat by repeat, a_pi = argmin Σ|y_p − (1+a_pi)(Ĝu_p)_i|²/S_i, and leave the scatter. S_i
//! is the scatter as the caller smooths it over the lines.

use super::frf::{AXES, MeasuredFrf, SweepRecord};
use crate::linalg::c64;

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
}

impl RepeatScatter {
    /// Of a record with its open-loop response; `smooth` smooths the scatter of one axis over the lines.
    pub(crate) fn of(record: &SweepRecord, frf: &MeasuredFrf, smooth: &dyn Fn(&[f64]) -> Vec<f64>) -> Self {
        let (lines, experiments, repeats, _) = record.current.dim();
        let nothing = vec![[0.0; AXES]; lines];
        let mut found = Self { gains: vec![[0.0; AXES]; repeats], scatter: nothing.clone(), smooth: nothing };
        if repeats < 2 {
            return found;
        }
        // y of a repeat as Ĝ makes it of its u.
        let predicted = |k: usize, e: usize, p: usize, i: usize| {
            (0..AXES).fold(c64::new(0.0, 0.0), |sum, j| sum + frf.response[(k, i, j)] * record.current[(k, e, p, j)])
        };
        let freedom = (experiments * (repeats - 1)).max(1) as f64;
        for _ in 0..ROUNDS {
            for i in 0..AXES {
                let raw: Vec<f64> = (0..lines)
                    .map(|k| {
                        let mut sum = 0.0;
                        for e in 0..experiments {
                            for (p, gain) in found.gains.iter().enumerate() {
                                let off = record.signal[(k, e, p, i)] - predicted(k, e, p, i) * (1.0 + gain[i]);
                                sum += off.norm_sqr();
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
        found
    }
}
