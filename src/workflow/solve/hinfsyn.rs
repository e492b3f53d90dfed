//! `muspin solve hinfsyn`: a generalized plant → γ_opt, a controller slightly above it, and its verified norm. A
//! singular plant is enlarged by small channels, which the answer states.

use super::answer::{number, system};
use super::clock::{Clock, sampled_system};
use super::{Answer, Failure, ProblemFields};
use crate::augment::GeneralizedPlant;
use crate::lti::TimeBase;
use crate::robust::hinf::sampled::{SampledPlant, synthesise_sampled};
use crate::robust::hinf::singular::{Perturbation, synthesise_perturbed};
use crate::robust::{HinfSettings, HinfSolution, Limit, SynthesisError};
use serde_json::Value;

/// Solves the problem of the file; `gamma` in the file asks for the central controller at that level.
pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let level = if problem.has("gamma") { Some(problem.number("gamma")?) } else { None };
    synthesise(problem.generalized_plant()?, Clock::of(problem)?, level)
}

/// Synthesis at a level, or at the optimum, for a plant of either time base.
pub(super) fn synthesise(plant: GeneralizedPlant, clock: Clock, level: Option<f64>) -> Result<Answer, Failure> {
    let settings = HinfSettings { gamma: level, ..HinfSettings::default() };
    match clock.0 {
        None => {
            let (found, perturbation) = synthesise_perturbed(&plant, &settings)?;
            Ok(certify_answer(&found, system(&found.controller), clock, level, perturbation))
        }
        Some(time) => {
            let (found, perturbation) = synthesise_sampled(&SampledPlant::new(plant, time)?, &settings)?;
            Ok(certify_answer(&found, sampled_system(&found.controller), clock, level, perturbation))
        }
    }
}

/// The controller with its levels and its certificate.
fn certify_answer<T: TimeBase>(
    found: &HinfSolution<T>,
    controller: Answer,
    clock: Clock,
    level: Option<f64>,
    perturbation: Option<Perturbation>,
) -> Answer {
    let c = &found.certificate;
    let mut certificate = Answer::new();
    if let Some(limit) = c.limit {
        let (name, frequency) = match limit {
            Limit::Coupling => ("coupling", None),
            Limit::ControlSide { omega_rad_s } => ("control side", Some(omega_rad_s)),
            Limit::FilterSide { omega_rad_s } => ("filter side", Some(omega_rad_s)),
            Limit::ControlIndefinite => ("control solution", None),
            Limit::FilterIndefinite => ("filter solution", None),
            Limit::Rounding => ("rounding", None),
        };
        certificate = certificate.with("limit", name);
        if let Some(omega_rad_s) = frequency {
            certificate = certificate.with_number("limit_omega_rad_s", omega_rad_s);
        }
    }
    let certificate = certificate
        .with_number("x_residual", c.x_residual)
        .with_number("y_residual", c.y_residual)
        .with_number("x_min_relative", c.x_min)
        .with_number("y_min_relative", c.y_min)
        .with_number("coupling", c.coupling);
    let certificate = clock.with_stability(certificate, c.growth_rate).with("riccati_pairs", c.pairs);
    let answer = if level.is_none() { Answer::new().with_number("gamma_opt", found.gamma_opt) } else { Answer::new() };
    let answer = answer
        .with_number("gamma", found.gamma)
        .with_number("closed_loop_norm", found.closed_loop_norm)
        .with("controller", controller)
        .with("certificate", certificate);
    match perturbation {
        None => answer,
        Some(p) => with_regularisation(answer, &p),
    }
}

/// The answer with what was added to a singular plant.
pub(super) fn with_regularisation(answer: Answer, p: &Perturbation) -> Answer {
    answer.with("regularisation", regularisation(p)).with_remark(remark(p))
}

/// What was added to a singular plant, and what it changes.
fn regularisation(p: &Perturbation) -> Answer {
    let list = |sizes: &[f64]| sizes.iter().map(|size| number(*size)).collect::<Vec<Value>>();
    let parts = [
        ("controls", &p.added.d12),
        ("measurements", &p.added.d21),
        ("state_errors", &p.added.c1),
        ("state_disturbances", &p.added.b1),
    ];
    let start = Answer::new().with("reason", p.reason.to_string()).with_number("share", p.share);
    let sizes = parts.into_iter().filter(|(_, sizes)| !sizes.is_empty());
    sizes
        .fold(start, |answer, (name, sizes)| answer.with(name, list(sizes)))
        .with_number("gamma_change", p.level_change)
        .with("settled", p.is_settled)
        .with_number("perturbed_norm", p.enlarged_norm)
}

fn remark(p: &Perturbation) -> String {
    let change = match (p.is_settled, p.level_change.is_nan()) {
        (true, _) => "the level has settled".to_owned(),
        (false, true) => "the level is an upper bound, no limit was taken".to_owned(),
        (false, false) => format!(
            "the level has not settled: it fell by {:.1e} of itself when ten times less was added",
            p.level_change
        ),
    };
    format!("the plant is singular ({}); channels of {:.0e} of its gains were added, {change}", p.reason, p.share)
}

impl From<SynthesisError> for Failure {
    fn from(error: SynthesisError) -> Self {
        Self::new(format!("H-infinity synthesis: {error}")).with_hint(error.advice())
    }
}
