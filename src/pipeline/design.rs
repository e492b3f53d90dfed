//! From machine and specification to the controller that firmware runs, with a certificate for every step.
//!
//! At rest the planes decouple: one plane is designed and copied. Three generalized plants share one plane model:
//! the *specification* (Table 2 as written), the *covered* problem (mode uncertainty widened by the gyroscopic split at the
//! highest speed, so that a design at rest holds at speed), and the *synthesis* problem (covered, plus a bound on the
//! complementary sensitivity, because Table 2 alone leaves sensitivity peaks of 15–20 dB). Synthesis takes the tightest
//! bound on T that keeps μ within its target. The w plane is exact in both directions, so nothing is lost to discretisation.

use super::PipelineError;
use crate::augment::assembly::{
    UncertainMode, generalized_plane, scale_controller, unscale_controller,
};
use crate::augment::plane::{Route, design_plane};
use crate::augment::split::{ModeSplit, gyroscopic_split};
use crate::augment::weights::Weights;
use crate::augment::{Block, GeneralizedPlant};
use crate::controller::realise::{Realisation, modal_form};
use crate::controller::verification::{Verification, verify};
use crate::controller::{ControlLaw, Controller};
use crate::lti::balance::frequency_weighted_balance;
use crate::lti::connect::lower_lft;
use crate::lti::sample::{inverse_tustin, tustin};
use crate::lti::{Continuous, Discrete, FrequencyGrid, StateSpace};
use crate::predict::closed_loop::both_planes;
use crate::robust::MuError;
use crate::robust::dk::{DkSettings, DkStep, iterate};
use crate::robust::mu_system::{MuPeak, MuSystem};
use crate::robust::prescale::{constant_scales, scaled};
use crate::spindle::Machine;
use rayon::prelude::*;
use std::f64::consts::TAU;

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

/// The problems that share one plane model, all in scaled signals and in the w plane.
#[derive(Clone, Debug)]
pub struct Problems {
    /// Gyroscopic split of the modes covered.
    pub split: Vec<ModeSplit>,
    /// Uncertainty of the covered problem.
    pub covered_modes: Vec<UncertainMode>,
    /// Table 2 as written.
    pub specification: GeneralizedPlant,
    /// Mode uncertainty widened by the split.
    pub covered: GeneralizedPlant,
    /// Covered, with the bound on T.
    pub synthesis: GeneralizedPlant,
    /// The bound on T, if any.
    pub sensitivity_limit: Option<f64>,
    /// Sample period, s.
    pub period_s: f64,
}

/// Certified peak of μ of one loop.
#[derive(Clone, Copy, Debug)]
pub struct PeakFigures {
    /// No frequency has a larger μ.
    pub upper: f64,
    /// Lower bound at the peak, with a perturbation behind it.
    pub lower: f64,
    /// Frequency of the peak, Hz, in the w plane mapped back to true frequency.
    pub frequency_hz: f64,
}

/// A controller on its way: order and μ of the three problems.
#[derive(Clone, Copy, Debug)]
pub struct Stage {
    /// States of one plane's controller.
    pub order: usize,
    /// Specification.
    pub specification: PeakFigures,
    /// Covered problem.
    pub covered: PeakFigures,
    /// Largest bound found on the synthesis problem.
    pub synthesis: f64,
}

/// A finished design.
#[derive(Clone, Debug)]
pub struct Design {
    /// The problems it solves.
    pub problems: Problems,
    /// Records of the D-K iteration on the synthesis problem.
    pub steps: Vec<DkStep>,
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
    /// Realisation in modal form, before rounding.
    pub realisation: Realisation,
    /// The controller as it runs: four axes, sampled, coefficients rounded to float32.
    pub controller: Controller,
    /// The same in the continuous w plane, unrounded.
    pub continuous: Controller,
    /// Stability of the full sampled plant with it, over speed.
    pub verification: Verification,
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
    let full = outcome.controller;
    let full_stage = stage("full order", &problems, &full)?;
    let reduction_limit = full_stage.synthesis * (1.0 + settings.reduction_budget);
    let (reduced, orders_tried) = reduce(&problems, &scales, &full, &full_stage, reduction_limit)?;
    let reduced_stage = stage("reduced order", &problems, &reduced)?;
    let period_s = machine.spindle.electronics.sample_period_s();
    let physical = unscale_controller(&reduced);
    let sampled = tustin(&physical, period_s).map_err(PipelineError::numeric("discretisation"))?;
    let plane_rounded = modal_form(&sampled)?.rounded_f32()?;
    let back = inverse_tustin(&plane_rounded).map_err(PipelineError::numeric("rounded loop"))?;
    let rounded_plane = scale_controller(&back);
    let rounded_stage = stage("rounded", &problems, &rounded_plane)?;
    let realisation = modal_form(&both_planes(&sampled))?;
    let rounded = realisation.rounded_f32()?;
    let verification = Verification {
        mu_peak: Some(rounded_stage.specification.upper),
        ..verify(
            machine,
            &rounded,
            settings.speeds,
            "full finite-element plant, exact delay, sampled; coefficients rounded to float32",
        )?
    };
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
        problems,
    })
}

