//! Small complex matrices whose largest order the compiler knows, and what they share with [`Planar`] ones.
//!
//! A loop over a column of four or eight numbers is a few vector instructions; where the compiler does not know the
//! length, what surrounds the loop takes several times as long.

use super::planar::{Planar, add_scaled_conj};
use std::ops::Range;

/// A complex matrix that is changed column by column.
pub(crate) trait Columns {
    /// Zero, rows×cols.
    fn zeros(rows: usize, cols: usize) -> Self;
    /// Entry (re, im).
    fn at(&self, i: usize, j: usize) -> (f64, f64);
    /// Sets an entry (re, im).
    fn set(&mut self, i: usize, j: usize, value: (f64, f64));
    /// Adds a real number to an entry.
    fn add_real(&mut self, i: usize, j: usize, value: f64);
    /// Sets every entry to zero.
    fn clear(&mut self);
    /// Column `j` ← column `j` + a · conj(column of another matrix) in some rows; the others may be changed as well.
    fn add_conj(&mut self, rows: Range<usize>, j: usize, a: (f64, f64), x: (&Self, usize));
    /// As [`Planar::cholesky`]; what is above the diagonal may be changed.
    fn cholesky(&mut self) -> bool;
    /// As [`Planar::invert_lower_transposed`].
    fn invert_lower_transposed(&self, into: &mut Self);

    /// |entry|².
    #[inline]
    fn squared(&self, i: usize, j: usize) -> f64 {
        let (re, im) = self.at(i, j);
        re * re + im * im
    }
}

impl Columns for Planar {
    fn zeros(rows: usize, cols: usize) -> Self {
        Planar::zeros(rows, cols)
    }

    fn at(&self, i: usize, j: usize) -> (f64, f64) {
        Planar::at(self, i, j)
    }

    fn set(&mut self, i: usize, j: usize, value: (f64, f64)) {
        let (re, im) = self.part_mut(i, i + 1, j);
        (re[0], im[0]) = value;
    }

    fn add_real(&mut self, i: usize, j: usize, value: f64) {
        Planar::add_real(self, i, j, value);
    }

    fn clear(&mut self) {
        Planar::clear(self);
    }

    #[inline]
    fn add_conj(&mut self, rows: Range<usize>, j: usize, a: (f64, f64), x: (&Self, usize)) {
        let (from, to) = (rows.start, rows.end);
        add_scaled_conj(self.part_mut(from, to, j), a, x.0.part(from, to, x.1));
    }

    fn cholesky(&mut self) -> bool {
        Planar::cholesky(self)
    }

    fn invert_lower_transposed(&self, into: &mut Self) {
        Planar::invert_lower_transposed(self, into);
    }
}

/// A matrix of up to N rows and columns, in columns of N; what it does not have is zero.
#[derive(Clone, Debug)]
pub(crate) struct Fixed<const N: usize> {
    /// Order of a square one.
    order: usize,
    re: [[f64; N]; N],
    im: [[f64; N]; N],
}

impl<const N: usize> Fixed<N> {
    /// Column `j` times a number.
    #[inline]
    fn scale_column(&mut self, j: usize, factor: f64) {
        for i in 0..N {
            self.re[j][i] *= factor;
            self.im[j][i] *= factor;
        }
    }

    /// Column `j` of this matrix and column `k`, which is another one: `j` ← `j` + a · `k`.
    #[inline]
    fn add_own(&mut self, j: usize, a: (f64, f64), k: usize) {
        let (re, im) = (self.re[k], self.im[k]);
        let (own_re, own_im) = (&mut self.re[j], &mut self.im[j]);
        for i in 0..N {
            own_re[i] += a.0 * re[i] - a.1 * im[i];
            own_im[i] += a.0 * im[i] + a.1 * re[i];
        }
    }
}

impl<const N: usize> Columns for Fixed<N> {
    fn zeros(rows: usize, cols: usize) -> Self {
        debug_assert!(rows <= N && cols <= N);
        Self {
            order: cols,
            re: [[0.0; N]; N],
            im: [[0.0; N]; N],
        }
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
    fn add_real(&mut self, i: usize, j: usize, value: f64) {
        self.re[j][i] += value;
    }

    #[inline]
    fn clear(&mut self) {
        (self.re, self.im) = ([[0.0; N]; N], [[0.0; N]; N]);
    }

    #[inline]
    fn add_conj(&mut self, _rows: Range<usize>, j: usize, a: (f64, f64), x: (&Self, usize)) {
        let (re, im) = (&x.0.re[x.1], &x.0.im[x.1]);
        let (own_re, own_im) = (&mut self.re[j], &mut self.im[j]);
        for i in 0..N {
            own_re[i] += a.0 * re[i] + a.1 * im[i];
            own_im[i] += a.1 * re[i] - a.0 * im[i];
        }
    }

    #[inline]
    fn cholesky(&mut self) -> bool {
        for j in 0..self.order {
            for k in 0..j {
                let (re, im) = self.at(j, k);
                self.add_own(j, (-re, im), k);
            }
            let pivot = self.re[j][j];
            // NaN is not definite either.
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            self.im[j][j] = 0.0;
            self.scale_column(j, pivot.sqrt().recip());
        }
        true
    }

    #[inline]
    fn invert_lower_transposed(&self, into: &mut Self) {
        into.clear();
        for r in 0..self.order {
            for j in 0..r {
                let (re, im) = self.at(r, j);
                into.add_own(r, (-re, -im), j);
            }
            into.re[r][r] += 1.0;
            into.scale_column(r, self.re[r][r].recip());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A Hermitian matrix, definite but for `shift`.
    fn filled<M: Columns>(n: usize, shift: f64) -> M {
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
            let (mut one, mut other) = (filled::<Fixed<8>>(n, 0.0), filled::<Planar>(n, 0.0));
            assert!(one.cholesky() && Columns::cholesky(&mut other));
            let (mut inverse, mut expected) = (Fixed::zeros(n, n), Planar::zeros(n, n));
            one.invert_lower_transposed(&mut inverse);
            Columns::invert_lower_transposed(&other, &mut expected);
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
            let mut indefinite = filled::<Fixed<8>>(n, 3.0 * n as f64 + 20.0);
            assert!(!indefinite.cholesky());
        }
    }
}
