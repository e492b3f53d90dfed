//! Thin, checked calls into faer: solves, symmetric eigenvalues, singular values; balancing.
//! faer neither balances nor reports singular solves; both are done here.

use super::balance::evening_factor;
use super::error::NumericError;
use super::largest_singular::largest_singular_value;
use super::planar::Planar;
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{Mat, Side, c64};

/// A square matrix factored for several right-hand sides.
#[derive(Clone, Debug)]
pub(crate) struct Factored {
    /// None for a matrix of no rows.
    lu: Option<PartialPivLu<f64>>,
    /// Smallest pivot per largest.
    rcond: f64,
}

impl Factored {
    /// P A = L U of A, n×n.
    pub(crate) fn new(a: &Mat<f64>) -> Self {
        let n = a.nrows();
        if n == 0 {
            return Self { lu: None, rcond: 1.0 };
        }
        let lu = a.partial_piv_lu();
        let u = lu.U();
        let pivots = (0..n).map(|i| u[(i, i)].abs());
        let (lo, hi) = pivots.fold((f64::INFINITY, 0.0f64), |(lo, hi), p| (lo.min(p), hi.max(p)));
        Self { rcond: if hi > 0.0 { lo / hi } else { 0.0 }, lu: Some(lu) }
    }

    /// X with A X = B.
    pub(crate) fn solve(&self, b: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
        let Some(lu) = &self.lu else {
            return Ok(Mat::zeros(0, b.ncols()));
        };
        let x = lu.solve(b);
        // Pivots span the rounding level: the solution carries no correct digit.
        if self.rcond < f64::EPSILON * 1e-3 || !x.is_all_finite() {
            return Err(NumericError::Singular { what: "linear solve", rcond: self.rcond });
        }
        Ok(x)
    }
}

/// X with A X = B by LU with partial pivoting; A is n×n, B n×k.
///
/// # Errors
/// [`NumericError::Singular`] when a pivot falls below a thousandth of ε of the largest one.
pub fn solve(a: &Mat<f64>, b: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    Factored::new(a).solve(b)
}

/// X with A X = B for the symmetric matrix of normal equations: scaled to a diagonal of ones first, so that the pivots
/// tell its rank and not the units of its unknowns.
pub(crate) fn solve_normal(a: &Mat<f64>, b: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    let unit = |k: usize| if a[(k, k)] > 0.0 { a[(k, k)].sqrt().recip() } else { 1.0 };
    let units: Vec<f64> = (0..a.nrows()).map(unit).collect();
    let scaled = |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| units[i] * m[(i, j)]);
    let even = Mat::from_fn(a.nrows(), a.ncols(), |i, j| units[i] * a[(i, j)] * units[j]);
    Ok(scaled(&solve(&even, &scaled(b))?))
}

/// X with A X = B for complex matrices; entries are infinite or NaN when A is exactly singular (a pole on the axis).
pub fn solve_complex(a: &Mat<c64>, b: &Mat<c64>) -> Mat<c64> {
    a.partial_piv_lu().solve(b)
}

/// Diagonal similarity scaling (powers of two) that evens out row and column norms: A ↦ D⁻¹AD.
/// Returns the scaled matrix and the diagonal of D (Parlett and Reinsch 1969; Osborne 1960).
pub(crate) fn balance(a: &Mat<f64>) -> (Mat<f64>, Vec<f64>) {
    let n = a.nrows();
    let (mut m, mut d) = (a.clone(), vec![1.0; n]);
    // Ten sweeps settle every pattern met; more would only change factors of two.
    for _ in 0..10 {
        let mut changed = false;
        for i in 0..n {
            let off = (0..n).filter(|k| *k != i);
            let (r, c) = off.fold((0.0, 0.0), |(r, c): (f64, f64), k| (r + m[(i, k)].powi(2), c + m[(k, i)].powi(2)));
            let f = evening_factor(r, c);
            if f != 1.0 {
                changed = true;
                d[i] *= f;
                for k in 0..n {
                    m[(k, i)] *= f;
                }
                for k in 0..n {
                    m[(i, k)] /= f;
                }
            }
        }
        if !changed {
            break;
        }
    }
    (m, d)
}

/// By modulus, then real part, then imaginary part.
pub(super) fn sort_eigenvalues(mut values: Vec<c64>) -> Vec<c64> {
    values.sort_by(|x, y| x.norm().total_cmp(&y.norm()).then(x.re.total_cmp(&y.re)).then(x.im.total_cmp(&y.im)));
    values
}

