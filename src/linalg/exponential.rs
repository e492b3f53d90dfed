//! Matrix exponential: Padé approximation with scaling and squaring (Higham 2005), on balanced data.

use super::dense::balance;
use super::error::NumericError;
use faer::Mat;

/// exp(A) of a square matrix.
///
/// # Errors
/// [`NumericError::NotFinite`] for bad data or a result that overflows.
pub fn exponential(a: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    let what = "matrix exponential";
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite { what });
    }
    let n = a.nrows();
    if n == 0 {
        return Ok(Mat::zeros(0, 0));
    }
    let (balanced, scale) = balance(a);
    let e = nalgebra::DMatrix::from_fn(n, n, |i, j| balanced[(i, j)]).exp();
    let result = Mat::from_fn(n, n, |i, j| e[(i, j)] * scale[i] / scale[j]);
    if !result.is_all_finite() {
        return Err(NumericError::NotFinite { what });
    }
    Ok(result)
}
