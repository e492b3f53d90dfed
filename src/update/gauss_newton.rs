//! Gauss–Newton with a trust region on ln θ: minimises  Σ (ln(f/f̂)/σ)² + ln θᵀ C⁻¹ ln θ.
//!
//! C is the prior of `determine`; σ are the relative standard deviations of the measured frequencies, so that
//! the weight of the prior follows the noise. Where no standard deviation is given the noise is estimated: along a path
//! of noise-to-prior ratios ρ, from smooth to tight, the marginal likelihood with the prior scale profiled out,
//!   n ln(c/n) + ln det(J C₁ Jᵀ + ρ²I),  c = Σ (r/ρ)² + uᵀu,  C₁ the prior at unit variance,
//! is smallest at ρ̂, and σ̂ = ρ̂ √(c/n) (MacKay, Bayesian interpolation, Neural Computation 4, 1992).

use super::alternatives::Refit;
use super::determine::{find_determined, prior_root};
use super::moduli_fit::{CONVERGED, UpdateFit};
use super::outcome::{Explanation, Method, READING_SD, Updated, assemble};
use super::problem::{UpdateProblem, UpdateSettings};
use super::targets::Targets;
use super::{UpdateError, outcome};
use crate::linalg::Mat;
use crate::rotor::Rotor;

/// Standard deviation of ln θ when the moduli are known not to explain the data: factors stay near the drawing.
const DISCREPANT_PRIOR_SD: f64 = 0.3;
/// Moves the modulus factors of all regions until the model shows the measured frequencies.
///
/// # Errors
/// [`UpdateError`] when there is nothing to fit, nothing matches, or a matrix computation fails. Data that moduli
/// cannot explain are not an error: see [`Updated::explanation`].
pub fn gauss_newton_rotor(rotor: &Rotor, targets: &Targets, settings: &UpdateSettings) -> Result<Updated, UpdateError> {
    let problem = UpdateProblem::new(rotor, targets, settings.use_antiresonances)?;
    let positions: Vec<f64> = problem.chain.regions.iter().map(|r| r.position_m).collect();
    let unit_root = prior_root(&positions, 1.0, settings.prior_correlation_m)?;
    let n = problem.parameters();
    let start = problem.evaluate(&vec![0.0; n], true);
    outcome::check_matches(&problem, &start)?;
    let mut fit =
        UpdateFit { problem: &problem, evaluations: 1, limit: settings.max_evaluations.max(2), at: start.clone() };
    let known = |p: &super::problem::MeasuredPeak| p.target.standard_deviation_hz.is_some();
    let used = || problem.peaks.iter().filter(|p| p.used);
    let estimated = if used().all(known) { None } else { Some(fit.noise(&unit_root)?.max(settings.floor_relative_sd)) };
    let mut sigma: Vec<f64> = problem
        .peaks
        .iter()
        .map(|p| {
            let given = p.target.standard_deviation_hz.map(|s| s / p.target.frequency_hz);
            match (given, estimated) {
                (Some(s), _) => s.max(settings.floor_relative_sd),
                (None, Some(s)) => s,
                (None, None) => settings.floor_relative_sd,
            }
        })
        .collect();
    let sd = settings.prior_sd_ln;
    let mut root = Mat::from_fn(n, n, |i, j| sd * unit_root[(i, j)]);
    let mut state = fit.minimise(&sigma, &root, CONVERGED)?;
    let data = used().count();
    let mut explanation = Explanation::judge(&problem, &fit.at, state.objective, data, estimated.is_some());
    if !explanation.explained {
        let found = problem.peaks.iter().zip(&fit.at.compared).all(|(peak, own)| !peak.used || own.model.is_some());
        if found {
            let of_readings = vec![READING_SD; sigma.len()];
            let scatter = if estimated.is_some() { &of_readings } else { &sigma };
            let refit = Refit { sigma: scatter, root: &root, settings };
            let best = refit.best_alternative(rotor, targets)?;
            explanation.name_alternative(best.as_ref());
        }
        // Whatever the moduli cannot explain must not bend them: fit again with the discrepancy counted as noise and
        // with moduli that scatter as the likelihood says, not as the wide prior allows.
        fit.at = start.clone();
        fit.limit = fit.evaluations + settings.max_evaluations.max(2);
        let discrepancy = fit.noise(&unit_root)?;
        root = Mat::from_fn(n, n, |i, j| DISCREPANT_PRIOR_SD * unit_root[(i, j)]);
        for s in &mut sigma {
            *s = s.max(discrepancy);
        }
        fit.at = start.clone();
        state = fit.minimise(&sigma, &root, CONVERGED)?;
    }
    let known = find_determined(&root, &state.values, &state.vectors);
    assemble(
        rotor,
        &problem,
        outcome::Finish {
            method: Method::GaussNewton,
            start: &start,
            end: &fit.at,
            evaluations: fit.evaluations,
            iterations: fit.evaluations - 1,
            relative_sd: sigma,
            noise_estimated: estimated.is_some(),
            determined: known,
            explanation,
        },
        targets,
    )
}
