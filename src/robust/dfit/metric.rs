//! The metric of the parameters of D-scales: δxᵀMδx is the mean square change of ln|d(jω)| over some frequencies,
//! summed over the scales. Steps measured by it do not depend on how poles and zeros are written.

use super::factors::Factors;
use crate::linalg::{Mat, symmetric_eigen};

/// Weight of a parameter itself, beside its effect on |d|: a pole on its zero has none.
const OWN: f64 = 0.03;

/// M with its eigenvalues, M = V diag(values) Vᵀ.
pub(crate) struct Metric {
    /// M, parameters × parameters.
    pub matrix: Mat<f64>,
    /// Ascending.
    pub values: Vec<f64>,
    /// V.
    pub vectors: Mat<f64>,
    /// W = V diag(values)^{-1/2}: |p|² = δxᵀMδx with δx = W p.
    pub whitening: Mat<f64>,
}

/// M of the parameters of these scales, one after the other.
pub(crate) fn metric(scales: &[Factors], omega_rad_s: &[f64]) -> Mat<f64> {
    let n = scales.iter().map(|f| f.parameters().len()).sum();
    let mut matrix = Mat::from_fn(n, n, |i, j| if i == j { OWN * OWN } else { 0.0 });
    let count = omega_rad_s.len() as f64;
    let mut first = 0;
    for factors in scales {
        let own = factors.parameters().len();
        for omega in omega_rad_s {
            let (_, g) = factors.ln_magnitude_with_gradient(*omega);
            for i in 0..own {
                for j in 0..own {
                    matrix[(first + i, first + j)] += g[i] * g[j] / count;
                }
            }
        }
        first += own;
    }
    matrix
}

impl Metric {
    /// Of the parameters of a scale; `None` when the eigenvalues fail.
    pub(crate) fn new(factors: &Factors, omega_rad_s: &[f64]) -> Option<Self> {
        let matrix = metric(std::slice::from_ref(factors), omega_rad_s);
        let n = matrix.nrows();
        let (values, vectors) = symmetric_eigen(&matrix).ok()?;
        let whitening = Mat::from_fn(n, n, |i, k| vectors[(i, k)] / values[k].sqrt());
        Some(Self { matrix, values, vectors, whitening })
    }
}
