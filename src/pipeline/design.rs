//! From machine and specification to the controller that firmware runs, with a certificate for every step.
//!
//! At rest the planes decouple: one plane is designed and copied. Three generalized plants share one plane model:
//! the *specification* (Table 2 as written), the *covered* problem (mode uncertainty widened by the gyroscopic split at the
//! highest speed, so that a design at rest holds at speed), and the *synthesis* problem (covered, plus a bound on the
//! complementary sensitivity, because Table 2 alone leaves sensitivity peaks of 15–20 dB). Synthesis takes the tightest
//! bound on T that keeps μ within its target. The w plane is exact in both directions, so nothing is lost to discretisation.

use super::PipelineError;
use super::certificates::{DScaleCurve, PeakFigures, Stage, attained, d_scales, mu_curve, stage};
use super::problems::{Problems, pose};
use crate::augment::GeneralizedPlant;
use crate::augment::assembly::{scale_controller, unscale_controller};
use crate::augment::plane::{Route, connected_part};
use crate::augment::weights::Weights;
use crate::controller::realise::modal_form;
use crate::controller::scaling::{ScaledRealisation, SignalLimits, scaled as scaled_realisation};
use crate::controller::verification::{Verification, verify};
use crate::controller::{ControlLaw, Controller};
use crate::lti::balance::frequency_weighted_balance;
use crate::lti::connect::lower_lft;
use crate::lti::sample::{inverse_tustin, tustin};
use crate::lti::{Continuous, StateSpace};
use crate::predict::closed_loop::both_planes;
use crate::robust::dk::{DkSettings, DkStep, iterate};
use crate::robust::prescale::scaled;
use crate::spindle::Machine;

/// What a designer may turn, with the defaults of the reference run.
#[derive(Clone, Debug)]
pub struct DesignSettings {
    /// Flexible modes in the design model beyond the spindle's `flexible_modes`.
    pub guard_modes: usize,
    /// Direct sampled design, or emulation.
    pub route: Route,
    /// Bounds on the complementary sensitivity to try, tightest first, when the weights leave it open.
    pub sensitivity_limits: Vec<f64>,
    /// Level that the optimal γ with constant scales must reach for a bound on T to be accepted.
    pub gamma_target: f64,
    /// Relative growth of μ that reduction may cost, as long as μ stays below one.
    pub reduction_budget: f64,
    /// Settings of the D-K iteration.
    pub dk: DkSettings,
    /// Speeds checked between zero and the top speed, evenly spaced, both ends included.
    pub speeds: usize,
}

impl Default for DesignSettings {
    fn default() -> Self {
        Self {
            guard_modes: 1,
            route: Route::Direct,
            sensitivity_limits: vec![3.5, 4.0, 4.5, 5.0, 6.0, 8.0, 12.0],
            gamma_target: 1.0,
            reduction_budget: 0.02,
            // Constant scales come first, so the iteration starts close: two steps with low-order scales settle it.
            dk: DkSettings {
                max_iterations: 3,
                max_d_order: 2,
                patience: 1,
                min_improvement: 2e-3,
                descent_rounds: 2,
                ..DkSettings::default()
            },
            speeds: 11,
        }
    }
}

/// A finished design.
#[derive(Clone, Debug)]
pub struct Design {
    /// The problems it solves.
    pub problems: Problems,
    /// Records of the D-K iteration on the synthesis problem.
    pub steps: Vec<DkStep>,
    /// D-scales of the best step beside what the pointwise bound of its loop asks for.
    pub d_scales: Vec<DScaleCurve>,
    /// γ of the best step.
    pub gamma: f64,
    /// Orders of the D-scales of the best step, summed over the blocks.
    pub d_order: usize,
    /// Level that μ of the synthesis problem had to keep in reduction.
    pub reduction_limit: f64,
    /// Controller of one plane as synthesised.
    pub full: Stage,
    /// After reduction.
    pub reduced: Stage,
    /// After rounding to float32, in sampled time.
    pub rounded: Stage,
    /// μ over frequency of the rounded loop on the specification: Hz, upper, lower.
    pub specification_curve: Vec<(f64, f64, f64)>,
    /// μ over frequency of the rounded loop on the covered problem.
    pub covered_curve: Vec<(f64, f64, f64)>,
    /// μ against order tried in reduction: (order, μ of the covered problem).
    pub orders_tried: Vec<(usize, f64)>,
    /// Growth rate of the controller's own poles, 1/s; negative: stable.
    pub controller_growth_rate_per_s: f64,
    /// Modal form with scaled states, before rounding.
    pub realisation: ScaledRealisation,
    /// The controller as it runs: four axes, sampled, coefficients rounded to float32.
    pub controller: Controller,
    /// The same in the continuous w plane, unrounded.
    pub continuous: Controller,
    /// Stability of the full sampled plant with it, over speed.
    pub verification: Verification,
    /// The same from the top speed to 20 % above it.
    pub overspeed: Verification,
}

impl Design {
    /// True when Table 2 is met and every speed is stable.
    pub fn meets_targets(&self) -> bool {
        self.rounded.specification.upper <= 1.0 && self.verification.is_stable()
    }
}

