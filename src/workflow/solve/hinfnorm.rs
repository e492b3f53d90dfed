//! `muspin solve hinfnorm`: A, B, C, D (and Ts) → norm, peak frequency, certified upper bound.

use super::{Answer, Failure, ProblemFields};
use crate::lti::norm::{NormError, hinf_norm, hinf_norm_discrete};

/// Relative distance of the two bounds.
const REL_TOL: f64 = 1e-10;

pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let s = problem.system()?;
    let found = match problem.sample_time()? {
        Some(time) => hinf_norm_discrete(&s.with_time(time), REL_TOL)?,
        None => hinf_norm(&s, REL_TOL)?,
    };
    Ok(Answer::new()
        .with_number("norm", found.norm)
        .with_number("peak_freq_rad_s", found.peak_omega_rad_s)
        .with_number("upper", found.upper))
}

impl From<NormError> for Failure {
    fn from(error: NormError) -> Self {
        let text = error.to_string();
        match error {
            NormError::Unstable { .. } => Self::new(format!("norm: {text}"))
                .with_hint("only a stable system has a norm: check the sign of A, or close the loop first"),
            NormError::Numeric(_) => Self::new(format!("norm: {text}")),
        }
    }
}
