//! Complex 2×2 matrices as arrays: the loop of one plane has two signals and two currents, and is closed 10⁴ times a
//! step.

use crate::linalg::c64;
use crate::linalg::fused::{self, fused_complex};
use crate::linalg::lanes::Lanes;

/// Rows of a 2×2 matrix.
pub(crate) type Matrix2 = [[c64; 2]; 2];
/// Four of them.
pub(super) type PackedMatrix = [[Lanes; 2]; 2];

pub(crate) const ZERO: c64 = c64::new(0.0, 0.0);
pub(crate) const ONE: c64 = c64::new(1.0, 0.0);

/// The sum of two products.
#[inline(always)]
fn sum([(a, b), (c, d)]: [(c64, c64); 2]) -> c64 {
    fused_complex(a, b, fused::product(c, d))
}

/// A B.
pub(crate) fn product(a: &Matrix2, b: &Matrix2) -> Matrix2 {
    let entry = |i: usize, j: usize| sum([(a[i][0], b[0][j]), (a[i][1], b[1][j])]);
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

/// A v.
pub(crate) fn times(a: &Matrix2, v: &[c64; 2]) -> [c64; 2] {
    [0, 1].map(|i| sum([(a[i][0], v[0]), (a[i][1], v[1])]))
}

/// vᵀ A, without conjugation.
pub(crate) fn row_times(v: &[c64; 2], a: &Matrix2) -> [c64; 2] {
    [0, 1].map(|j| sum([(v[0], a[0][j]), (v[1], a[1][j])]))
}

/// det(I − A) and (I − A)⁻¹.
pub(crate) fn close_loop(a: &Matrix2) -> (c64, Matrix2) {
    let determinant = sum([(ONE - a[0][0], ONE - a[1][1]), (-a[0][1], a[1][0])]);
    let d = determinant.inv();
    let inverse = [[(ONE - a[1][1]) * d, a[0][1] * d], [a[1][0] * d, (ONE - a[0][0]) * d]];
    (determinant, inverse)
}

/// v wᵀ scaled.
pub(crate) fn outer(v: &[c64; 2], w: &[c64; 2], scale: c64) -> Matrix2 {
    [[v[0] * w[0] * scale, v[0] * w[1] * scale], [v[1] * w[0] * scale, v[1] * w[1] * scale]]
}

/// Aᴴ.
pub(crate) fn adjoint(a: &Matrix2) -> Matrix2 {
    [[a[0][0].conj(), a[1][0].conj()], [a[0][1].conj(), a[1][1].conj()]]
}

/// A Aᴴ.
pub(crate) fn conjugate_square(a: &Matrix2) -> Matrix2 {
    product(a, &adjoint(a))
}

/// Eigenvalues of a positive semidefinite matrix, the larger first, and its eigenvectors of unit length.
pub(crate) fn hermitian_eigen(a: &Matrix2) -> ([f64; 2], [[c64; 2]; 2]) {
    let (mean, half) = (0.5 * (a[0][0].re + a[1][1].re), 0.5 * (a[0][0].re - a[1][1].re));
    let beside = a[0][1];
    let apart = half.hypot(beside.norm());
    // Of the two forms of the vector the one without cancellation.
    let v = if half >= 0.0 { [c64::from(half + apart), beside.conj()] } else { [beside, c64::from(apart - half)] };
    let size = (v[0].norm_sqr() + v[1].norm_sqr()).sqrt();
    let v = if size > 0.0 { v.map(|z| z / size) } else { [ONE, ZERO] };
    let values = [mean + apart, (mean - apart).max(0.0)];
    (values, [v, [-v[1].conj(), v[0].conj()]])
}

#[cfg(test)]
pub(super) fn entry(k: usize, l: usize) -> c64 {
    c64::from_polar(1.0 / (1.0 + l as f64), (3 * k + 7 * l) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_and_vectors_put_a_matrix_together_again() {
        let z = c64::new;
        for a in [
            [[z(2.0, 0.0), z(0.3, -0.7)], [z(0.1, 0.2), z(1.0, 1.0)]],
            [[z(1.0, 0.0), ZERO], [ZERO, z(3.0, 0.0)]],
            [[z(1.0, 1.0), ZERO], [ZERO, z(1.0, -1.0)]],
            [[ZERO, z(1e-9, 0.0)], [z(0.0, 2.0), ZERO]],
            [[ZERO; 2]; 2],
        ] {
            let square = conjugate_square(&a);
            let (values, v) = hermitian_eigen(&square);
            assert!(values[0] >= values[1] && values[1] >= 0.0);
            for i in 0..2 {
                for j in 0..2 {
                    let again = (0..2).map(|k| v[k][i] * v[k][j].conj() * values[k]).sum::<c64>();
                    assert!((again - square[i][j]).norm() <= 1e-14 * values[0]);
                    let inner = v[i][0].conj() * v[j][0] + v[i][1].conj() * v[j][1];
                    let unit = if i == j { 1.0 } else { 0.0 };
                    assert!((inner - unit).norm() < 1e-14);
                }
            }
        }
    }
}
