//! Eigenvalues of a symmetric matrix by halves (Cuppen 1981; Gu and Eisenstat 1995), for matrices of some ten rows and
//! more of which many are wanted.

use super::{Mat, NumericError};
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::{Auto, Par, Spec};

/// Rows of a part that is not halved again: there the QR iteration is as fast.
const UNDIVIDED: usize = 24;

/// As [`super::symmetric_eigen`].
///
/// # Errors
/// As [`super::symmetric_eigen`].
pub(crate) fn symmetric_eigen_by_halves(
    a: &Mat<f64>,
) -> Result<(Vec<f64>, Mat<f64>), NumericError> {
    let n = a.nrows();
    let norm = a.norm_max();
    if !norm.is_finite() {
        return Err(NumericError::NotFinite {
            what: "symmetric eigenvalues",
        });
    }
    // Halving loses accuracy on matrices of a large norm: it is given one of norm about 1.
    let scale = match norm > 0.0 {
        true => norm.log2().round().exp2(),
        false => 1.0,
    };
    let unit = Mat::from_fn(n, n, |i, j| a[(i, j)] / scale);
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
    .map_err(|_| NumericError::NoConvergence {
        what: "eigenvalue iteration",
        iterations: n,
        residual: f64::NAN,
    })?;
    Ok(((0..n).map(|k| values[k] * scale).collect(), vectors))
}
