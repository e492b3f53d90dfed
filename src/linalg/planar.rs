//! Small complex matrices as two arrays, real and imaginary parts, column by column.
//!
//! Loops over a column vectorise, and storage is allocated once for many factorisations: what general routines spend on
//! matrices of a few dozen rows is mostly allocation and dispatch.

use super::fused::fused;
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

/// y ← y + a·x with [`fused`] products.
#[inline]
pub(crate) fn add_fused(y: PartMut, a: (f64, f64), x: Part) {
    let own = y.0.iter_mut().zip(y.1.iter_mut());
    for ((yr, yi), (xr, xi)) in own.zip(x.0.iter().zip(x.1)) {
        *yr = fused(a.0, *xr, fused(-a.1, *xi, *yr));
        *yi = fused(a.0, *xi, fused(a.1, *xr, *yi));
    }
}

impl Planar {
    /// Zero, rows×cols.
    pub(crate) fn zeros(rows: usize, cols: usize) -> Self {
        Self {
            rows,
            cols,
            re: vec![0.0; rows * cols],
            im: vec![0.0; rows * cols],
        }
    }

    /// From entries (re, im).
    pub(crate) fn from_fn(
        rows: usize,
        cols: usize,
        mut entry: impl FnMut(usize, usize) -> (f64, f64),
    ) -> Self {
        let mut m = Self::zeros(rows, cols);
        for j in 0..cols {
            for i in 0..rows {
                (m.re[i + j * rows], m.im[i + j * rows]) = entry(i, j);
            }
        }
        m
    }

    /// Copy of a matrix with its rows and columns multiplied.
    pub(crate) fn scaled(m: &Mat<c64>, rows: &[f64], cols: &[f64]) -> Self {
        Self::from_fn(m.nrows(), m.ncols(), |i, j| {
            let factor = rows[i] * cols[j];
            (m[(i, j)].re * factor, m[(i, j)].im * factor)
        })
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub(crate) fn cols(&self) -> usize {
        self.cols
    }

    /// Entry (re, im).
    pub(crate) fn at(&self, i: usize, j: usize) -> (f64, f64) {
        let k = i + j * self.rows;
        (self.re[k], self.im[k])
    }

    /// Σ|entry|².
    pub(crate) fn sum_of_squares(&self) -> f64 {
        self.re.iter().chain(&self.im).map(|v| v * v).sum()
    }

    /// Rows `from`..`to` of a column.
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

    /// Sets every entry to zero.
    pub(crate) fn clear(&mut self) {
        self.re.fill(0.0);
        self.im.fill(0.0);
    }

    /// Largest singular value, through the smaller Gram matrix: exact to rounding relative to itself. NaN for entries
    /// that are not finite.
    pub(crate) fn largest_singular_value(&self) -> f64 {
        let entries = self.re.iter().chain(&self.im);
        // max() would drop a NaN.
        let size = entries.fold(0.0f64, |m, v| if v.abs() <= m { m } else { v.abs() });
        if size == 0.0 {
            return 0.0;
        }
        // Entries of size one: squares neither overflow nor vanish.
        let scale = size.recip();
        if !scale.is_finite() || scale == 0.0 {
            return if size.is_finite() { size } else { f64::NAN };
        }
        let (n, wide) = (self.rows.min(self.cols), self.rows < self.cols);
        let source = Self::from_fn(n, self.rows.max(self.cols), |i, j| {
            let (re, im) = if wide { self.at(i, j) } else { self.at(j, i) };
            (re * scale, im * scale)
        });
        let mut gram = Self::zeros(n, n);
        for k in 0..source.cols {
            let x = source.part(0, n, k);
            for j in 0..n {
                add_scaled(gram.part_mut(0, n, j), (x.0[j], -x.1[j]), x);
            }
        }
        gram.largest_hermitian_value().max(0.0).sqrt() * size
    }

    /// Largest eigenvalue of a Hermitian matrix (both triangles), which it destroys: Householder's tridiagonal form,
    /// then QL.
    pub(crate) fn largest_hermitian_value(&mut self) -> f64 {
        let n = self.rows;
        let (mut d, mut e) = (vec![0.0; n], vec![0.0; n]);
        let (mut v, mut p) = (Self::zeros(n, 1), Self::zeros(n, 1));
        for k in 0..n {
            d[k] = self.re[k + k * n];
            if k + 1 < n {
                e[k] = self.reflect(k, &mut v, &mut p);
            }
        }
        tridiagonal_values(&mut d, &mut e);
        d.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v))
    }

    /// Annihilates column k below the subdiagonal by a reflection I − τvvᴴ on both sides; returns |subdiagonal entry|.
    fn reflect(&mut self, k: usize, v: &mut Self, p: &mut Self) -> f64 {
        let (n, first) = (self.rows, k + 1);
        let x = self.part(first, n, k);
        let tail: f64 = x.0[1..].iter().chain(&x.1[1..]).map(|v| v * v).sum();
        let (re, im) = (x.0[0], x.1[0]);
        let head = (re * re + im * im).sqrt();
        if tail == 0.0 {
            return head;
        }
        let norm = (head * head + tail).sqrt();
        // v = x + e^{iθ}‖x‖e₁ with the phase of x₁; vᴴv = 2‖x‖(‖x‖ + |x₁|).
        v.re[first..].copy_from_slice(x.0);
        v.im[first..].copy_from_slice(x.1);
        let turn = if head > 0.0 {
            (re / head, im / head)
        } else {
            (1.0, 0.0)
        };
        v.re[first] += turn.0 * norm;
        v.im[first] += turn.1 * norm;
        let tau = (norm * (norm + head)).recip();
        p.re[first..].fill(0.0);
        p.im[first..].fill(0.0);
        for j in first..n {
            let a = (tau * v.re[j], tau * v.im[j]);
            add_scaled(p.part_mut(first, n, 0), a, self.part(first, n, j));
        }
        let product = |i: usize| v.re[i] * p.re[i] + v.im[i] * p.im[i];
        let dot: f64 = (first..n).map(product).sum();
        let half = (-0.5 * tau * dot, 0.0);
        add_scaled(p.part_mut(first, n, 0), half, v.part(first, n, 0));
        for j in first..n {
            let (a, b) = ((-p.re[j], p.im[j]), (-v.re[j], v.im[j]));
            add_scaled(self.part_mut(first, n, j), a, v.part(first, n, 0));
            add_scaled(self.part_mut(first, n, j), b, p.part(first, n, 0));
        }
        norm
    }
}

