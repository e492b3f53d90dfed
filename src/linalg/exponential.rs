//! Matrix exponential by scaling and squaring with Padé approximants (nalgebra), on balanced data.

use super::dense::balance;
use super::error::NumericError;
use faer::Mat;

/// e^A of a real square matrix.
///
/// # Errors
/// [`NumericError::NotFinite`] when A holds NaN or infinity, or the exponential overflows.
pub fn exponential(a: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    let n = a.nrows();
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite {
            what: "matrix exponential",
        });
    }
    if n == 0 {
        return Ok(Mat::zeros(0, 0));
    }
    let (balanced, scale) = balance(a);
    let e = nalgebra::DMatrix::from_fn(n, n, |i, j| balanced[(i, j)]).exp();
    let result = Mat::from_fn(n, n, |i, j| e[(i, j)] * scale[i] / scale[j]);
    if !result.is_all_finite() {
        return Err(NumericError::NotFinite {
            what: "matrix exponential",
        });
    }
    Ok(result)
}
