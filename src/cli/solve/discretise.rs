//! `muspin solve discretise`: A, B, C, D, Ts (and w_prewarp) → hold, Tustin, prewarped Tustin.

use super::answer::system;
use super::{Answer, Failure, Problem};
use crate::linalg::NumericError;
use crate::lti::sample::{tustin, tustin_prewarped, zoh};
use crate::lti::{Discrete, StateSpace};

/// Solves the problem of the file.
pub(super) fn solve(problem: &Problem) -> Result<Answer, Failure> {
    let continuous = problem.system()?;
    let period = problem.number("Ts")?;
    if period <= 0.0 {
        return Err(problem.failure("Ts", format!("must be positive, found {period}")).into());
    }
    let mut found = vec![("zoh", zoh(&continuous, period)), ("tustin", tustin(&continuous, period))];
    if problem.has("w_prewarp") {
        let omega = problem.number("w_prewarp")?;
        let limit = std::f64::consts::PI / period;
        if !(omega > 0.0 && omega < limit) {
            return Err(problem
                .failure("w_prewarp", format!("must lie between 0 and pi/Ts = {limit} rad/s, found {omega}"))
                .into());
        }
        found.push(("tustin_prewarp", tustin_prewarped(&continuous, period, omega)));
    }
    each_on_its_own(found)
}

/// The methods that exist for the system, and a sentence for each that does not; the first failure where none exists.
fn each_on_its_own(found: Vec<(&str, Result<StateSpace<Discrete>, NumericError>)>) -> Result<Answer, Failure> {
    let (mut answer, mut notes) = (Answer::new(), Vec::new());
    let mut given = false;
    for (method, sampled) in &found {
        match sampled {
            Ok(sampled) => {
                answer = answer.with(method, system(sampled));
                given = true;
            }
            Err(error) => notes.push(format!("{method}: {error}")),
        }
    }
    if !given && let Some((_, Err(error))) = found.into_iter().next() {
        return Err(error.into());
    }
    for note in &notes {
        eprintln!("note: {note}");
    }
    Ok(if notes.is_empty() { answer } else { answer.with("notes", notes) })
}
