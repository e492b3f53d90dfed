//! `muspin solve discretise`: A, B, C, D, Ts (and w_prewarp, input_delay_s) → holds of order zero and one, Tustin,
//! prewarped Tustin, impulse invariance, matched poles and zeros.

use super::answer::system;
use super::{Answer, Failure, ProblemFields};
use crate::linalg::NumericError;
use crate::lti::matched::match_roots;
use crate::lti::sample::{delay_inputs, foh, match_impulse, tustin, tustin_prewarped, zoh, zoh_with_delay};
use crate::lti::{Discrete, StateSpace};

/// A fraction of a sample below this is rounding of decimal inputs.
const WHOLE_SAMPLE: f64 = 1e-9;

/// A rule and what it gives.
type Sampled = (&'static str, Result<StateSpace<Discrete>, NumericError>);

pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let continuous = problem.system()?;
    let period = problem.number("Ts")?;
    if period <= 0.0 {
        return Err(problem.failure("Ts", format!("must be positive, found {period}")).into());
    }
    let delay = if problem.has("input_delay_s") { problem.number("input_delay_s")? } else { 0.0 };
    if delay < 0.0 {
        return Err(problem.failure("input_delay_s", format!("must not be negative, found {delay}")).into());
    }
    let mut found: Vec<Sampled> = vec![("tustin", tustin(&continuous, period)), ("foh", foh(&continuous, period))];
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
    found.push(("impulse", match_impulse(&continuous, period)));
    found.push(("matched", match_roots(&continuous, period)));
    let samples = delay / period;
    let whole = (samples - samples.round()).abs() <= WHOLE_SAMPLE;
    let mut late: Vec<Sampled> =
        vec![("zoh", if delay > 0.0 { zoh_with_delay(&continuous, period, delay) } else { zoh(&continuous, period) })];
    if whole {
        let delayed = |s: StateSpace<Discrete>| delay_inputs(&s, samples.round() as usize);
        late.extend(found.into_iter().map(|(rule, sampled)| (rule, sampled.and_then(delayed))));
        return each_on_its_own(late);
    }
    let answer = each_on_its_own(late)?;
    let note = format!(
        "input_delay_s is {samples} samples: only the zero-order hold is exact between samples; for the other rules \
         give a whole multiple of Ts"
    );
    Ok(answer.with_notes(vec![note]))
}

/// The methods that exist for the system, and a sentence for each that does not; the first failure where none exists.
fn each_on_its_own(found: Vec<Sampled>) -> Result<Answer, Failure> {
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
    Ok(answer.with_notes(notes))
}
