//! Hermitian and complex factorisations as plain functions: Cholesky factor, inverse, eigenvalues, singular vectors.

use super::error::NumericError;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side, c64};

/// Lower triangular L with H = L Lᴴ; `None` when H is not positive definite. Reads the lower triangle.
pub(crate) fn cholesky(h: &Mat<c64>) -> Option<Mat<c64>> {
    Some(h.llt(Side::Lower).ok()?.L().to_owned())
}

/// Eigenvalues (ascending) and orthonormal eigenvectors (columns) of a Hermitian matrix. Reads the lower triangle.
pub(crate) fn hermitian_eigen(h: &Mat<c64>) -> Result<(Vec<f64>, Mat<c64>), NumericError> {
    let what = "Hermitian eigenvalues";
    if !h.is_all_finite() {
        return Err(NumericError::NotFinite { what });
    }
    let n = h.nrows();
    if n == 0 {
        return Ok((vec![], Mat::zeros(0, 0)));
    }
    let evd = h.self_adjoint_eigen(Side::Lower).map_err(|_| no_convergence(what, n))?;
    let values = (0..n).map(|i| evd.S().column_vector()[i].re).collect();
    Ok((values, evd.U().to_owned()))
}

/// Thin singular value decomposition A = U diag(s) Vᴴ, s descending: (U, s, V).
pub(crate) fn singular_vectors(a: &Mat<c64>) -> Result<(Mat<c64>, Vec<f64>, Mat<c64>), NumericError> {
    let what = "singular value decomposition";
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite { what });
    }
    let k = a.nrows().min(a.ncols());
    if k == 0 {
        return Ok((Mat::zeros(a.nrows(), 0), vec![], Mat::zeros(a.ncols(), 0)));
    }
    let svd = a.thin_svd().map_err(|_| no_convergence(what, k))?;
    let values = (0..k).map(|i| svd.S().column_vector()[i].re).collect();
    Ok((svd.U().to_owned(), values, svd.V().to_owned()))
}

/// Smallest singular value of a square complex matrix; NaN when it cannot be computed.
pub fn min_singular_value(a: &Mat<c64>) -> f64 {
    if a.nrows() == 0 || !a.is_all_finite() {
        return f64::NAN;
    }
    a.singular_values().ok().and_then(|s| s.last().copied()).unwrap_or(f64::NAN)
}

/// Inverse of a square complex matrix by LU; entries are not finite when it is singular.
pub(crate) fn inverse_complex(a: &Mat<c64>) -> Mat<c64> {
    a.partial_piv_lu().inverse()
}

fn no_convergence(what: &'static str, n: usize) -> NumericError {
    NumericError::NoConvergence { what, iterations: n, residual: f64::NAN }
}
