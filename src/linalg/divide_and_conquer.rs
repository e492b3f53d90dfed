//! Eigenvalues of a symmetric matrix of some dozens of rows by divide and conquer (Cuppen 1981; Gu and Eisenstat 1995),
//! which the library begins at larger matrices only.

use super::dense::{of_unit_norm, stuck};
use super::{Mat, NumericError};
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::{Auto, Par, Spec};

/// Rows of a part that is not divided again: there the QR iteration is as fast.
const UNDIVIDED: usize = 24;

/// As [`super::symmetric_eigen`].
///
/// # Errors
/// As [`super::symmetric_eigen`].
pub(crate) fn symmetric_eigen_divided(a: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), NumericError> {
    let n = a.nrows();
    let (unit, scale) = of_unit_norm(a)?;
    let mut params = <SelfAdjointEvdParams as Auto<f64>>::auto();
    params.recursion_threshold = UNDIVIDED;
    let params = Spec::new(params);
    let scratch = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, params);
    let (mut values, mut vectors) = (Diag::zeros(n), Mat::zeros(n, n));
    self_adjoint_evd(
        unit.as_ref(),
        values.as_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        params,
    )
    .map_err(|_| stuck(n))?;
    Ok(((0..n).map(|k| values[k] * scale).collect(), vectors))
}

#[cfg(test)]
mod tests {
    use super::super::symmetric_eigen;
    use super::*;

    /// Sizes around one and several divisions, norms as of stiffnesses.
    #[test]
    fn divided_matrices_have_the_eigenvalues_of_the_library_and_small_residuals() {
        for n in [1, UNDIVIDED, UNDIVIDED + 1, 3 * UNDIVIDED] {
            let entry = |i: usize, j: usize| ((3 * i * j + i + j) as f64).sin() * 1e9;
            let a = Mat::from_fn(n, n, entry);
            let (values, vectors) = symmetric_eigen_divided(&a).expect("entries are finite");
            let (library, _) = symmetric_eigen(&a).expect("entries are finite");
            // A few hundred roundings of the norm.
            let tolerance = 1e-13 * n as f64 * a.norm_l2();
            for (k, (value, other)) in values.iter().zip(&library).enumerate() {
                assert!((value - other).abs() <= tolerance, "{value} for {other}");
                let residual = &a * vectors.col(k) - vectors.col(k) * *value;
                assert!(residual.norm_l2() <= tolerance);
            }
            let unit = vectors.transpose() * &vectors - Mat::<f64>::identity(n, n);
            assert!(unit.norm_max() <= 1e-13 * n as f64);
        }
    }

    #[test]
    fn a_number_that_is_none_is_refused() {
        let a = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { f64::NAN });
        assert!(symmetric_eigen_divided(&a).is_err());
    }
}
