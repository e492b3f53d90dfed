//! The generalized plants that share one plane model, and how far the tool's specification can be tightened.
//!
//! Every loop is judged on the whole machine: all flexible modes below half the sample rate and the static flexibility of the
//! others, sampled with hold and exact delay, mapped to the w plane, weights of true frequency. The synthesis sees fewer modes;
//! the route decides which plant: the sampled one, or the continuous one with a Padé approximant of the total delay.

use super::PipelineError;
use super::settings::DesignSettings;
use crate::augment::GeneralizedPlant;
use crate::augment::assembly::{UncertainMode, generalized_plane};
use crate::augment::plane::{Route, design_plane, modes_below_nyquist};
use crate::augment::split::{ModeSplit, gyroscopic_split};
use crate::augment::weight_plane::{FitErrors, WeightPlane, fit_errors};
use crate::augment::weights::Weights;
use crate::robust::SynthesisError;
use crate::robust::prescale::constant_scales;
use crate::spindle::Machine;
use std::f64::consts::TAU;

/// The problems that share one plane model, all in scaled signals and in the w plane.
#[derive(Clone, Debug)]
pub struct Problems {
    /// Gyroscopic split of the modes covered.
    pub split: Vec<ModeSplit>,
    /// Uncertainty of the covered problem.
    pub covered_modes: Vec<UncertainMode>,
    /// Share of the guard modes' split that is covered.
    pub guard_share: f64,
    /// Table 2 as written, of the whole machine.
    pub specification: GeneralizedPlant,
    /// Mode uncertainty widened by the split, of the whole machine.
    pub covered: GeneralizedPlant,
    /// Covered, with the bound on T, of the modes that the synthesis sees.
    pub synthesis: GeneralizedPlant,
    /// What the synthesis sees: `synthesis` on the direct route, its continuous counterpart in emulation.
    pub posed: GeneralizedPlant,
    /// How the sampled loop entered `posed`.
    pub route: Route,
    /// The bound on T, if any.
    pub sensitivity_limit: Option<f64>,
    /// Sample period, s.
    pub period_s: f64,
    /// Uncertainty of the specification as written.
    pub written_modes: Vec<UncertainMode>,
    /// Flexible modes that the synthesis sees.
    pub synthesis_modes: usize,
    /// Flexible modes of the whole machine: those below half the sample rate.
    pub machine_modes: usize,
    /// Their natural frequencies, rad/s.
    pub flexible_rad_s: Vec<f64>,
    /// How far the fitted weights lie above the written ones.
    pub fit_errors: FitErrors,
}

/// A problem with its constant scales.
struct Posed {
    plant: GeneralizedPlant,
    limit: Option<f64>,
    scales: Vec<f64>,
    gamma: f64,
}

