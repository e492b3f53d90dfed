//! `muspin solve hinfnorm`: A, B, C, D → norm, peak frequency, certified upper bound.

use super::{Answer, Failure, Problem};
use crate::lti::norm::{NormError, hinf_norm};

/// Relative distance of the two bounds.
const REL_TOL: f64 = 1e-10;

/// Solves the problem of the file.
pub(super) fn solve(problem: &Problem) -> Result<Answer, Failure> {
    let found = hinf_norm(&problem.system()?, REL_TOL)?;
    Ok(Answer::new()
        .with_number("norm", found.norm)
        .with_number("peak_freq_rad_s", found.peak_omega_rad_s)
        .with_number("upper", found.upper))
}

impl From<NormError> for Failure {
    fn from(error: NormError) -> Self {
        let text = error.to_string();
        match error {
            NormError::Unstable { .. } => Self::new(format!("H-infinity norm: {text}"))
                .with_hint("only a stable system has an H-infinity norm: check the sign of A, or close the loop first"),
            NormError::Numeric(_) => Self::new(format!("H-infinity norm: {text}")),
        }
    }
}