/// The whole design.
///
/// # Errors
/// [`PipelineError`] says which stage failed.
pub fn design(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    progress: &mut dyn FnMut(&DkStep),
) -> Result<Design, PipelineError> {
    let (problems, scales, _) = pose(machine, weights, settings)?;
    let outcome = iterate(
        &scaled(&problems.synthesis, &scales),
        &settings.dk,
        progress,
    )?;
    let d_scales = d_scales(&problems, &scales, &outcome)?;
    let full = outcome.controller;
    let full_stage = stage("full order", &problems, &full)?;
    let reduction_limit = full_stage.synthesis * (1.0 + settings.reduction_budget);
    let (reduced, orders_tried) = reduce(&problems, &scales, &full, &full_stage, reduction_limit)?;
    let reduced_stage = stage("reduced order", &problems, &reduced)?;
    let period_s = machine.spindle.electronics.sample_period_s();
    let physical = unscale_controller(&reduced);
    let sampled = tustin(&physical, period_s).map_err(PipelineError::numeric("discretisation"))?;
    let realisation = scaled_realisation(
        &modal_form(&both_planes(&sampled))?,
        SignalLimits {
            input_m: machine.spindle.backup_clearance_m,
            output_a: machine
                .spindle
                .front
                .bias_current_a
                .min(machine.spindle.rear.bias_current_a),
        },
    )?;
    // What is verified is what firmware computes: the scaled rows with float32 coefficients. Its x plane closes the
    // design plane.
    let rounded = realisation.rows.rounded_f32()?;
    let plane_rounded = connected_part(&rounded.select(&[0, 2], &[0, 2]));
    let back = inverse_tustin(&plane_rounded).map_err(PipelineError::numeric("rounded loop"))?;
    let rounded_plane = scale_controller(&back);
    let rounded_stage = stage("rounded", &problems, &rounded_plane)?;
    let verification = Verification {
        mu_peak: Some(rounded_stage.specification.upper),
        ..verify(
            machine,
            &rounded,
            settings.speeds,
            "full finite-element plant, exact delay, sampled; coefficients rounded to float32",
        )?
    };
    let mut faster = machine.clone();
    faster.spindle.max_rpm *= OVERSPEED;
    let mut overspeed = verify(
        &faster,
        &rounded,
        OVERSPEED_POINTS,
        "as below the top speed",
    )?;
    overspeed
        .speeds
        .retain(|s| s.speed_rpm >= machine.spindle.max_rpm);
    let curve = |plant: &GeneralizedPlant, peak: &PeakFigures| {
        mu_curve(plant, &rounded_plane, peak, period_s)
    };
    Ok(Design {
        specification_curve: curve(&problems.specification, &rounded_stage.specification)?,
        covered_curve: curve(&problems.covered, &rounded_stage.covered)?,
        gamma: outcome.gamma,
        d_order: outcome
            .steps
            .get(outcome.best_iteration)
            .map_or(0, |s| s.d_orders.iter().sum()),
        reduction_limit,
        d_scales,
        steps: outcome.steps,
        full: full_stage,
        reduced: reduced_stage,
        rounded: rounded_stage,
        orders_tried,
        controller_growth_rate_per_s: sampled
            .growth_rate()
            .map_err(PipelineError::numeric("controller poles"))?,
        realisation,
        controller: named("mu", ControlLaw::Discrete(rounded)),
        continuous: named("mu", ControlLaw::Continuous(both_planes(&physical))),
        verification,
        overspeed,
        problems,
    })
}

/// Margin over the top speed that the loop should survive.
const OVERSPEED: f64 = 1.2;
/// Speeds from zero to the overspeed: steps of a tenth of the top speed.
const OVERSPEED_POINTS: usize = 13;

fn named(name: &str, law: ControlLaw) -> Controller {
    Controller {
        name: name.to_owned(),
        law,
    }
}

/// Lowest order whose μ on the synthesis problem stays within budget and whose loop is stable.
///
/// Balanced truncation of K weighted by what the loop makes of a change of K: F_l(P, K + ΔK) − F_l(P, K) =
/// N₁₂ ΔK (I − N₂₂ ΔK)⁻¹ N₂₁ (Anderson and Liu 1989), with N the loop closed by K and opened again beside it.
fn reduce(
    problems: &Problems,
    scales: &[f64],
    full: &StateSpace<Continuous>,
    at_full: &Stage,
    limit: f64,
) -> Result<(StateSpace<Continuous>, Vec<(usize, f64)>), PipelineError> {
    const STAGE: &str = "reduction";
    let numeric = || PipelineError::numeric(STAGE);
    let plant = scaled(&problems.synthesis, scales);
    let (nw, nz) = (plant.disturbances(), plant.errors());
    let twice = |first: usize, count: usize| -> Vec<usize> {
        (0..first)
            .chain(first..first + count)
            .chain(first..first + count)
            .collect()
    };
    let ports = plant
        .system
        .select(&twice(nz, plant.measurements), &twice(nw, plant.controls));
    let opened = lower_lft(&ports, full).map_err(numeric())?;
    let list = |from: usize, count: usize| (from..from + count).collect::<Vec<_>>();
    let output_weight = opened.select(&list(0, nz), &list(nw, plant.controls));
    let input_weight = opened.select(&list(nz, plant.measurements), &list(0, nw));
    let balancing = frequency_weighted_balance(full, Some(&input_weight), Some(&output_weight))
        .map_err(numeric())?;
    let mut tried = vec![];
    for order in balancing.kept().max(1)..full.order() {
        for candidate in [balancing.truncated(order), balancing.residualised(order)] {
            // A cut that is singular at this order is no candidate.
            let Ok(candidate) = candidate else { continue };
            let Some(mu) = attained(&problems.synthesis, &candidate)? else {
                continue;
            };
            tried.push((order, mu));
            if mu <= limit {
                tried.push((full.order(), at_full.synthesis));
                return Ok((candidate, tried));
            }
        }
    }
    tried.push((full.order(), at_full.synthesis));
    Ok((full.clone(), tried))
}
