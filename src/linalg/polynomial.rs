//! Roots of a polynomial: eigenvalues of its companion matrix, each improved by Newton's method.
//! Source: Edelman & Murakami, Mathematics of Computation 64 (1995) 763–776, for the backward error of the eigenvalues.

use super::complex_eigenvalues::eigenvalues_complex;
use super::error::NumericError;
use super::real_eigenvalues::eigenvalues;
use faer::{Mat, c64};

/// Roots of Σ cₖ xᵏ in no particular order; none of a constant. Those of a real polynomial are real or exact conjugate
/// pairs. The last coefficient must not be zero.
///
/// # Errors
/// [`NumericError`] when the eigenvalue iteration fails.
pub fn polynomial_roots(coefficients: &[c64]) -> Result<Vec<c64>, NumericError> {
    let n = coefficients.len().saturating_sub(1);
    let Some(lead) = coefficients.last().filter(|_| n > 0) else {
        return Ok(vec![]);
    };
    let monic: Vec<c64> = coefficients.iter().map(|c| c / lead).collect();
    let entry = |i: usize, j: usize| match (i, j) {
        (i, j) if j + 1 == n => -monic[i],
        (i, j) if i == j + 1 => c64::new(1.0, 0.0),
        _ => c64::new(0.0, 0.0),
    };
    let mut roots = if monic.iter().all(|c| c.im == 0.0) {
        eigenvalues(&Mat::from_fn(n, n, |i, j| entry(i, j).re))?
    } else {
        eigenvalues_complex(&Mat::from_fn(n, n, entry))?
    };
    for root in &mut roots {
        // Two steps remove what the scale of the coefficients leaves.
        for _ in 0..2 {
            let (mut value, mut slope) = (c64::new(0.0, 0.0), c64::new(0.0, 0.0));
            for c in coefficients.iter().rev() {
                slope = slope * *root + value;
                value = value * *root + *c;
            }
            let step = value / slope;
            // Neither far from the eigenvalue nor, beside a multiple root, without a direction.
            if step.norm() < 1e-3 * root.norm() {
                *root -= step;
            }
        }
    }
    Ok(roots)
}
