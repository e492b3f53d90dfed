//! `muspin solve discretise`: A, B, C, D, Ts (and w_prewarp) → hold, Tustin, prewarped Tustin.

use super::answer::system;
use super::{Answer, Failure, Problem};
use crate::lti::sample::{tustin, tustin_prewarped, zoh};

/// Solves the problem of the file.
pub(super) fn solve(problem: &Problem) -> Result<Answer, Failure> {
    let continuous = problem.system()?;
    let period = problem.number("Ts")?;
    if period <= 0.0 {
        return Err(problem.failure("Ts", format!("must be positive, found {period}")).into());
    }
    let answer = Answer::new()
        .with("zoh", system(&zoh(&continuous, period)?))
        .with("tustin", system(&tustin(&continuous, period)?));
    if !problem.has("w_prewarp") {
        return Ok(answer);
    }
    let omega = problem.number("w_prewarp")?;
    let limit = std::f64::consts::PI / period;
    if !(omega > 0.0 && omega < limit) {
        return Err(problem
            .failure("w_prewarp", format!("must lie between 0 and pi/Ts = {limit} rad/s, found {omega}"))
            .into());
    }
    Ok(answer.with("tustin_prewarp", system(&tustin_prewarped(&continuous, period, omega)?)))
}
