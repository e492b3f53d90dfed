//! Small complex matrices as two arrays, real and imaginary parts, column by column.
//!
//! Loops over a column vectorise, and storage is allocated once for many factorisations: what general routines spend on
//! matrices of a few dozen rows is mostly allocation and dispatch.

use super::fused::multiply_add;
use super::{Mat, c64};

/// A complex matrix in two arrays.
#[derive(Clone, Debug)]
pub(crate) struct Planar {
    rows: usize,
    cols: usize,
    re: Vec<f64>,
    im: Vec<f64>,
}

/// Real and imaginary parts of a part of a column.
pub(crate) type Part<'a> = (&'a [f64], &'a [f64]);
/// The same for writing.
pub(crate) type PartMut<'a> = (&'a mut [f64], &'a mut [f64]);

/// y ← y + a·x. Products are rounded before they are added, so that z·z̄ is real to the last bit: the sums of Hermitian
/// matrices stay Hermitian.
#[inline]
pub(crate) fn add_scaled(y: PartMut, a: (f64, f64), x: Part) {
    let own = y.0.iter_mut().zip(y.1.iter_mut());
    for ((yr, yi), (xr, xi)) in own.zip(x.0.iter().zip(x.1)) {
        *yr += a.0 * xr - a.1 * xi;
        *yi += a.0 * xi + a.1 * xr;
    }
}

/// y ← y + a·conj(x), as [`add_scaled`].
#[inline]
pub(crate) fn add_scaled_conj(y: PartMut, a: (f64, f64), x: Part) {
    let own = y.0.iter_mut().zip(y.1.iter_mut());
    for ((yr, yi), (xr, xi)) in own.zip(x.0.iter().zip(x.1)) {
        *yr += a.0 * xr + a.1 * xi;
        *yi += a.1 * xr - a.0 * xi;
    }
}

/// y ← y + a·x with [`multiply_add`] products.
#[inline]
pub(crate) fn add_fused(y: PartMut, a: (f64, f64), x: Part) {
    let own = y.0.iter_mut().zip(y.1.iter_mut());
    for ((yr, yi), (xr, xi)) in own.zip(x.0.iter().zip(x.1)) {
        *yr = multiply_add(a.0, *xr, multiply_add(-a.1, *xi, *yr));
        *yi = multiply_add(a.0, *xi, multiply_add(a.1, *xr, *yi));
    }
}

impl Planar {
    pub(crate) fn zeros(rows: usize, cols: usize) -> Self {
        Self { rows, cols, re: vec![0.0; rows * cols], im: vec![0.0; rows * cols] }
    }

    /// From entries (re, im).
    pub(crate) fn from_fn(rows: usize, cols: usize, mut entry: impl FnMut(usize, usize) -> (f64, f64)) -> Self {
        let mut m = Self::zeros(rows, cols);
        for j in 0..cols {
            for i in 0..rows {
                (m.re[i + j * rows], m.im[i + j * rows]) = entry(i, j);
            }
        }
        m
    }

    /// Copy of a matrix with its rows and columns multiplied.
    pub(crate) fn from_scaled(m: &Mat<c64>, rows: &[f64], cols: &[f64]) -> Self {
        Self::from_fn(m.nrows(), m.ncols(), |i, j| {
            let factor = rows[i] * cols[j];
            (m[(i, j)].re * factor, m[(i, j)].im * factor)
        })
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn cols(&self) -> usize {
        self.cols
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> (f64, f64) {
        let k = i + j * self.rows;
        (self.re[k], self.im[k])
    }

    /// Σ|entry|².
    pub(crate) fn sum_of_squares(&self) -> f64 {
        self.re.iter().chain(&self.im).map(|v| v * v).sum()
    }

    pub(crate) fn part(&self, from: usize, to: usize, j: usize) -> Part<'_> {
        let (a, b) = (from + j * self.rows, to + j * self.rows);
        (&self.re[a..b], &self.im[a..b])
    }

    /// Rows `from`..`to` of a column for writing.
    pub(crate) fn part_mut(&mut self, from: usize, to: usize, j: usize) -> PartMut<'_> {
        let (a, b) = (from + j * self.rows, to + j * self.rows);
        (&mut self.re[a..b], &mut self.im[a..b])
    }

    /// Column `j` for writing, and all columns before it.
    pub(crate) fn split(&mut self, j: usize) -> (PartMut<'_>, Part<'_>) {
        let k = j * self.rows;
        let (before_re, after_re) = self.re.split_at_mut(k);
        let (before_im, after_im) = self.im.split_at_mut(k);
        let own = (&mut after_re[..self.rows], &mut after_im[..self.rows]);
        (own, (before_re, before_im))
    }

    pub(crate) fn clear(&mut self) {
        self.re.fill(0.0);
        self.im.fill(0.0);
    }

    /// Largest absolute value of a real or imaginary part; NaN where one is.
    pub(crate) fn largest_part(&self) -> f64 {
        let entries = self.re.iter().chain(&self.im);
        // max() would drop a NaN.
        let larger = |m: f64, v: &f64| {
            if v.is_nan() || v.abs() > m { v.abs() } else { m }
        };
        entries.fold(0.0, larger)
    }
}
