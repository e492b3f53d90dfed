//! Eigenvalues of real matrices: balanced, brought to Hessenberg form, then QR steps on the part that is not yet
//! deflated. Nothing outside that part is kept up to date, as no Schur form is asked.

use super::dense::{balance, sort_eigenvalues, unit_of};
use super::error::NumericError;
use super::francis::Francis;
use faer::{Mat, c64};

/// Eigenvalues of a real square matrix after balancing, sorted by modulus, then real part, then imaginary part.
///
/// # Errors
/// [`NumericError::NotFinite`] for bad data, [`NumericError::NoConvergence`] when the QR iteration fails.
pub fn eigenvalues(a: &Mat<f64>) -> Result<Vec<c64>, NumericError> {
    ensure_finite(a)?;
    eigenvalues_of_balanced(&balance(a).0)
}

fn ensure_finite(a: &Mat<f64>) -> Result<(), NumericError> {
    if a.is_all_finite() { Ok(()) } else { Err(NumericError::NotFinite { what: "eigenvalues" }) }
}

/// [`eigenvalues`] of a balanced matrix.
pub(super) fn eigenvalues_of_balanced(balanced: &Mat<f64>) -> Result<Vec<c64>, NumericError> {
    ensure_finite(balanced)?;
    let n = balanced.nrows();
    let unit = unit_of(balanced.norm_max());
    let scaled = Mat::from_fn(n, n, |i, j| balanced[(i, j)] / unit);
    let found = Francis::of_values(scaled).check_finished()?;
    Ok(sort_eigenvalues(found.values().into_iter().map(|v| v * unit).collect()))
}
