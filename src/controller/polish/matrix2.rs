//! Complex 2×2 matrices as arrays: the loop of one plane has two signals and two currents, and is closed 10⁴ times a
//! step.

use crate::linalg::c64;

/// Rows of a 2×2 matrix.
pub(crate) type Matrix2 = [[c64; 2]; 2];

pub(crate) const ZERO: c64 = c64::new(0.0, 0.0);
pub(crate) const ONE: c64 = c64::new(1.0, 0.0);

/// A B.
pub(crate) fn product(a: &Matrix2, b: &Matrix2) -> Matrix2 {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

/// A v.
pub(crate) fn times(a: &Matrix2, v: &[c64; 2]) -> [c64; 2] {
    [
        a[0][0] * v[0] + a[0][1] * v[1],
        a[1][0] * v[0] + a[1][1] * v[1],
    ]
}

/// vᵀ A, without conjugation.
pub(crate) fn row_times(v: &[c64; 2], a: &Matrix2) -> [c64; 2] {
    [
        v[0] * a[0][0] + v[1] * a[1][0],
        v[0] * a[0][1] + v[1] * a[1][1],
    ]
}

/// det(I − A) and (I − A)⁻¹.
pub(crate) fn closed(a: &Matrix2) -> (c64, Matrix2) {
    let determinant = (ONE - a[0][0]) * (ONE - a[1][1]) - a[0][1] * a[1][0];
    let d = determinant.inv();
    let inverse = [
        [(ONE - a[1][1]) * d, a[0][1] * d],
        [a[1][0] * d, (ONE - a[0][0]) * d],
    ];
    (determinant, inverse)
}

/// v wᵀ scaled.
pub(crate) fn outer(v: &[c64; 2], w: &[c64; 2], scale: c64) -> Matrix2 {
    [
        [v[0] * w[0] * scale, v[0] * w[1] * scale],
        [v[1] * w[0] * scale, v[1] * w[1] * scale],
    ]
}
