//! Small complex matrices whose largest order the compiler knows, and what they share with [`Planar`] ones.
//!
//! A loop over a column of four or eight numbers is a few vector instructions; where the compiler does not know the
//! length, what surrounds the loop takes several times as long.

use super::planar::{Planar, add_scaled, add_scaled_conj};
use std::ops::Range;

/// A complex matrix that is changed column by column.
pub(crate) trait Columns {
    /// Zero, rows×cols.
    fn zeros(rows: usize, cols: usize) -> Self;
    /// Entry (re, im).
    fn at(&self, i: usize, j: usize) -> (f64, f64);
    fn set(&mut self, i: usize, j: usize, value: (f64, f64));
    fn clear(&mut self);
    /// Column `j` ← column `j` + a · column of another matrix in some rows; the others may be changed as well.
    fn add(&mut self, rows: Range<usize>, j: usize, a: (f64, f64), x: (&Self, usize));
    /// Column `j` ← column `j` + a · conj(column of another matrix) in some rows; the others may be changed as well.
    fn add_conj(&mut self, rows: Range<usize>, j: usize, a: (f64, f64), x: (&Self, usize));
    /// Column `j` ← column `j` + a · column `k` before it, in some rows; the others may be changed as well.
    fn add_earlier(&mut self, rows: Range<usize>, j: usize, a: (f64, f64), k: usize);
    /// Column `j` times a number, in some rows; the others may be changed as well.
    fn scale(&mut self, rows: Range<usize>, j: usize, factor: f64);

    /// |entry|².
    #[inline]
    fn square_of(&self, i: usize, j: usize) -> f64 {
        let (re, im) = self.at(i, j);
        re * re + im * im
    }

    /// Adds a real number to an entry.
    #[inline]
    fn add_real(&mut self, i: usize, j: usize, value: f64) {
        let (re, im) = self.at(i, j);
        self.set(i, j, (re + value, im));
    }

    /// Replaces the lower triangle of a Hermitian matrix of an order by its Cholesky factor L; false when it is not
    /// positive definite. What is above the diagonal may be changed.
    #[inline]
    fn cholesky(&mut self, order: usize) -> bool {
        for j in 0..order {
            for k in 0..j {
                let (re, im) = self.at(j, k);
                self.add_earlier(j..order, j, (-re, im), k);
            }
            let pivot = self.at(j, j).0;
            // NaN is not definite either.
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            self.set(j, j, (pivot, 0.0));
            self.scale(j..order, j, pivot.sqrt().recip());
        }
        true
    }

    /// Transposed inverse of a lower triangular factor of an order with a real diagonal: column r of `into` is row r of
    /// L⁻¹.
    #[inline]
    fn invert_lower_transposed(&self, order: usize, into: &mut Self) {
        into.clear();
        for r in 0..order {
            for j in 0..r {
                let (re, im) = self.at(r, j);
                into.add_earlier(0..j + 1, r, (-re, -im), j);
            }
            into.add_real(r, r, 1.0);
            into.scale(0..r + 1, r, self.at(r, r).0.recip());
        }
    }
}

impl Columns for Planar {
    fn zeros(rows: usize, cols: usize) -> Self {
        Planar::zeros(rows, cols)
    }

    #[inline]
    fn at(&self, i: usize, j: usize) -> (f64, f64) {
        Planar::at(self, i, j)
    }

    #[inline]
    fn set(&mut self, i: usize, j: usize, value: (f64, f64)) {
        let (re, im) = self.part_mut(i, i + 1, j);
        (re[0], im[0]) = value;
    }

    fn clear(&mut self) {
        Planar::clear(self);
    }

    #[inline]
    fn add(&mut self, rows: Range<usize>, j: usize, a: (f64, f64), x: (&Self, usize)) {
        let (from, to) = (rows.start, rows.end);
        add_scaled(self.part_mut(from, to, j), a, x.0.part(from, to, x.1));
    }

    #[inline]
    fn add_conj(&mut self, rows: Range<usize>, j: usize, a: (f64, f64), x: (&Self, usize)) {
        let (from, to) = (rows.start, rows.end);
        add_scaled_conj(self.part_mut(from, to, j), a, x.0.part(from, to, x.1));
    }

    #[inline]
    fn add_earlier(&mut self, rows: Range<usize>, j: usize, a: (f64, f64), k: usize) {
        let first = k * self.rows();
        let earlier = first + rows.start..first + rows.end;
        let (own, before) = self.split(j);
        let x = (&before.0[earlier.clone()], &before.1[earlier]);
        add_scaled((&mut own.0[rows.clone()], &mut own.1[rows]), a, x);
    }

