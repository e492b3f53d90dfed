//! The part of a design that the D-K iteration leads to: its controller at full and reduced order, and from that what
//! is delivered.

use super::PipelineError;
use super::certificates::{DScaleCurve, KnownStage, Stage, d_scales, stage};
use super::delivery::{Delivery, DeliveryCandidate, Realised};
use super::emulation::Emulated;
use super::polish_job::PolishJob;
use super::polish_outcome::PolishOutcome;
use super::polishing::{Entrant, polish_law};
use super::problems::Problems;
use super::reduction::reduce;
use super::settings::DesignSettings;
use super::stable::OwnStability;
use super::synthesis::{Round, Synthesised};
use crate::augment::assembly::unscale_controller;
use crate::augment::weights::Weights;
use crate::lti::sample::tustin;
use crate::lti::{Continuous, StateSpace};
use crate::robust::dk::DkStep;
use crate::robust::dk::scale::DScales;
use crate::spindle::Machine;

/// What the D-K iteration and the reduction of its controller led to.
#[derive(Clone, Debug)]
pub struct DkDesign {
    /// Records of the D-K iteration on the synthesis problem.
    pub steps: Vec<DkStep>,
    /// Syntheses with more modes or a lower level that μ of the whole machine asked for; the last is the first within
    /// target.
    pub rounds: Vec<Round>,
    /// D-scales of the best step beside what the pointwise bound of its loop asks for.
    pub d_scales: Vec<DScaleCurve>,
    /// The D-scales of the best step times the constant scales that it started from.
    pub scales: DScales,
    /// γ of the best step.
    pub gamma: f64,
    /// Orders of the D-scales of the best step, summed over the blocks.
    pub d_order: usize,
    /// Stability of the controller itself.
    pub own_stability: OwnStability,
    /// What sampling did, on the emulation route.
    pub emulated: Option<Emulated>,
    /// Level that μ of the synthesis problem had to keep in reduction.
    pub reduction_limit: f64,
    /// Controller of one plane as synthesised.
    pub full: Stage,
    /// After reduction.
    pub reduced: Stage,
    /// Orders tried in reduction, each with the largest μ found on the synthesis problem.
    pub orders_tried: Vec<(usize, f64)>,
}

/// What a design delivers, and what the polish did when it was asked for.
pub(super) type Made = (Delivery, Option<PolishOutcome>);

/// Reduces the controller of the D-K iteration, and polishes and certifies what is delivered; `entrant` is what the
/// polish of an earlier design led to.
pub(super) fn dk_design(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    found: &Synthesised,
    entrant: Option<Entrant>,
) -> Result<(DkDesign, Made), PipelineError> {
    let (problems, scales, outcome) = (&found.problems, &found.scales, &found.outcome);
    let (full, synthesis) = (&found.full, found.synthesis);
    let known = |synthesis: f64| KnownStage { synthesis: Some(synthesis), ..KnownStage::default() };
    let reduction_limit = synthesis * (1.0 + settings.reduction_budget);
    let deliver = || {
        let reduced = reduce(problems, scales, full, synthesis, reduction_limit)?;
        let (made, at_reduced) = rayon::join(
            || {
                let from = (&reduced.controller, entrant);
                deliver_reduced(machine, weights, settings, problems, from.0, from.1)
            },
            || {
                let known = known(reduced.synthesis);
                stage("reduced order", problems, &reduced.controller, known)
            },
        );
        Ok::<_, PipelineError>((reduced.tried, at_reduced?, made?))
    };
    // What only the report says of the controller as synthesised is computed beside what is delivered.
    let (made, (d_scales, full_stage)) = rayon::join(deliver, || {
        rayon::join(|| d_scales(problems, scales, outcome), || stage("full order", problems, full, known(synthesis)))
    });
    let (orders_tried, reduced, made) = made?;
    let best = outcome.steps.get(outcome.best_iteration);
    let dk = DkDesign {
        rounds: found.rounds.clone(),
        d_scales: d_scales?,
        scales: outcome.scales.times(scales),
        gamma: outcome.gamma,
        d_order: best.map_or(0, |s| s.d_orders.iter().sum()),
        own_stability: found.own_stability.clone(),
        emulated: found.emulated,
        reduction_limit,
        full: full_stage?,
        reduced,
        orders_tried,
        steps: outcome.steps.clone(),
    };
    Ok((dk, made))
}

/// What a controller of scaled signals in the w plane becomes: sampled, polished where that is asked, rounded and
/// proven.
fn deliver_reduced(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    problems: &Problems,
    reduced: &StateSpace<Continuous>,
    entrant: Option<Entrant>,
) -> Result<Made, PipelineError> {
    let period_s = machine.spindle.electronics.sample_period_s();
    let physical = unscale_controller(reduced);
    let sampled = tustin(&physical, period_s).map_err(PipelineError::numeric("discretisation"))?;
    let Some(job) = PolishJob::set_up_job(machine, weights, problems, settings) else {
        let realised = Realised::new(machine, &sampled)?;
        let from_dk = DeliveryCandidate::new(machine, weights, problems, realised)?;
        let proof = from_dk.proof(machine)?;
        let delivery = from_dk.deliver_candidate(machine, weights, problems, settings.speeds, proof)?;
        return Ok((delivery, None));
    };
    let (delivery, outcome) = polish_law(job, &sampled, entrant)?;
    Ok((delivery, Some(outcome)))
}
