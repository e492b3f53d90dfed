//! `muspin solve mu`: bounds of the structured singular value of a complex matrix, and the perturbation of the lower
//! one.

use super::answer::complex_matrix;
use super::{Answer, Failure, ProblemFields};
use crate::augment::Block;
use crate::robust::{MuError, mu};

pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let blocks = problem.blocks()?;
    let (rows, cols) = (blocks.iter().map(Block::cols).sum(), blocks.iter().map(Block::rows).sum());
    let m = problem.complex_matrix("M", rows, cols)?;
    let found = mu::bounds(&m, &blocks)?;
    Ok(Answer::new()
        .with_number("upper", found.upper)
        .with_number("lower", found.lower)
        .with("delta", complex_matrix(&found.delta)))
}

impl From<MuError> for Failure {
    fn from(error: MuError) -> Self {
        let hint = match &error {
            MuError::EmptyBlock { .. } => "every block needs at least one row and one column",
            MuError::Shape { .. } => "block i reads its cols outputs of M and feeds its rows inputs, in list order",
            MuError::Unstable { .. } => "close the loop with a stabilising controller first",
            MuError::NotFinite { .. } | MuError::Numeric(_) => {
                "check the scaling of the data and for poles on the imaginary axis"
            }
            MuError::NotCovered { .. } => "the response is flat or badly scaled there; scale the channels to order one",
        };
        Self::new(format!("mu: {error}")).with_hint(hint)
    }
}
