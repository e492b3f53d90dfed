//! The symmetric-definite eigenproblem  K v = λ M v  and complex eigenvectors, as structural dynamics needs them.
//! Method: symmetric scaling of M to unit diagonal, M = L Lᵀ, eigenvalues of L⁻¹ K L⁻ᵀ, v = L⁻ᵀ w; so VᵀMV = I.

use super::dense::symmetric_eigen;
use super::error::NumericError;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side, c64};

/// L of a symmetric positive definite H = L Lᵀ.
pub(crate) struct DefiniteFactor(Mat<f64>);

impl DefiniteFactor {
    /// The factor of H, n×n, of which the lower triangle is read; `None` when H is not positive definite.
    pub(crate) fn new(h: &Mat<f64>) -> Option<Self> {
        Some(Self(h.llt(Side::Lower).ok()?.L().to_owned()))
    }

    /// L⁻¹B for B of n rows.
    pub(crate) fn solve_lower(&self, mut b: Mat<f64>) -> Mat<f64> {
        solve_lower_triangular_in_place(self.0.as_ref(), b.as_mut(), Par::Seq);
        b
    }

    /// L⁻ᵀB for B of n rows.
    pub(crate) fn solve_upper(&self, mut b: Mat<f64>) -> Mat<f64> {
        solve_upper_triangular_in_place(self.0.transpose(), b.as_mut(), Par::Seq);
        b
    }
}

/// Eigenvalues, ascending, and eigenvectors of a symmetric-definite pencil.
#[derive(Clone, Debug)]
pub struct DefiniteEigen {
    /// λ, ascending.
    pub values: Vec<f64>,
    /// Columns v with VᵀMV = I, n×n.
    pub vectors: Mat<f64>,
}

/// Solves K v = λ M v for symmetric K and symmetric positive definite M, both n×n.
///
/// # Errors
/// [`NumericError::NotFinite`] for bad data, [`NumericError::Singular`] when M is not positive definite,
/// [`NumericError::NoConvergence`] when the eigenvalue iteration fails.
pub fn definite_eigen(k: &Mat<f64>, m: &Mat<f64>) -> Result<DefiniteEigen, NumericError> {
    definite_eigen_lifted(k, m, &Mat::zeros(m.nrows(), 0))
}

/// As [`definite_eigen`], but with the known null vectors R of K (n×r, RᵀMR = I) lifted out of the way: the answer
/// holds the other n − r pairs only, M-orthogonal to R. R need not come from any eigensolver, so it stays exact.
///
/// # Errors
/// As [`definite_eigen`].
pub fn definite_eigen_lifted(k: &Mat<f64>, m: &Mat<f64>, null: &Mat<f64>) -> Result<DefiniteEigen, NumericError> {
    let n = m.nrows();
    if !k.is_all_finite() || !m.is_all_finite() || !null.is_all_finite() {
        return Err(NumericError::NotFinite { what: "symmetric-definite eigenproblem" });
    }
    let singular =
        |rcond| NumericError::Singular { what: "mass matrix of the eigenproblem (not positive definite)", rcond };
    let mut scale = Vec::with_capacity(n);
    for i in 0..n {
        if m[(i, i)] <= 0.0 {
            return Err(singular(0.0));
        }
        scale.push(m[(i, i)].sqrt().recip());
    }
    let scaled = |a: &Mat<f64>| Mat::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]);
    let factor = DefiniteFactor::new(&scaled(m)).ok_or_else(|| singular(0.0))?;
    // S = L⁻¹ K L⁻ᵀ
    let s = factor.solve_lower(scaled(k));
    let s = factor.solve_lower(s.transpose().to_owned());
    let q = factor.0.transpose() * Mat::from_fn(n, null.ncols(), |i, j| null[(i, j)] / scale[i]);
    // Above every eigenvalue, since λ_max ≤ ‖S‖_F: the lifted ones come last.
    let lift = 2.0 * s.norm_l2();
    let s = Mat::from_fn(n, n, |i, j| {
        let mean = 0.5 * (s[(i, j)] + s[(j, i)]);
        (0..q.ncols()).fold(mean, |sum, r| sum + lift * q[(i, r)] * q[(j, r)])
    });
    let (values, w) = symmetric_eigen(&s)?;
    let kept = n - null.ncols();
    let mut v = w.subcols(0, kept).to_owned();
    // Rounding leaves a trace of the null vectors; remove it.
    let overlap = q.transpose() * &v;
    v = &v - &q * &overlap;
    let v = factor.solve_upper(v);
    Ok(DefiniteEigen { values: values[..kept].to_vec(), vectors: Mat::from_fn(n, kept, |i, j| v[(i, j)] * scale[i]) })
}

/// Eigenvalues and right eigenvectors (columns, unit length) of a real square matrix with a simple spectrum.
/// Vectors of repeated eigenvalues cannot be relied on.
///
/// # Errors
/// [`NumericError::NotFinite`] for bad data, [`NumericError::NoConvergence`] when the iteration fails.
pub fn eigen_vectors(a: &Mat<f64>) -> Result<(Vec<c64>, Mat<c64>), NumericError> {
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite { what: "eigenvectors" });
    }
    let n = a.nrows();
    let evd = a.eigen().map_err(|_| NumericError::NoConvergence {
        what: "eigenvalue iteration",
        iterations: n,
        residual: f64::NAN,
    })?;
    let values = (0..n).map(|i| evd.S().column_vector()[i]).collect();
    Ok((values, evd.U().to_owned()))
}

/// Eigenvalues and right eigenvectors (columns) of a complex square matrix, with their largest residual
/// max|A V − V Λ| relative to max|A|: the caller checks it, vectors of repeated eigenvalues may be wrong.
#[derive(Clone, Debug)]
pub struct ComplexEigen {
    /// Eigenvalues.
    pub values: Vec<c64>,
    /// Eigenvectors, n×n.
    pub vectors: Mat<c64>,
    /// Relative residual.
    pub residual: f64,
}

/// Eigenvalues and eigenvectors of a complex matrix.
///
/// # Errors
/// [`NumericError::NotFinite`] for bad data, [`NumericError::NoConvergence`] when the iteration fails.
pub fn eigen_vectors_complex(a: &Mat<c64>) -> Result<ComplexEigen, NumericError> {
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite { what: "complex eigenvectors" });
    }
    let n = a.nrows();
    let evd = a.eigen().map_err(|_| NumericError::NoConvergence {
        what: "complex eigenvalue iteration",
        iterations: n,
        residual: f64::NAN,
    })?;
    let values: Vec<c64> = (0..n).map(|i| evd.S().column_vector()[i]).collect();
    let vectors = evd.U().to_owned();
    let error = a * &vectors - Mat::from_fn(n, n, |i, j| vectors[(i, j)] * values[j]);
    let size = a.norm_max().max(f64::MIN_POSITIVE);
    Ok(ComplexEigen { residual: error.norm_max() / size, values, vectors })
}
