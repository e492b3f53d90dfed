//! Why A'X + XA − XGX + Q = 0 has no stabilising solution, in the terms of its data.

use super::hinf::assumptions::unreachable_modes;
use crate::linalg::{Mat, NumericError, c64};

/// An eigenvalue this close to the imaginary axis, relative to the size of A, may lie on it: a double one (a rigid
/// body) comes out of an eigenvalue iteration with the root of the rounding error.
const ON_AXIS: f64 = 1e-7;

/// The conditions on (A, G, Q) that fail, each with a mode, and what to do; none when both hold.
///
/// # Errors
/// [`NumericError`] when eigenvalues fail.
pub fn find_cause(a: &Mat<f64>, g: &Mat<f64>, q: &Mat<f64>) -> Result<Option<String>, NumericError> {
    let size = a.norm_l2();
    let transposed = a.transpose().to_owned();
    let unreached = unreachable_modes(a, g)?.into_iter().next();
    // A mode off the axis may stay unobserved: X does not see it, and the closed loop mirrors it.
    let unseen = unreachable_modes(&transposed, q)?.into_iter().find(|mode| mode.re.abs() <= ON_AXIS * size);
    let mut causes = vec![];
    if let Some(mode) = unreached {
        causes.push(format!("(A, G) is not stabilisable: G does not reach the mode at {}", place(mode)));
    }
    if let Some(mode) = unseen {
        causes.push(format!(
            "(Q, A) is not detectable: Q does not observe the undamped mode at {}, give it a weight in Q",
            place(mode)
        ));
    }
    Ok((!causes.is_empty()).then(|| causes.join("; ")))
}

fn place(mode: c64) -> String {
    format!("{:.6e} {:+.6e}j rad/s", mode.re, mode.im)
}
