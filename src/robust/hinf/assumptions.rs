//! Standing assumptions of H∞ synthesis, checked by name: (A, B2) stabilisable, (C2, A) detectable, no zero of P12 and
//! P21 on the imaginary axis. The rank conditions on D12 and D21 are part of the normal form.
//! Test: an eigenvalue λ of A with Re λ ≥ 0 is out of reach when [A − λI, B2] loses row rank (Hautus).

use super::side::RiccatiSide;
use crate::linalg::{Mat, NumericError, c64, eigenvalues};
use crate::robust::error::SynthesisError;

/// Smallest singular value of a scaled pencil that counts as rank deficient: rounding of data and eigenvalues.
const RANK: f64 = 1e-12;

/// An eigenvalue in the closed right half plane that the inputs b do not reach.
pub(crate) fn unreachable_mode(a: &Mat<f64>, b: &Mat<f64>) -> Result<Option<c64>, NumericError> {
    // Modes on the axis come out of the QR iteration at rounding level on either side.
    let least = -1e-13 * a.norm_l2();
    Ok(unreachable_modes(a, b, |value| value.re >= least)?.into_iter().next())
}

/// All of the eigenvalues that matter.
pub(crate) fn unreachable_modes(
    a: &Mat<f64>,
    b: &Mat<f64>,
    matters: impl Fn(&c64) -> bool,
) -> Result<Vec<c64>, NumericError> {
    let (n, size) = (a.nrows(), a.norm_l2());
    let modes = eigenvalues(a)?.into_iter().filter(matters);
    let is_unreached = |value: &c64| {
        let value = *value;
        let pencil = Mat::from_fn(n, n + b.ncols(), |i, j| match j.checked_sub(n) {
            None => shift_diagonal(a, value, i, j),
            Some(j) => c64::new(b[(i, j)], 0.0),
        });
        is_deficient(pencil, size)
    };
    Ok(modes.filter(is_unreached).collect())
}

/// Zero of P12 on the imaginary axis: a frequency at which [A − jωI, B2; C1, D12] has no full column rank. Candidates
/// are the zeros of the errors that u reaches directly, eigenvalues of A − B2D12ᵀC1, and the poles.
pub(crate) fn axis_zero(side: &RiccatiSide) -> Result<Option<f64>, NumericError> {
    let (n, m2, p1) = (side.a.nrows(), side.b2.ncols(), side.c1.nrows());
    let free = p1 - m2;
    let inner = &side.a - &side.b2 * side.c1.submatrix(free, 0, m2, n);
    let size = side.a.norm_l2();
    for value in eigenvalues(&inner)?.into_iter().chain(eigenvalues(&side.a)?) {
        // Axis eigenvalues may be double (rigid bodies): the root of the rounding error.
        if value.im < 0.0 || value.re.abs() > 1e-7 * size.max(value.norm()) {
            continue;
        }
        let point = c64::new(0.0, value.im);
        // Transposed: rows of the pencil become columns, as the rank test wants them.
        let pencil = Mat::from_fn(n + m2, n + p1, |i, j| match (i < n, j < n) {
            (true, true) => shift_diagonal(&side.a, point, j, i),
            (true, false) => c64::new(side.c1[(j - n, i)], 0.0),
            (false, true) => c64::new(side.b2[(j, i - n)], 0.0),
            (false, false) => c64::new(f64::from(u8::from(j - n == free + i - n)), 0.0),
        });
        if is_deficient(pencil, size) {
            return Ok(Some(value.im));
        }
    }
    Ok(None)
}

fn shift_diagonal(a: &Mat<f64>, value: c64, i: usize, j: usize) -> c64 {
    let x = c64::new(a[(i, j)], 0.0);
    if i == j { x - value } else { x }
}

/// True when a wide pencil has no full row rank. Columns, then rows, are brought to unit size first, so that neither
/// units of channels nor a small direct term look like a defect; columns at rounding level of `size` are left alone.
fn is_deficient(mut pencil: Mat<c64>, size: f64) -> bool {
    let floor = f64::EPSILON * size;
    for j in 0..pencil.ncols() {
        let norm = pencil.col(j).norm_l2();
        if norm > floor {
            for i in 0..pencil.nrows() {
                pencil[(i, j)] /= norm;
            }
        }
    }
    for i in 0..pencil.nrows() {
        let norm = pencil.row(i).norm_l2();
        if norm > 0.0 {
            for j in 0..pencil.ncols() {
                pencil[(i, j)] /= norm;
            }
        }
    }
    pencil.singular_values().is_ok_and(|s| s.last().is_none_or(|least| *least <= RANK))
}

/// Names the assumption that makes a regulator problem unsolvable, if one does.
pub(crate) fn explain(control: &RiccatiSide, filter: &RiccatiSide) -> Result<(), SynthesisError> {
    if let Some(mode) = unreachable_mode(&control.a, &control.b2)? {
        return Err(SynthesisError::NotStabilisable { re: mode.re, im: mode.im });
    }
    if let Some(mode) = unreachable_mode(&filter.a, &filter.b2)? {
        return Err(SynthesisError::NotDetectable { re: mode.re, im: mode.im });
    }
    if let Some(omega_rad_s) = axis_zero(control)? {
        return Err(SynthesisError::AxisZero { which: "P12 (u to z)", omega_rad_s });
    }
    if let Some(omega_rad_s) = axis_zero(filter)? {
        return Err(SynthesisError::AxisZero { which: "P21 (w to y)", omega_rad_s });
    }
    Ok(())
}