/// Eigenvalues of the symmetric tridiagonal matrix with diagonal d and subdiagonal e (its last entry unused), into d:
/// implicit QL without vectors (Bowdler, Martin, Reinsch and Wilkinson 1968).
fn tridiagonal_values(d: &mut [f64], e: &mut [f64]) {
    let n = d.len();
    for l in 0..n {
        // Two or three sweeps a value are usual; what is left after 60 is rounding of a matrix that is not finite.
        for _ in 0..60 {
            let small = |m: &usize| e[*m].abs() <= f64::EPSILON * (d[*m].abs() + d[*m + 1].abs());
            let m = (l..n - 1).find(small).unwrap_or(n - 1);
            if m == l {
                break;
            }
            sweep(d, e, l, m);
        }
    }
}

/// One QL sweep on rows l..=m.
fn sweep(d: &mut [f64], e: &mut [f64], l: usize, m: usize) {
    let shift = (d[l + 1] - d[l]) / (2.0 * e[l]);
    let mut g = d[m] - d[l] + e[l] / (shift + (shift * shift + 1.0).sqrt().copysign(shift));
    let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
    for i in (l..m).rev() {
        let (f, b) = (s * e[i], c * e[i]);
        let r = (f * f + g * g).sqrt();
        e[i + 1] = r;
        if r == 0.0 {
            d[i + 1] -= p;
            e[m] = 0.0;
            return;
        }
        (s, c) = (f / r, g / r);
        g = d[i + 1] - p;
        let t = (d[i] - g) * s + 2.0 * c * b;
        p = s * t;
        d[i + 1] = g + p;
        g = c * t - b;
    }
    d[l] -= p;
    e[l] = g;
    e[m] = 0.0;
}
