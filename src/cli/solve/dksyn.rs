//! `muspin solve dksyn`: D-K iteration on a generalized plant; the best controller with its certified peak of μ.

use super::answer::{number, system};
use super::{Answer, Failure, ProblemFields};
use crate::robust::dk::{DkError, DkSettings, iterate};
use serde_json::{Value, json};

/// Solves the problem of the file; `omega` gives the range that the D-scales follow, `max_d_order` bounds their order.
pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let plant = problem.generalized_plant()?;
    let mut settings = DkSettings::default();
    if problem.has("omega") {
        let omega = problem.numbers("omega")?;
        let positive = omega.iter().copied().filter(|w| *w > 0.0);
        let (lo, hi) = positive.fold((f64::INFINITY, 0.0f64), |(l, h), w| (l.min(w), h.max(w)));
        if hi > lo {
            settings.fit_range_rad_s = Some((lo, hi));
        }
    }
    if problem.has("max_d_order") {
        settings.max_d_order = problem.count("max_d_order")?;
    }
    let found = iterate(&plant, &settings, &mut |_| {})?;
    let iterations: Vec<Value> = found
        .steps
        .iter()
        .map(|s| {
            let mut step = json!({
                "gamma": number(s.gamma),
                "mu_peak": number(s.mu_peak),
                "controller_order": s.controller_order,
                "d_order": s.d_orders,
            });
            if let (Some(reason), Some(fields)) = (&s.failure, step.as_object_mut()) {
                fields.insert("failure".to_owned(), json!(reason));
            }
            step
        })
        .collect();
    Ok(Answer::new()
        .with_number("mu_peak", found.mu_peak)
        .with_number("mu_lower_peak", found.mu_lower_peak)
        .with_number("peak_freq_rad_s", found.peak_omega_rad_s)
        .with_number("gamma", found.gamma)
        .with("controller", system(&found.controller))
        .with("best_iteration", found.best_iteration)
        .with("iterations", iterations))
}

impl From<DkError> for Failure {
    fn from(error: DkError) -> Self {
        let message = format!("D-K iteration: {error}");
        match error {
            DkError::Synthesis(cause) => Self::new(message).with_hint(cause.advice()),
            DkError::Blocks { .. } => {
                Self::new(message).with_hint("block rows sum to dim w and cols to dim z, performance block last")
            }
            DkError::Mu(_) | DkError::Numeric(_) => {
                Self::new(message).with_hint("scale states and channels to order one")
            }
        }
    }
}
