//! `muspin solve care`: A, G, Q → X, its relative residual and the closed-loop growth rate.

use super::{Answer, Failure, ProblemFields};
use crate::linalg::Mat;
use crate::linalg::riccati::{RiccatiError, care};
use crate::robust::riccati_cause::find_cause;

/// Solves the problem of the file.
pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let a = problem.square("A")?;
    let n = a.nrows();
    problem.agrees("n", n)?;
    let g = problem.matrix_of("G", n, n)?;
    let q = problem.matrix_of("Q", n, n)?;
    let found = care(&a, &g, &q).map_err(|error| explain(error, [&a, &g, &q]))?;
    Ok(Answer::new()
        .with_matrix("X", &found.x)
        .with_number("residual", found.residual)
        .with_number("closed_loop_max_real", found.closed_loop_max_real))
}

/// The failure with the condition on A, G and Q behind it.
fn explain(error: RiccatiError, [a, g, q]: [&Mat<f64>; 3]) -> Failure {
    let is_unsolved = matches!(error, RiccatiError::AxisEigenvalue { .. } | RiccatiError::NoStabilisingSolution { .. });
    match find_cause(a, g, q) {
        Ok(Some(cause)) if is_unsolved => Failure::new(format!("Riccati equation: {error}")).with_hint(cause),
        _ => error.into(),
    }
}

impl From<RiccatiError> for Failure {
    fn from(error: RiccatiError) -> Self {
        let hint = match error {
            RiccatiError::NotSymmetric { .. } => "symmetrise the matrix before writing it",
            RiccatiError::AxisEigenvalue { .. } => {
                "every mode is reached by G and every undamped one observed by Q: with an indefinite G or Q a level \
                 below the optimum of an H-infinity problem has no solution"
            }
            _ => "check that (A, G) is stabilisable, and the scaling of the data",
        };
        Self::new(format!("Riccati equation: {error}")).with_hint(hint)
    }
}
