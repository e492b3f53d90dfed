//! `muspin solve dksyn`: D-K iteration on a generalized plant; the best controller with its certified peak of μ.

use super::answer::{number, system};
use super::clock::{Clock, sampled_system};
use super::hinfsyn::with_regularisation;
use super::{Answer, Failure, ProblemFields};
use crate::lti::TimeBase;
use crate::robust::dk::posed::{iterate_perturbed, iterate_sampled};
use crate::robust::dk::{DkError, DkOutcome, DkSettings};
use crate::robust::hinf::sampled::SampledPlant;
use crate::robust::hinf::singular::Perturbation;
use serde_json::{Value, json};

/// Solves the problem of the file; `omega` gives the range that the D-scales follow, `max_d_order` bounds their order.
pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let (plant, clock) = (problem.generalized_plant()?, Clock::of(problem)?);
    let mut settings = DkSettings::default();
    if problem.has("omega") {
        let omega = problem.numbers("omega")?;
        let nyquist = clock.0.map_or(f64::INFINITY, |time| std::f64::consts::PI / time.period_s);
        let positive = omega.iter().copied().filter(|w| *w > 0.0 && *w < nyquist);
        let (lo, hi) = positive.fold((f64::INFINITY, 0.0f64), |(l, h), w| (l.min(w), h.max(w)));
        if hi > lo {
            settings.fit_range_rad_s = Some((lo, hi));
        }
    }
    if problem.has("max_d_order") {
        settings.max_d_order = problem.count("max_d_order")?;
    }
    match clock.0 {
        None => {
            let (found, perturbation) = iterate_perturbed(&plant, &settings, &mut |_| {})?;
            Ok(certify_answer(&found, system(&found.controller), perturbation))
        }
        Some(time) => {
            let plant = SampledPlant::new(plant, time)?;
            let (found, perturbation) = iterate_sampled(&plant, &settings, &mut |_| {})?;
            Ok(certify_answer(&found, sampled_system(&found.controller), perturbation))
        }
    }
}

/// The best controller with its peak and the steps.
fn certify_answer<T: TimeBase>(found: &DkOutcome<T>, controller: Answer, perturbation: Option<Perturbation>) -> Answer {
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
    let answer = Answer::new()
        .with_number("mu_peak", found.mu_peak)
        .with_number("mu_lower_peak", found.mu_lower_peak)
        .with_number("peak_freq_rad_s", found.peak_omega_rad_s)
        .with_number("gamma", found.gamma)
        .with("controller", controller)
        .with("best_iteration", found.best_iteration)
        .with("iterations", iterations);
    match perturbation {
        None => answer,
        Some(p) => with_regularisation(answer, &p),
    }
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
