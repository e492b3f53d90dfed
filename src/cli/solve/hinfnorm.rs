//! `muspin solve hinfnorm`: A, B, C, D (and Ts) → norm, peak frequency, certified upper bound.

use super::{Answer, Failure, ProblemFields};
use crate::lti::norm::{NormError, hinf_norm, hinf_norm_discrete};
use crate::lti::{Discrete, StateSpace};

/// Relative distance of the two bounds.
const REL_TOL: f64 = 1e-10;

/// Solves the problem of the file.
pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let s = problem.system()?;
    let found = match sample_time(problem)? {
        Some(period_s) => {
            let time = Discrete { period_s };
            hinf_norm_discrete(&StateSpace { a: s.a, b: s.b, c: s.c, d: s.d, time }, REL_TOL)?
        }
        None => hinf_norm(&s, REL_TOL)?,
    };
    Ok(Answer::new()
        .with_number("norm", found.norm)
        .with_number("peak_freq_rad_s", found.peak_omega_rad_s)
        .with_number("upper", found.upper))
}

/// The sample time in s; none in continuous time.
fn sample_time(problem: &ProblemFields) -> Result<Option<f64>, Failure> {
    let mut found: Option<(&str, f64)> = None;
    for field in ["Ts", "sample_time_s"] {
        if !problem.has(field) {
            continue;
        }
        let period = problem.number(field)?;
        if period < 0.0 {
            let failure = problem.failure(field, format!("must be positive, or 0 for continuous time, found {period}"));
            return Err(failure
                .with_hint("a sample time that is not said (-1) gives no frequency; say it in s")
                .into());
        }
        match found {
            Some((other, same)) if same != period => {
                return Err(problem.failure(field, format!("is {period}, but {other} is {same}: give one")).into());
            }
            _ => found = Some((field, period)),
        }
    }
    Ok(found.map(|(_, period)| period).filter(|period| *period > 0.0))
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