fn named(name: &str, law: ControlLaw) -> Controller {
    Controller {
        name: name.to_owned(),
        law,
    }
}

/// Builds the three problems and the constant scales of the synthesis problem.
fn pose(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
) -> Result<(Problems, Vec<f64>, f64), PipelineError> {
    let top_speed = machine.spindle.max_rpm * TAU / 60.0;
    let kept = machine.spindle.flexible_modes;
    let split = gyroscopic_split(machine, top_speed, kept)?;
    let table = |k: usize| weights.mode_uncertainty.get(k).copied().unwrap_or(0.0);
    let modes = |widen: bool| -> Vec<UncertainMode> {
        split
            .iter()
            .enumerate()
            .map(|(k, s)| UncertainMode {
                omega_rad_s: s.omega_rad_s,
                relative: table(k) + if widen { s.relative() } else { 0.0 },
            })
            .filter(|m| m.relative > 0.0)
            .collect()
    };
    let build = |modes: &[UncertainMode], limit: Option<f64>| {
        let flexible = kept + settings.guard_modes;
        let plane = design_plane(machine, flexible, modes.len(), settings.route)?;
        let weights = Weights {
            complementary_sensitivity_limit: limit,
            ..weights.clone()
        };
        generalized_plane(&plane, modes, &weights)
            .map_err(PipelineError::numeric("generalized plant"))
    };
    let (written, covered_modes) = (modes(false), modes(true));
    let given = weights.complementary_sensitivity_limit;
    let candidates: Vec<Option<f64>> = match given {
        Some(limit) => vec![Some(limit)],
        None => settings
            .sensitivity_limits
            .iter()
            .map(|l| Some(*l))
            .chain([None])
            .collect(),
    };
    let mut start: Vec<f64> = covered_modes.iter().map(|_| STARTING_SCALE).collect();
    let mut attempt = |limit: Option<f64>| -> Result<_, PipelineError> {
        let synthesis = build(&covered_modes, limit)?;
        let found = constant_scales(&synthesis, &start)?;
        start.clone_from(&found.scale);
        start.pop();
        Ok((synthesis, limit, found.scale, found.gamma))
    };
    let mut candidates = candidates.into_iter();
    let mut chosen = attempt(candidates.next().flatten())?;
    for limit in candidates {
        if chosen.3 <= settings.gamma_target {
            break;
        }
        chosen = attempt(limit)?;
    }
    let (synthesis, sensitivity_limit, scales, gamma) = chosen;
    let problems = Problems {
        specification: build(&written, None)?,
        covered: build(&covered_modes, None)?,
        synthesis,
        sensitivity_limit,
        period_s: machine.spindle.electronics.sample_period_s(),
        covered_modes,
        split,
    };
    Ok((problems, scales, gamma))
}

/// Optimal γ with constant scales of the covered problem without a bound on T, the tool's specification tightened by
/// `tightening`: an upper bound of the μ that a design reaches.
///
/// # Errors
/// [`PipelineError`] when the plant or every synthesis fails.
pub fn covered_gamma(
    machine: &Machine,
    weights: &Weights,
    tightening: f64,
    settings: &DesignSettings,
) -> Result<f64, PipelineError> {
    let tightened = Weights {
        tool_tightening: weights.tool_tightening * tightening,
        ..weights.clone()
    };
    let only = DesignSettings {
        sensitivity_limits: vec![],
        ..settings.clone()
    };
    Ok(pose(machine, &tightened, &only)?.2)
}

