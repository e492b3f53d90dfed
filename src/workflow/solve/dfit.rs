//! `muspin solve dfit`: stable, minimum-phase systems of given orders that follow given magnitudes.
//! The unweighted log error is minimised: it is the figure that the answer states.

use super::clock::Clock;
use super::{Answer, Failure, ProblemFields};
use crate::robust::dfit::{DfitError, Magnitudes, fit_up_to};

/// Highest order that is fitted; D-scales of more states follow noise.
const MAX_ORDER: usize = 20;

pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let orders = problem.counts("orders")?;
    let Some(highest) = orders.iter().copied().max() else {
        return Err(problem.failure("orders", "expected at least one order").into());
    };
    if highest > MAX_ORDER {
        let message = format!("order {highest} is above {MAX_ORDER}");
        return Err(problem.failure("orders", message).into());
    }
    let clock = Clock::of(problem)?;
    let mut omega = problem.numbers("omega")?;
    if let Some(time) = clock.0 {
        let nyquist = std::f64::consts::PI / time.period_s;
        if let Some(k) = omega.iter().position(|w| *w >= nyquist) {
            let rule = format!("{} rad/s is not below the Nyquist frequency pi/Ts = {nyquist} rad/s", omega[k]);
            return Err(problem.failure(&format!("omega[{k}]"), rule).into());
        }
        omega.iter_mut().for_each(|w| *w = time.w_frequency(*w));
    }
    let weight = if problem.has("weight") { problem.numbers("weight")? } else { vec![1.0; omega.len()] };
    // The weights are checked, and reported in the answer.
    let data = Magnitudes::new(omega, problem.numbers("magnitude")?, weight)?;
    let plain = Magnitudes { weight: vec![1.0; data.omega_rad_s.len()], ..data.clone() };
    let fits = fit_up_to(&plain, highest)?;
    let mut answers = Answer::new();
    for order in orders {
        let fit = &fits[order];
        let points = data.omega_rad_s.iter().zip(&data.magnitude).zip(&data.weight);
        let weighted =
            points.map(|((w, m), weight)| weight * (fit.factors.ln_magnitude(*w) - m.ln()).abs()).fold(0.0, f64::max);
        let one = clock
            .answer(&fit.system)?
            .with_number("max_abs_ln_error", fit.max_abs_ln_error)
            .with_number("max_weighted_ln_error", weighted);
        answers = answers.with(&order.to_string(), one);
    }
    Ok(Answer::new().with("orders", answers))
}

impl From<DfitError> for Failure {
    fn from(error: DfitError) -> Self {
        Self::new(format!("D fit: {error}"))
            .with_hint("magnitudes are those of d(jw), not squared; frequencies are in rad/s")
    }
}
