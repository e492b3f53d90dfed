//! Covariances of the four entries of a row: their factors, and residuals in units of them.

use crate::linalg::c64;

/// Lower Cholesky factor of a Hermitian 4×4 in place; a vanishing pivot is lifted to the rounding level.
pub(super) fn cholesky(c: &mut [c64; 16]) {
    for j in 0..4 {
        let mut pivot = c[5 * j].re;
        let own = pivot;
        for l in 0..j {
            pivot -= c[4 * j + l].norm_sqr();
        }
        let pivot = pivot.max(own * 1e-14).max(f64::MIN_POSITIVE).sqrt();
        c[5 * j] = c64::new(pivot, 0.0);
        for i in j + 1..4 {
            let mut sum = c[4 * i + j];
            for l in 0..j {
                sum -= c[4 * i + l] * c[4 * j + l].conj();
            }
            c[4 * i + j] = sum / pivot;
        }
    }
}

/// Solves L w = d for a lower factor.
pub(crate) fn whiten_vector(l: &[c64; 16], d: &mut [c64; 4]) {
    whiten_with(l, &reciprocals(l), d);
}

/// Reciprocal pivots of a lower factor.
pub(crate) fn reciprocals(l: &[c64; 16]) -> [f64; 4] {
    std::array::from_fn(|i| l[5 * i].re.recip())
}

/// As [`whiten_vector`], the reciprocal pivots known.
pub(crate) fn whiten_with(l: &[c64; 16], pivots: &[f64; 4], d: &mut [c64; 4]) {
    for i in 0..4 {
        let mut sum = d[i];
        for j in 0..i {
            sum -= l[4 * i + j] * d[j];
        }
        d[i] = sum * pivots[i];
    }
}
