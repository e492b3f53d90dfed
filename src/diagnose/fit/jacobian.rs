//! Derivatives of whitened residuals, in blocks of rows that are made, and multiplied, in parallel.

use crate::linalg::Mat;
use rayon::prelude::*;

/// Residuals × parameters.
#[derive(Clone, Debug)]
pub struct Jacobian {
    blocks: Vec<Mat<f64>>,
    columns: usize,
}

impl Jacobian {
    /// Blocks of rows, one below the other, all of them with `columns` columns.
    pub fn new(blocks: Vec<Mat<f64>>, columns: usize) -> Self {
        Self { blocks, columns }
    }

    /// The blocks.
    pub(super) fn blocks_mut(&mut self) -> &mut [Mat<f64>] {
        &mut self.blocks
    }

    /// Number of parameters.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// JᵀJ, columns × columns; summed in the order of the rows.
    pub fn normal(&self) -> Mat<f64> {
        let parts = self.blocks.par_iter().map(|b| b.transpose() * b);
        self.sum(parts.collect(), self.columns)
    }

    /// J times a matrix of as many rows as J has columns.
    pub fn times(&self, right: &Mat<f64>) -> Mat<f64> {
        let parts: Vec<Mat<f64>> = self.blocks.par_iter().map(|b| b * right).collect();
        let values = parts.iter().flat_map(|part| {
            let rows = 0..part.nrows();
            rows.flat_map(move |i| (0..part.ncols()).map(move |j| part[(i, j)]))
        });
        let values: Vec<f64> = values.collect();
        let columns = right.ncols();
        Mat::from_fn(values.len() / columns.max(1), columns, |i, j| {
            values[i * columns + j]
        })
    }

    /// Jᵀ times the derivatives of the same residuals to other parameters.
    pub(crate) fn transpose_times_columns(&self, other: &Self) -> Mat<f64> {
        let both = self.blocks.par_iter().zip(&other.blocks);
        let parts = both.map(|(a, b)| a.transpose() * b);
        self.sum(parts.collect(), other.columns)
    }

    /// Jᵀ times a matrix of as many rows.
    pub(crate) fn transpose_times(&self, right: &Mat<f64>) -> Mat<f64> {
        let mut first = 0;
        let firsts: Vec<usize> = self
            .blocks
            .iter()
            .map(|b| {
                first += b.nrows();
                first - b.nrows()
            })
            .collect();
        let parts = self.blocks.par_iter().zip(firsts).map(|(block, first)| {
            block.transpose() * right.submatrix(first, 0, block.nrows(), right.ncols())
        });
        self.sum(parts.collect(), right.ncols())
    }

    fn sum(&self, parts: Vec<Mat<f64>>, columns: usize) -> Mat<f64> {
        let zero = Mat::zeros(self.columns, columns);
        parts.iter().fold(zero, |sum, part| sum + part)
    }
}
