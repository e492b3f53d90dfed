//! Eigenvalues of real matrices: balanced, brought to Hessenberg form, then QR steps without a basis: three fifths of
//! the time of a general Schur form.

use super::dense::{balance, sorted, unit_of};
use super::error::NumericError;
use super::francis::Francis;
use super::hessenberg::Hessenberg;
use faer::{Mat, c64};

/// Eigenvalues of a real square matrix after balancing, sorted by modulus, then real part, then imaginary part.
///
/// # Errors
/// [`NumericError::NotFinite`] for bad data, [`NumericError::NoConvergence`] when the QR iteration fails.
pub fn eigenvalues(a: &Mat<f64>) -> Result<Vec<c64>, NumericError> {
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite {
            what: "eigenvalues",
        });
    }
    let n = a.nrows();
    let (balanced, _) = balance(a);
    let unit = unit_of(balanced.norm_max());
    let scaled = Mat::from_fn(n, n, |i, j| balanced[(i, j)] / unit);
    let mut steps = Francis {
        form: Hessenberg::of(scaled, |x| *x),
        basis: None,
    };
    steps.run()?;
    let values = steps.eigenvalues();
    Ok(sorted(values.into_iter().map(|v| v * unit).collect()))
}
