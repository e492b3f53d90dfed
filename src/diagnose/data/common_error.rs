//! Residuals with errors in common, multiplied by the inverse root of their covariance.
//!
//! Whitened residuals have the covariance I + a² B Bᵀ, B = U S Vᵀ given in groups of rows, a the amplitude of the
//! errors. The inverse root is I − U (I − (I + a²S²)^(−1/2)) Uᵀ; the determinant belongs to χ², and the amplitude is
//! the most probable one, its logarithm normal about that of 0.2 %.

use crate::linalg::Mat;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// Median amplitude of the prior, and the one that a fit starts from.
pub(crate) const USUAL: f64 = 2e-3;
/// Standard deviation of the logarithm of the amplitude: a rig of one half or of twice the usual is nothing special.
const SPREAD: f64 = 0.7;
/// Largest amplitude: beyond the floor of the gap an error is a finding.
pub(crate) const LARGEST: f64 = 6e-3;
const SMALLEST: f64 = 2e-4;
/// Amplitudes that are compared, evenly spaced in the logarithm: a twentieth of a standard deviation in χ² apart.
const AMPLITUDES: usize = 24;
/// A group of residuals with errors in common: a row of a sweep, or a hammer test.
#[derive(Debug)]
pub struct Group {
    /// Rows of the residuals, increasing.
    pub rows: Vec<usize>,
    /// Orthonormal directions.
    pub u: Mat<f64>,
    /// S².
    pub s2: Vec<f64>,
}

/// The smooth errors of all records that a fit sees, at a model error.
#[derive(Debug)]
pub struct Smooth {
    pub groups: Vec<Group>,
}

/// Smooth errors by what they depend on: stride, hammer tests, channels between the bearings, model error.
pub(crate) type Known = Arc<Mutex<BTreeMap<(usize, bool, bool, u64), Arc<Smooth>>>>;

impl Smooth {
    /// −2 ln of what the amplitude costs: the determinant, and its prior.
    pub fn cost(&self, amplitude: f64) -> f64 {
        let own = |g: &Group| -> f64 {
            let terms = g.s2.iter().map(|s2| (amplitude * amplitude * s2).ln_1p());
            terms.sum()
        };
        let z = (amplitude / USUAL).ln() / SPREAD;
        self.groups.iter().map(own).sum::<f64>() + z * z
    }

    /// The most probable amplitude for residuals that hold the root for `amplitude`.
    pub fn amplitude(&self, residual: &[f64], amplitude: f64) -> f64 {
        let each = |g: &Group| -> Vec<(f64, f64)> {
            let c = g.u.transpose() * g.pick(residual);
            // Before the root was applied.
            let raw = |k: usize| c[(k, 0)].powi(2) * (1.0 + amplitude * amplitude * g.s2[k]);
            (0..g.s2.len()).map(|k| (raw(k), g.s2[k])).collect()
        };
        let all: Vec<(f64, f64)> = self.groups.par_iter().flat_map_iter(each).collect();
        let value = |a: f64| -> f64 {
            let data: f64 = all.iter().map(|(c2, s2)| c2 / (1.0 + a * a * s2)).sum();
            data + self.cost(a)
        };
        let grid = (0..AMPLITUDES).map(|k| {
            let share = k as f64 / (AMPLITUDES - 1) as f64;
            SMALLEST * (LARGEST / SMALLEST).powf(share)
        });
        let mut best = (value(amplitude), amplitude);
        for a in grid {
            let here = value(a);
            // What is next to nothing is not worth another evaluation.
            if here < best.0 - 0.05 {
                best = (here, a);
            }
        }
        best.1
    }

    /// Multiplies residuals by the root for amplitude `to`; they hold that for `from`, none where that is zero.
    pub fn apply(&self, residual: &mut [f64], from: f64, to: f64) {
        let residuals = &*residual;
        let change = |group: &Group| {
            let mut w = group.u.transpose() * group.pick(residuals);
            for (k, s2) in group.s2.iter().enumerate() {
                let root = |a: f64| (1.0 + a * a * s2).sqrt();
                w[(k, 0)] *= root(from) / root(to) - 1.0;
            }
            &group.u * w
        };
        let changes: Vec<Mat<f64>> = self.groups.par_iter().map(change).collect();
        for (group, change) in self.groups.iter().zip(&changes) {
            for (row, change) in group.rows.iter().zip(change.col_as_slice(0)) {
                residual[*row] += change;
            }
        }
    }

    /// UᵀJ of every group, J in blocks of rows one below the other, all of them `width` columns wide.
    pub(crate) fn shares(&self, blocks: &[Mat<f64>], width: usize) -> Vec<Mat<f64>> {
        self.groups.par_iter().map(|group| group.share(blocks, width)).collect()
    }
}

impl Group {
    /// Part of the square of each direction that the root for an amplitude takes away.
    pub(crate) fn take_amplitude(&self, amplitude: f64) -> impl Iterator<Item = f64> {
        let own = self.s2.iter().map(move |s2| amplitude * amplitude * s2);
        own.map(|more| more / (1.0 + more))
    }

    /// The residuals of its rows, rows × 1.
    fn pick(&self, residual: &[f64]) -> Mat<f64> {
        Mat::from_fn(self.rows.len(), 1, |k, _| residual[self.rows[k]])
    }

    /// UᵀJ, block by block.
    fn share(&self, blocks: &[Mat<f64>], width: usize) -> Mat<f64> {
        let mut all = Mat::zeros(self.u.ncols(), width);
        let (mut first, mut done) = (0, 0);
        for block in blocks {
            let until = first + block.nrows();
            let count = self.rows[done..].partition_point(|row| *row < until);
            let rows = &self.rows[done..done + count];
            let mut own = Mat::zeros(count, width);
            for c in 0..width {
                let from = &block.col_as_slice(c);
                for (own, row) in own.col_as_slice_mut(c).iter_mut().zip(rows) {
                    *own = from[row - first];
                }
            }
            all += self.u.subrows(done, count).transpose() * own;
            (first, done) = (until, done + count);
        }
        all
    }
}