pub(super) fn stuck(n: usize) -> NumericError {
    NumericError::NoConvergence { what: "eigenvalue iteration", iterations: n, residual: f64::NAN }
}

/// Eigenvalues (ascending) and orthonormal eigenvectors (columns) of a real symmetric matrix; reads the lower triangle.
///
/// # Errors
/// [`NumericError::NoConvergence`] when the iteration fails, [`NumericError::NotFinite`] for bad data.
pub fn symmetric_eigen(a: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), NumericError> {
    let n = a.nrows();
    let (unit, scale) = of_unit_norm(a)?;
    let evd = unit.self_adjoint_eigen(Side::Lower).map_err(|_| stuck(n))?;
    let values = (0..n).map(|i| evd.S().column_vector()[i] * scale).collect();
    Ok((values, evd.U().to_owned()))
}

/// A symmetric matrix divided by a power of two to a norm of about 1, and that power: faer's divide and conquer loses
/// all accuracy on matrices of norm 1e14 (n ≥ 200).
pub(super) fn of_unit_norm(a: &Mat<f64>) -> Result<(Mat<f64>, f64), NumericError> {
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite { what: "symmetric eigenvalues" });
    }
    let scale = unit_of(a.norm_max());
    let unit = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / scale);
    Ok((unit, scale))
}

/// Power of two near a norm, by which a matrix is divided so that products of its entries stay in range; one for zero.
pub(super) fn unit_of(norm: f64) -> f64 {
    if norm > 0.0 { norm.log2().round().exp2() } else { 1.0 }
}

/// Entries below this, of a matrix of norm one, are zero: their squares underflow, and iterations make NaN of them.
pub(super) const NEGLIGIBLE: f64 = 1e-138;

/// A real matrix as a complex one.
pub(crate) fn complex(m: &Mat<f64>) -> Mat<c64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| c64::new(m[(i, j)], 0.0))
}

/// aᵀb of two vectors of one length.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Largest singular value of a real matrix; 0 for an empty one, NaN when it cannot be computed.
pub fn max_singular_value(a: &Mat<f64>) -> f64 {
    if a.nrows() == 0 || a.ncols() == 0 {
        return 0.0;
    }
    if !a.is_all_finite() {
        return f64::NAN;
    }
    a.singular_values().map_or(f64::NAN, |s| s[0])
}

/// Up to this smaller dimension an own tridiagonal form is several times faster than a general decomposition.
const SMALL: usize = 24;

/// Largest singular value of a complex matrix; 0 for an empty one, NaN when it cannot be computed.
pub fn max_singular_value_complex(a: &Mat<c64>) -> f64 {
    if a.nrows() == 0 || a.ncols() == 0 {
        return 0.0;
    }
    if !a.is_all_finite() {
        return f64::NAN;
    }
    if a.nrows().min(a.ncols()) <= SMALL {
        let entry = |i: usize, j: usize| (a[(i, j)].re, a[(i, j)].im);
        return largest_singular_value(&Planar::from_fn(a.nrows(), a.ncols(), entry));
    }
    a.singular_values().map_or(f64::NAN, |s| s[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units far apart make the pivots of a well-posed matrix look like rounding.
    #[test]
    fn normal_equations_in_units_far_apart_are_solved() {
        let unit = [1e12, 1.0, 1e-12, 1e-3];
        let close = Mat::from_fn(4, 4, |i, j| 0.5f64.powi((i as i32 - j as i32).abs()));
        let normal = Mat::from_fn(4, 4, |i, j| unit[i] * close[(i, j)] * unit[j]);
        let x = Mat::from_fn(4, 1, |i, _| (1.0 + i as f64) / unit[i]);
        let right = &normal * &x;
        assert!(solve(&normal, &right).is_err());
        let found = solve_normal(&normal, &right).expect("well posed");
        for i in 0..4 {
            assert!((found[(i, 0)] / x[(i, 0)] - 1.0).abs() < 1e-12, "{i}");
        }
        // What no equation sees stays singular.
        let mut blind = normal;
        for k in 0..4 {
            (blind[(1, k)], blind[(k, 1)]) = (0.0, 0.0);
        }
        assert!(solve_normal(&blind, &right).is_err());
    }
}
