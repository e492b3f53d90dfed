//! `muspin solve h2norm`: the H2 norm of a stable system, by both gramians.

use super::{Answer, Failure, ProblemFields};
use crate::lti::energy_norm::{h2_norm, h2_norm_discrete};

pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let s = problem.system()?;
    let found = match problem.sample_time()? {
        Some(time) => h2_norm_discrete(&s.with_time(time))?,
        None => h2_norm(&s)?,
    };
    Ok(Answer::new().with_number("norm", found.norm).with_number("residual", found.difference))
}