/// Builds the three problems and the constant scales of the synthesis problem.
pub(super) fn pose(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
) -> Result<(Problems, Vec<f64>, f64), PipelineError> {
    let top_speed = machine.spindle.max_rpm * TAU / 60.0;
    let flexible_rad_s = modes_below_nyquist(machine)?;
    let machine_modes = flexible_rad_s.len();
    let kept = machine.spindle.flexible_modes.min(machine_modes);
    let covered = (kept + settings.guard_modes).min(machine_modes);
    let synthesis_modes = covered
        .saturating_add(settings.extra_modes)
        .min(machine_modes);
    let split = gyroscopic_split(machine, top_speed, covered)?;
    let table = |k: usize| weights.mode_uncertainty.get(k).copied().unwrap_or(0.0);
    // Uncertainty as written, or widened by the split, that of the guard modes by a share of it.
    let modes = |guard_share: Option<f64>| -> Vec<UncertainMode> {
        split
            .iter()
            .enumerate()
            .map(|(number, s)| UncertainMode {
                number,
                omega_rad_s: s.omega_rad_s,
                relative: table(number)
                    + match guard_share {
                        None => 0.0,
                        Some(_) if number < kept => s.relative(),
                        Some(share) => share * s.relative(),
                    },
            })
            .filter(|m| m.relative > 0.0)
            .collect()
    };
    let build = |modes: &[UncertainMode], limit: Option<f64>, route: Route| {
        generalized(machine, weights, synthesis_modes, modes, limit, route)
    };
    let given = weights.complementary_sensitivity_limit;
    let tighter: Vec<f64> = match given {
        Some(_) => vec![],
        None => settings.sensitivity_limits.clone(),
    };
    let mut shares = settings.guard_cover.clone();
    shares.retain(|share| *share > 0.0 && settings.guard_modes > 0);
    shares.push(0.0);
    let mut chosen = None;
    for share in shares {
        let covered_modes = modes(Some(share));
        let mut start: Vec<f64> = covered_modes.iter().map(|_| STARTING_SCALE).collect();
        let mut attempt = |limit: Option<f64>| -> Result<Posed, PipelineError> {
            let plant = build(&covered_modes, limit, settings.route)?;
            let found = constant_scales(&plant, &start)?;
            start.clone_from(&found.scale);
            start.pop();
            Ok(Posed {
                plant,
                limit,
                scales: found.scale,
                gamma: found.gamma,
            })
        };
        // The loosest bound first: whether this share can be had at all.
        let mut posed = attempt(given)?;
        if posed.gamma <= settings.gamma_target {
            // γ falls as the bound on T gives way: bisection finds the tightest bound of the list that is within reach.
            let (mut low, mut high) = (0, tighter.len());
            while low < high {
                let middle = low.midpoint(high);
                let tight = attempt(Some(tighter[middle]))?;
                if tight.gamma <= settings.gamma_target {
                    posed = tight;
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
        }
        let reached = posed.gamma <= settings.gamma_target;
        chosen = Some((posed, covered_modes, share));
        if reached {
            break;
        }
    }
    let Some((posed, covered_modes, guard_share)) = chosen else {
        return Err(PipelineError::Synthesis(SynthesisError::Partition(
            "no problem was posed".to_owned(),
        )));
    };
    let (sensitivity_limit, scales, gamma) = (posed.limit, posed.scales, posed.gamma);
    let (posed, written) = (posed.plant, modes(None));
    let period_s = machine.spindle.electronics.sample_period_s();
    let whole = |modes: &[UncertainMode]| whole_machine(machine, weights, machine_modes, modes);
    let problems = Problems {
        specification: whole(&written)?,
        covered: whole(&covered_modes)?,
        synthesis: match settings.route {
            Route::Direct => posed.clone(),
            Route::Emulation { .. } => build(&covered_modes, sensitivity_limit, Route::Direct)?,
        },
        posed,
        route: settings.route,
        sensitivity_limit,
        period_s,
        written_modes: written,
        synthesis_modes,
        machine_modes,
        flexible_rad_s,
        fit_errors: fit_errors(weights, period_s)
            .map_err(PipelineError::numeric("weights in the w plane"))?,
        covered_modes,
        guard_share,
        split,
    };
    Ok((problems, scales, gamma))
}

/// The generalized plant of one plane that the synthesis sees, for a list of uncertain modes and a bound on T.
pub(super) fn generalized(
    machine: &Machine,
    weights: &Weights,
    flexible: usize,
    modes: &[UncertainMode],
    sensitivity_limit: Option<f64>,
    route: Route,
) -> Result<GeneralizedPlant, PipelineError> {
    let numbers: Vec<usize> = modes.iter().map(|m| m.number).collect();
    let plane = design_plane(machine, flexible, &numbers, route)?;
    let weights = Weights {
        complementary_sensitivity_limit: sensitivity_limit,
        ..weights.clone()
    };
    let weight_plane = match route {
        Route::Direct => WeightPlane::Synthesis {
            period_s: machine.spindle.electronics.sample_period_s(),
        },
        Route::Emulation { .. } => WeightPlane::Laplace,
    };
    generalized_plane(&plane, modes, &weights, weight_plane)
        .map_err(PipelineError::numeric("generalized plant"))
}

/// The generalized plant of one plane of the whole machine, sampled, in the w plane: what a loop is judged on. The bound on
/// T is a means of the design and no part of it.
///
/// # Errors
/// [`PipelineError`] when the plant or a weight fails.
pub fn whole_machine(
    machine: &Machine,
    weights: &Weights,
    flexible: usize,
    modes: &[UncertainMode],
) -> Result<GeneralizedPlant, PipelineError> {
    let numbers: Vec<usize> = modes.iter().map(|m| m.number).collect();
    let plane = design_plane(machine, flexible, &numbers, Route::Direct)?;
    let weights = Weights {
        complementary_sensitivity_limit: None,
        ..weights.clone()
    };
    let weight_plane = WeightPlane::Analysis {
        period_s: machine.spindle.electronics.sample_period_s(),
    };
    generalized_plane(&plane, modes, &weights, weight_plane).map_err(PipelineError::numeric(
        "generalized plant of the whole machine",
    ))
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
/// within 2 %, searched between 1/64 and 64. A bound on T in the weights is kept; without one, none is asked for.
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
