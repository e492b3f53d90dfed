//! Closed-loop aware reduction of the controller.

use super::PipelineError;
use super::certificates::attained_gain;
use super::problems::Problems;
use crate::lti::balance::{Balancing, frequency_weighted_balance};
use crate::lti::connect::lower_lft;
use crate::lti::{Continuous, StateSpace};
use crate::robust::prescale::scale_signals;

/// A controller of lower order.
pub(super) struct Reduced {
    /// The controller, or the one of full order where no cut keeps μ within the limit.
    pub(super) controller: StateSpace<Continuous>,
    /// Largest bound of μ found on the synthesis problem.
    pub(super) synthesis: f64,
    /// Orders with that μ, as they were tried.
    pub(super) tried: Vec<(usize, f64)>,
}

/// Lowest order whose μ on the synthesis problem stays within the limit and whose loop is stable; `at_full` is that μ
/// at full order.
///
/// Balanced truncation of K, weighted by the effect of a change of K on the loop: F_l(P, K + ΔK) − F_l(P, K) = N₁₂ ΔK
/// (I − N₂₂ ΔK)⁻¹ N₂₁ (Anderson and Liu 1989), with N the loop closed by K and opened again beside it.
pub(super) fn reduce(
    problems: &Problems,
    scales: &[f64],
    full: &StateSpace<Continuous>,
    at_full: f64,
    limit: f64,
) -> Result<Reduced, PipelineError> {
    let numeric = || PipelineError::numeric(STAGE);
    let balancing = loop_balancing(problems, scales, full)?;
    // Truncation must not add an unstable pole.
    let keep_stable = full.growth_rate().map_err(numeric())? < 0.0;
    let mut tried = vec![];
    for order in balancing.kept_states().max(1)..full.order() {
        for candidate in [balancing.truncate_states(order), balancing.residualise_states(order)] {
            // A cut that is singular at this order is no candidate.
            let Ok(candidate) = candidate else { continue };
            if keep_stable && candidate.growth_rate().map_err(numeric())? >= 0.0 {
                continue;
            }
            let Some(mu) = attained_gain(&problems.synthesis, &candidate)? else {
                continue;
            };
            tried.push((order, mu));
            if mu <= limit {
                tried.push((full.order(), at_full));
                return Ok(Reduced { controller: candidate, synthesis: mu, tried });
            }
        }
    }
    tried.push((full.order(), at_full));
    Ok(Reduced { controller: full.clone(), synthesis: at_full, tried })
}

const STAGE: &str = "reduction";

/// Balancing of K, weighted by the effect of a change of K on the loop of the synthesis problem.
pub(super) fn loop_balancing(
    problems: &Problems,
    scales: &[f64],
    full: &StateSpace<Continuous>,
) -> Result<Balancing, PipelineError> {
    let numeric = || PipelineError::numeric(STAGE);
    let plant = scale_signals(&problems.synthesis, scales);
    let (nw, nz) = (plant.disturbances(), plant.errors());
    let twice = |first: usize, count: usize| -> Vec<usize> {
        (0..first).chain(first..first + count).chain(first..first + count).collect()
    };
    let ports = plant.system.select(&twice(nz, plant.measurements), &twice(nw, plant.controls));
    let opened = lower_lft(&ports, full).map_err(numeric())?;
    let list = |from: usize, count: usize| (from..from + count).collect::<Vec<_>>();
    let output_weight = opened.select(&list(0, nz), &list(nw, plant.controls));
    let input_weight = opened.select(&list(nz, plant.measurements), &list(0, nw));
    frequency_weighted_balance(full, Some(&input_weight), Some(&output_weight)).map_err(numeric())
}