    #[inline]
    fn scale(&mut self, rows: Range<usize>, j: usize, factor: f64) {
        let (re, im) = self.part_mut(rows.start, rows.end, j);
        re.iter_mut().chain(im).for_each(|v| *v *= factor);
    }
}

/// A matrix of up to N rows and columns, in columns of N.
#[derive(Clone, Debug)]
pub(crate) struct Fixed<const N: usize> {
    re: [[f64; N]; N],
    im: [[f64; N]; N],
}

impl<const N: usize> Columns for Fixed<N> {
    fn zeros(rows: usize, cols: usize) -> Self {
        debug_assert!(rows <= N && cols <= N);
        Self { re: [[0.0; N]; N], im: [[0.0; N]; N] }
    }

    #[inline]
    fn at(&self, i: usize, j: usize) -> (f64, f64) {
        (self.re[j][i], self.im[j][i])
    }

    #[inline]
    fn set(&mut self, i: usize, j: usize, value: (f64, f64)) {
        (self.re[j][i], self.im[j][i]) = value;
    }

    #[inline]
    fn clear(&mut self) {
        (self.re, self.im) = ([[0.0; N]; N], [[0.0; N]; N]);
    }

    #[inline]
    fn add(&mut self, _rows: Range<usize>, j: usize, a: (f64, f64), x: (&Self, usize)) {
        let own = (&mut self.re[j][..], &mut self.im[j][..]);
        add_scaled(own, a, (&x.0.re[x.1], &x.0.im[x.1]));
    }

    #[inline]
    fn add_conj(&mut self, _rows: Range<usize>, j: usize, a: (f64, f64), x: (&Self, usize)) {
        let own = (&mut self.re[j][..], &mut self.im[j][..]);
        add_scaled_conj(own, a, (&x.0.re[x.1], &x.0.im[x.1]));
    }

    #[inline]
    fn add_earlier(&mut self, _rows: Range<usize>, j: usize, a: (f64, f64), k: usize) {
        let (re, im) = (self.re[k], self.im[k]);
        let own = (&mut self.re[j][..], &mut self.im[j][..]);
        add_scaled(own, a, (&re, &im));
    }

    #[inline]
    fn scale(&mut self, _rows: Range<usize>, j: usize, factor: f64) {
        let own = self.re[j].iter_mut().chain(&mut self.im[j]);
        own.for_each(|v| *v *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A Hermitian matrix, definite but for `shift`.
    fn fill_test_matrix<M: Columns>(n: usize, shift: f64) -> M {
        let mut m = M::zeros(n, n);
        for j in 0..n {
            m.set(j, j, (2.0 * n as f64 + j as f64 - shift, 0.0));
            for i in 0..j {
                let (re, im) = ((3 * i + 7 * j) as f64).sin_cos();
                m.set(i, j, (re, im));
                m.set(j, i, (re, -im));
            }
        }
        m
    }

    #[test]
    fn matrices_of_a_known_order_do_what_others_do() {
        for n in 1..=8 {
            let (mut one, mut other) = (fill_test_matrix::<Fixed<8>>(n, 0.0), fill_test_matrix::<Planar>(n, 0.0));
            assert!(one.cholesky(n) && other.cholesky(n));
            let (mut inverse, mut expected) = (Fixed::zeros(n, n), Planar::zeros(n, n));
            one.invert_lower_transposed(n, &mut inverse);
            other.invert_lower_transposed(n, &mut expected);
            inverse.add_conj(0..n, n - 1, (0.3, -0.7), (&one, 0));
            expected.add_conj(0..n, n - 1, (0.3, -0.7), (&other, 0));
            for j in 0..n {
                for i in 0..n {
                    // Above the diagonal of a factor is what was there.
                    let pairs = [(inverse.at(i, j), Columns::at(&expected, i, j))];
                    let factors = [(one.at(i, j), Columns::at(&other, i, j))];
                    let below = if i >= j { 1 } else { 0 };
                    for (found, exact) in pairs.iter().chain(&factors[..below]) {
                        let apart = (found.0 - exact.0).abs().max((found.1 - exact.1).abs());
                        assert!(apart < 1e-14, "{n}: {found:?} and {exact:?}");
                    }
                }
            }
            let mut indefinite = fill_test_matrix::<Fixed<8>>(n, 3.0 * n as f64 + 20.0);
            assert!(!indefinite.cholesky(n));
        }
    }
}
