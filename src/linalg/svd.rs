//! Singular value decomposition A = U diag(s) Vᵀ with full orthogonal U and V.

use super::error::NumericError;
use faer::Mat;

/// Factors of A = U diag(s) Vᵀ.
#[derive(Clone, Debug)]
pub struct Svd {
    /// m×m.
    pub u: Mat<f64>,
    /// Singular values, descending, min(m, n) of them.
    pub s: Vec<f64>,
    /// n×n.
    pub v: Mat<f64>,
}

/// Decomposition of an m×n matrix.
///
/// # Errors
/// [`NumericError::NotFinite`] for bad data, [`NumericError::NoConvergence`] when the iteration fails.
pub fn svd(a: &Mat<f64>) -> Result<Svd, NumericError> {
    let what = "singular value decomposition";
    let (m, n) = (a.nrows(), a.ncols());
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite { what });
    }
    if m == 0 || n == 0 {
        return Ok(Svd { u: Mat::identity(m, m), s: vec![], v: Mat::identity(n, n) });
    }
    let f = a.svd().map_err(|_| NumericError::NoConvergence { what, iterations: 30 * m.max(n), residual: f64::NAN })?;
    Ok(Svd { u: f.U().to_owned(), s: (0..m.min(n)).map(|i| f.S().column_vector()[i]).collect(), v: f.V().to_owned() })
}
