//! `muspin solve hinfsyn`: a generalized plant → γ_opt, a controller slightly above it, and its verified norm.

use super::answer::system;
use super::{Answer, Failure, Problem};
use crate::robust::{HinfSettings, Limit, SynthesisError, synthesise};

/// Solves the problem of the file; `gamma` in the file asks for the central controller at that level.
pub(super) fn solve(problem: &Problem) -> Result<Answer, Failure> {
    let plant = problem.generalized_plant()?;
    let mut settings = HinfSettings::default();
    if problem.has("gamma") {
        settings.gamma = Some(problem.number("gamma")?);
    }
    let found = synthesise(&plant, &settings)?;
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
        .with_number("coupling", c.coupling)
        .with_number("closed_loop_max_real", c.growth_rate)
        .with("riccati_pairs", c.pairs);
    let answer =
        if settings.gamma.is_none() { Answer::new().with_number("gamma_opt", found.gamma_opt) } else { Answer::new() };
    Ok(answer
        .with_number("gamma", found.gamma)
        .with_number("closed_loop_norm", found.closed_loop_norm)
        .with("controller", system(&found.controller))
        .with("certificate", certificate))
}

impl From<SynthesisError> for Failure {
    fn from(error: SynthesisError) -> Self {
        Self::new(format!("H-infinity synthesis: {error}")).with_hint(error.advice())
    }
}
