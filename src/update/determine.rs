//! What the data can and cannot determine: singular values of the weighted sensitivity, posterior spread of every
//! factor.
//!
//! With ln θ = L u, u ~ N(0, I) before the data, and J the sensitivities over their standard deviations, the singular
//! values s of J L say how much better the data know a combination than the prior: its standard deviation shrinks by
//! 1/√(1 + s²).

use super::UpdateError;
use crate::linalg::{Mat, symmetric_eigen};

/// One combination of regions, from the best determined to the least.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Singular value s: data over prior; above 1 the data know more.
    pub singular_value: f64,
    /// Standard deviation after the data over that before: 1/√(1 + s²).
    pub shrinkage: f64,
    /// Change of ln θ per region along the combination, the largest scaled to 1.
    pub weights: Vec<f64>,
}

/// Determinability of all factors.
#[derive(Clone, Debug, PartialEq)]
pub struct Determined {
    /// Combinations, best determined first, as many as regions.
    pub combinations: Vec<Combination>,
    /// Standard deviation of ln θ per region after the data.
    pub standard_deviation_ln: Vec<f64>,
    /// Standard deviation of ln θ per region before the data.
    pub prior_standard_deviation_ln: Vec<f64>,
}

impl Determined {
    /// Number of combinations that the data know better than the prior.
    pub fn rank(&self) -> usize {
        self.combinations.iter().filter(|c| c.singular_value > 1.0).count()
    }
}

/// Square root L of the prior covariance: sd² exp(−|Δz|/length), L Lᵀ = covariance.
pub(super) fn prior_root(position_m: &[f64], sd: f64, length_m: f64) -> Result<Mat<f64>, UpdateError> {
    let n = position_m.len();
    let covariance = Mat::from_fn(n, n, |i, j| {
        let apart = (position_m[i] - position_m[j]).abs();
        if i == j { sd * sd } else { sd * sd * (-apart / length_m.max(f64::MIN_POSITIVE)).exp() }
    });
    let (values, vectors) = symmetric_eigen(&covariance)?;
    // Two regions at one place have correlation 1: the tiny ridge keeps L invertible.
    let ridge = 1e-9 * sd * sd;
    Ok(Mat::from_fn(n, n, |i, k| vectors[(i, k)] * values[k].max(ridge).sqrt()))
}

/// Determinability from the prior root L and the eigen-decomposition V D Vᵀ of (J L)ᵀ(J L).
pub(super) fn find_determined(root: &Mat<f64>, values: &[f64], vectors: &Mat<f64>) -> Determined {
    let n = values.len();
    let directions = root * vectors;
    let combinations = (0..n)
        .rev()
        .map(|k| {
            let d = values[k].max(0.0);
            let peak =
                (0..n).fold(0.0f64, |p, i| if directions[(i, k)].abs() > f64::abs(p) { directions[(i, k)] } else { p });
            let scale = if peak == 0.0 { 1.0 } else { 1.0 / peak };
            Combination {
                singular_value: d.sqrt(),
                shrinkage: (1.0 + d).sqrt().recip(),
                weights: (0..n).map(|i| directions[(i, k)] * scale).collect(),
            }
        })
        .collect();
    let standard_deviation_ln = (0..n)
        .map(|i| {
            let variance: f64 = (0..n).map(|k| directions[(i, k)].powi(2) / (1.0 + values[k].max(0.0))).sum();
            variance.sqrt()
        })
        .collect();
    let row = |i: usize| (0..n).map(|k| root[(i, k)].powi(2)).sum::<f64>().sqrt();
    Determined { combinations, standard_deviation_ln, prior_standard_deviation_ln: (0..n).map(row).collect() }
}
