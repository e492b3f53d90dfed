//! `muspin solve care`: A, G, Q → X, its relative residual and the closed-loop growth rate.

use super::{Answer, Failure, Problem};
use crate::linalg::riccati::{RiccatiError, care};

/// Solves the problem of the file.
pub(super) fn solve(problem: &Problem) -> Result<Answer, Failure> {
    let a = problem.square("A")?;
    let n = a.nrows();
    problem.agrees("n", n)?;
    let g = problem.matrix_of("G", n, n)?;
    let q = problem.matrix_of("Q", n, n)?;
    let found = care(&a, &g, &q)?;
    Ok(Answer::new()
        .with_matrix("X", &found.x)
        .with_number("residual", found.residual)
        .with_number("closed_loop_max_real", found.closed_loop_max_real))
}

impl From<RiccatiError> for Failure {
    fn from(error: RiccatiError) -> Self {
        let hint = match error {
            RiccatiError::NotSymmetric { .. } => "symmetrise the matrix before writing it",
            RiccatiError::AxisEigenvalue { .. } => {
                "an unreachable or unobservable mode on the axis, or an H-infinity level below the optimum: \
                 check that (A, G) is stabilisable and (Q, A) detectable"
            }
            _ => "check that (A, G) is stabilisable, and the scaling of the data",
        };
        Self::new(format!("Riccati equation: {error}")).with_hint(hint)
    }
}