/// Largest factor on the tool's specification (displacements divided by it) for which [`covered_gamma`] is at most one,
/// within 2 %, searched between 1/64 and 64.
///
/// # Errors
/// As [`covered_gamma`].
pub fn largest_tightening(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
) -> Result<f64, PipelineError> {
    let meets = |factor: f64| {
        Ok::<_, PipelineError>(covered_gamma(machine, weights, factor, settings)? <= 1.0)
    };
    let (mut low, mut high) = (1.0 / 64.0, 64.0);
    // Octaves first, from the factor asked: most specifications are within a factor of four.
    let mut factor = 1.0;
    let up = meets(factor)?;
    while factor > low && factor < high {
        let next = if up { factor * 2.0 } else { factor / 2.0 };
        if meets(next)? != up {
            (low, high) = if up { (factor, next) } else { (next, factor) };
            break;
        }
        factor = next;
    }
    while high / low > 1.02 {
        let middle = (low * high).sqrt();
        if meets(middle)? {
            low = middle
        } else {
            high = middle
        }
    }
    Ok(low)
}

/// Where the search for constant scales of modal channels starts: q is of the order 1e-6 m√kg, √(2r)ω₀ of 1e3 rad/s.
const STARTING_SCALE: f64 = 100.0;

fn stage(
    name: &'static str,
    problems: &Problems,
    controller: &StateSpace<Continuous>,
) -> Result<Stage, PipelineError> {
    Ok(Stage {
        order: controller.order(),
        specification: figures(
            &peak(name, &problems.specification, controller)?,
            problems.period_s,
        ),
        covered: figures(
            &peak(name, &problems.covered, controller)?,
            problems.period_s,
        ),
        synthesis: attained(&problems.synthesis, controller)?.unwrap_or(f64::INFINITY),
    })
}

/// Certified peak of μ of a problem closed with a controller of scaled signals.
///
/// # Errors
/// [`PipelineError`] when the loop is unstable or the certificate fails.
pub fn peak(
    name: &'static str,
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
) -> Result<MuPeak, PipelineError> {
    // Certified a tenth of a percent above what is attained: below the digits reported.
    closed(name, plant, controller)?
        .peak(1e-3)
        .map_err(PipelineError::mu(name))
}

fn closed(
    name: &'static str,
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
) -> Result<MuSystem, PipelineError> {
    let loop_system = lower_lft(&plant.system, controller).map_err(PipelineError::numeric(name))?;
    let blocks: &[Block] = &plant.blocks;
    MuSystem::new(&loop_system, blocks).map_err(PipelineError::mu(name))
}

fn figures(peak: &MuPeak, period_s: f64) -> PeakFigures {
    PeakFigures {
        upper: peak.upper,
        lower: peak.bounds.lower,
        frequency_hz: true_frequency_hz(peak.omega_rad_s, period_s),
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

/// Largest upper bound of μ found over frequency; `None` for an unstable loop.
fn attained(
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
) -> Result<Option<f64>, PipelineError> {
    const STAGE: &str = "reduction";
    match closed(STAGE, plant, controller) {
        Ok(system) => Ok(Some(
            system.search().map_err(PipelineError::mu(STAGE))?.0.upper,
        )),
        Err(PipelineError::Mu {
            source: MuError::Unstable { .. },
            ..
        }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// μ over true frequency: Hz, upper, lower, on a log grid with the peak.
fn mu_curve(
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
    peak: &PeakFigures,
    period_s: f64,
) -> Result<Vec<(f64, f64, f64)>, PipelineError> {
    const STAGE: &str = "μ over frequency";
    let system = closed(STAGE, plant, controller)?;
    let nyquist_hz = 0.5 / period_s;
    let grid = FrequencyGrid::log_hz(1.0, 0.98 * nyquist_hz, CURVE_POINTS);
    let mut lines: Vec<f64> = grid.hz();
    lines.push(peak.frequency_hz);
    lines.retain(|f| *f < nyquist_hz);
    lines.sort_by(f64::total_cmp);
    lines
        .par_iter()
        .map(|f| {
            let omega = 2.0 / period_s * (0.5 * TAU * f * period_s).tan();
            let bounds = system.bounds(omega).map_err(PipelineError::mu(STAGE))?;
            Ok((*f, bounds.upper, bounds.lower))
        })
        .collect()
}

/// Points of the μ curves of the report.
const CURVE_POINTS: usize = 160;

/// True frequency of a point of the w plane: ω = (2/T) atan(vT/2).
pub fn true_frequency_hz(w_plane_rad_s: f64, period_s: f64) -> f64 {
    2.0 / period_s * (0.5 * w_plane_rad_s * period_s).atan() / TAU
}

/// Sampled law of a controller.
pub fn sampled_law(controller: &Controller) -> Option<&StateSpace<Discrete>> {
    match &controller.law {
        ControlLaw::Discrete(law) => Some(law),
        ControlLaw::Continuous(_) => None,
    }
}
