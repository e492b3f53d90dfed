//! Orthonormal bases and condition numbers of real matrices, by Householder QR and singular values of faer.

use super::error::NumericError;
use faer::Mat;

/// Orthonormal basis of the column space of a tall matrix of full column rank, n×k.
pub(crate) fn orthonormal_columns(a: &Mat<f64>) -> Mat<f64> {
    a.qr().compute_thin_Q()
}

/// Ratio of the largest to the smallest singular value; infinite for a singular matrix, 1 for an empty one.
pub(crate) fn condition(a: &Mat<f64>) -> Result<f64, NumericError> {
    if a.nrows() == 0 || a.ncols() == 0 {
        return Ok(1.0);
    }
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite { what: "condition number" });
    }
    let values = a.singular_values().map_err(|_| NumericError::NoConvergence {
        what: "singular values",
        iterations: a.nrows(),
        residual: f64::NAN,
    })?;
    let (largest, smallest) = values.iter().fold((0.0f64, f64::INFINITY), |(hi, lo), s| (hi.max(*s), lo.min(*s)));
    Ok(if smallest > 0.0 { largest / smallest } else { f64::INFINITY })
}
