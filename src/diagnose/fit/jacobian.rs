//! Derivatives of whitened residuals, in blocks of rows that are made, and multiplied, in parallel.
//!
//! Where residuals have errors in common, the derivatives J are to be multiplied by the root T = I − U D Uᵀ of their
//! covariance ([`Smooth`]). They are kept as they were made, beside W = UᵀJ: (TJ)ᵀ(TJ) = JᵀJ − Wᵀ(2D − D²)W, and no
//! row is written again.

use super::super::data::common_error::Smooth;
use crate::linalg::Mat;
use crate::linalg::gram::{add_gram, dot_in_lanes, mirror_lower};
use rayon::prelude::*;
use std::sync::Arc;

/// Residuals × parameters.
#[derive(Clone, Debug)]
pub struct Jacobian {
    blocks: Vec<Mat<f64>>,
    columns: usize,
    common: Option<Common>,
}

/// Errors in common, and what the derivatives have of them.
#[derive(Clone, Debug)]
struct Common {
    smooth: Arc<Smooth>,
    amplitude: f64,
    /// W of every group, directions × parameters.
    shares: Vec<Mat<f64>>,
}

impl Jacobian {
    /// Blocks of rows, one below the other, all of them with `columns` columns, of residuals with smooth errors of an
    /// amplitude, if there are any.
    pub fn new(blocks: Vec<Mat<f64>>, columns: usize, smooth: Option<(Arc<Smooth>, f64)>) -> Self {
        let common =
            smooth.map(|(smooth, amplitude)| Common { shares: smooth.shares(&blocks, columns), smooth, amplitude });
        Self { blocks, columns, common }
    }

    /// Another amplitude of the smooth errors.
    pub(super) fn tune(&mut self, amplitude: f64) {
        if let Some(common) = &mut self.common {
            common.amplitude = amplitude;
        }
    }

    pub fn columns(&self) -> usize {
        self.columns
    }

    /// JᵀJ, columns × columns; summed in the order of the rows.
    pub fn normal(&self) -> Mat<f64> {
        let part = |b: &Mat<f64>| {
            let mut own = Mat::zeros(self.columns, self.columns);
            add_gram(&mut own, b.as_ref());
            own
        };
        let parts: Vec<Mat<f64>> = self.blocks.par_iter().map(part).collect();
        let mut all = mirror_lower(self.sum(parts, self.columns));
        for (w, taken) in self.take_blocks() {
            all -= w.transpose() * taken;
        }
        all
    }

    /// JᵀJ of the columns of each of `widths`, one behind the other, by itself.
    pub(crate) fn normal_of_each(&self, widths: &[usize]) -> Vec<Mat<f64>> {
        let firsts = widths.iter().scan(0, |next, width| {
            *next += width;
            Some((*next - width, *width))
        });
        let firsts: Vec<(usize, usize)> = firsts.collect();
        let shares = self.take_blocks();
        let own = |(first, width): &(usize, usize)| {
            let mut all = Mat::zeros(*width, *width);
            for block in &self.blocks {
                add_gram(&mut all, block.subcols(*first, *width));
            }
            let mut all = mirror_lower(all);
            for (w, taken) in &shares {
                all -= w.subcols(*first, *width).transpose() * taken.subcols(*first, *width);
            }
            all
        };
        firsts.par_iter().map(own).collect()
    }

    /// J times a column of as many rows as J has columns.
    pub fn times(&self, right: &Mat<f64>) -> Vec<f64> {
        let parts: Vec<Mat<f64>> = self.blocks.par_iter().map(|b| b * right).collect();
        let values = parts.iter().flat_map(|part| part.col_as_slice(0).iter());
        let mut values: Vec<f64> = values.copied().collect();
        if let Some(common) = &self.common {
            common.smooth.apply(&mut values, 0.0, common.amplitude);
        }
        values
    }

    /// Jᵀ times the derivatives of the same residuals to other parameters.
    pub(crate) fn transpose_times_columns(&self, other: &Self) -> Mat<f64> {
        let both = self.blocks.par_iter().zip(&other.blocks);
        let parts = both.map(|(a, b)| a.transpose() * b);
        let mut all = self.sum(parts.collect(), other.columns);
        if let Some(common) = &other.common {
            for ((_, taken), w) in self.take_blocks().iter().zip(&common.shares) {
                all -= taken.transpose() * w;
            }
        }
        all
    }

    /// Jᵀ times a column of as many rows.
    pub(crate) fn transpose_times(&self, right: &[f64]) -> Mat<f64> {
        let mut first = 0;
        let firsts: Vec<usize> = self
            .blocks
            .iter()
            .map(|b| {
                first += b.nrows();
                first - b.nrows()
            })
            .collect();
        let whole;
        let right = match &self.common {
            Some(common) => {
                let mut values = right.to_vec();
                common.smooth.apply(&mut values, 0.0, common.amplitude);
                whole = values;
                &whole
            }
            None => right,
        };
        let parts = self.blocks.par_iter().zip(firsts).map(|(block, first)| {
            let own = &right[first..first + block.nrows()];
            Mat::from_fn(self.columns, 1, |c, _| dot_in_lanes(block.col_as_slice(c), own))
        });
        self.sum(parts.collect(), 1)
    }

    /// W of every group, and (2D − D²)W.
    fn take_blocks(&self) -> Vec<(&Mat<f64>, Mat<f64>)> {
        let Some(common) = &self.common else {
            return vec![];
        };
        let groups = common.smooth.groups.iter().zip(&common.shares);
        groups
            .map(|(group, w)| {
                let factors: Vec<f64> = group.take_amplitude(common.amplitude).collect();
                let taken = Mat::from_fn(w.nrows(), w.ncols(), |k, c| factors[k] * w[(k, c)]);
                (w, taken)
            })
            .collect()
    }

    fn sum(&self, parts: Vec<Mat<f64>>, columns: usize) -> Mat<f64> {
        let mut all = Mat::zeros(self.columns, columns);
        for part in &parts {
            all += part;
        }
        all
    }
}
