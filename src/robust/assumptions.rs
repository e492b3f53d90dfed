//! Standing assumptions of H∞ synthesis, checked by name: (A, B2) stabilisable, (C2, A) detectable, no zero of P12 and
//! P21 on the imaginary axis. The rank conditions on D12 and D21 are part of the normal form.
//! Test: an eigenvalue λ of A with Re λ ≥ 0 is out of reach when [A − λI, B2] loses row rank (Hautus).

use super::error::SynthesisError;
use super::hinf_level::Side;
use crate::linalg::{Mat, NumericError, c64, eigenvalues};

/// Smallest singular value, relative to the matrix, below which [A − λI, B] counts as rank deficient: rounding of data
/// and eigenvalues, with room for repeated ones.
const RANK: f64 = 1e-12;

/// An eigenvalue in the closed right half plane that the inputs b2 do not reach.
///
/// # Errors
/// [`NumericError`] when eigenvalues fail.
pub fn unreachable_mode(a: &Mat<f64>, b: &Mat<f64>) -> Result<Option<c64>, NumericError> {
    let size = a.norm_l2();
    for value in eigenvalues(a)? {
        // Modes on the axis come out of the QR iteration at rounding level on either side.
        if value.re < -1e-13 * size {
            continue;
        }
        if smallest_singular(a, b, value) <= RANK * (size + b.norm_l2()).max(f64::MIN_POSITIVE) {
            return Ok(Some(value));
        }
    }
    Ok(None)
}

/// Smallest singular value of [A − λI, B].
fn smallest_singular(a: &Mat<f64>, b: &Mat<f64>, value: c64) -> f64 {
    let n = a.nrows();
    let pencil = Mat::from_fn(n, n + b.ncols(), |i, j| {
        let x = if j < n { a[(i, j)] } else { b[(i, j - n)] };
        c64::new(x, 0.0) - if i == j { value } else { c64::new(0.0, 0.0) }
    });
    pencil
        .singular_values()
        .map_or(f64::NAN, |s| s.last().copied().unwrap_or(0.0))
}

/// Zero of P12 on the imaginary axis: an eigenvalue jω of A − B2D12ᵀC1 that the free errors do not see.
///
/// # Errors
/// [`NumericError`] when eigenvalues fail.
pub fn axis_zero(side: &Side) -> Result<Option<f64>, NumericError> {
    let (n, m2) = (side.a.nrows(), side.b2.ncols());
    let free = side.c1.nrows() - m2;
    let inner = &side.a - &side.b2 * side.c1.submatrix(free, 0, m2, n);
    let seen = side.c1.submatrix(0, 0, free, n).transpose().to_owned();
    let size = inner.norm_l2();
    for value in eigenvalues(&inner)? {
        // Axis eigenvalues may be double (rigid bodies): the root of the rounding error.
        if value.re.abs() > 1e-7 * size.max(f64::MIN_POSITIVE) {
            continue;
        }
        let on_axis = c64::new(0.0, value.im);
        let gap = smallest_singular(&inner.transpose().to_owned(), &seen, on_axis);
        if gap <= RANK * (size + seen.norm_l2()).max(f64::MIN_POSITIVE) {
            return Ok(Some(value.im.abs()));
        }
    }
    Ok(None)
}

/// Names the assumption that makes a regulator problem unsolvable, if one does.
///
/// # Errors
/// The named assumption, or a numeric failure.
pub fn explain(control: &Side, filter: &Side) -> Result<(), SynthesisError> {
    if let Some(mode) = unreachable_mode(&control.a, &control.b2)? {
        return Err(SynthesisError::NotStabilisable {
            re: mode.re,
            im: mode.im,
        });
    }
    if let Some(mode) = unreachable_mode(&filter.a, &filter.b2)? {
        return Err(SynthesisError::NotDetectable {
            re: mode.re,
            im: mode.im,
        });
    }
    if let Some(omega_rad_s) = axis_zero(control)? {
        return Err(SynthesisError::AxisZero {
            which: "P12 (u to z)",
            omega_rad_s,
        });
    }
    if let Some(omega_rad_s) = axis_zero(filter)? {
        return Err(SynthesisError::AxisZero {
            which: "P21 (w to y)",
            omega_rad_s,
        });
    }
    Ok(())
}
