//! The generalized plants that share one plane model.
//!
//! Every loop is judged on the whole machine: all flexible modes below half the sample rate and the static flexibility
//! of the others, sampled with hold and exact delay, mapped to the w plane, weights of true frequency. The synthesis
//! sees fewer modes; the route decides which plant: the sampled one, or the continuous one with a Padé approximant of
//! the total delay.

use super::PipelineError;
use super::widening::Widening;
use crate::augment::GeneralizedPlant;
use crate::augment::assembly::{UncertainMode, generalized_plane};
use crate::augment::plane::{Route, design_plane};
use crate::augment::split::ModeSplit;
use crate::augment::weight_plane::{FitErrors, WeightPlane};
use crate::augment::weights::Weights;
use crate::spindle::Machine;

/// How much of the gyroscopic split of the modes is covered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// Flexible modes whose split is covered in full, from the lowest.
    pub modes: usize,
    /// Share of the guard modes' split that is covered.
    pub guard_share: f64,
}

/// The problems that share one plane model, all in scaled signals and in the w plane.
#[derive(Clone, Debug)]
pub struct Problems {
    /// Gyroscopic split of the modes covered.
    pub split: Vec<ModeSplit>,
    /// Uncertainty of the covered problem.
    pub covered_modes: Vec<UncertainMode>,
    /// How much of the split is covered.
    pub cover: Cover,
    /// What the design aims at: the specification as written, or with wider limits where that is out of reach.
    pub aim: Weights,
    /// Factors on the limits of the specification in the aim.
    pub widening: Widening,
    /// Table 2 as written, of the whole machine.
    pub specification: GeneralizedPlant,
    /// The aim with the uncertainty as written, of the whole machine.
    pub aimed: GeneralizedPlant,
    /// The aim with the mode uncertainty widened by the split, of the whole machine.
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

/// The generalized plant of one plane that the synthesis sees, for a list of uncertain modes and a bound on T.
pub(super) fn build_generalized(
    machine: &Machine,
    weights: &Weights,
    flexible: usize,
    modes: &[UncertainMode],
    sensitivity_limit: Option<f64>,
    route: Route,
) -> Result<GeneralizedPlant, PipelineError> {
    let numbers: Vec<usize> = modes.iter().map(|m| m.number).collect();
    let plane = design_plane(machine, flexible, &numbers, route)?;
    let weights = Weights { complementary_sensitivity_limit: sensitivity_limit, ..weights.clone() };
    let weight_plane = match route {
        Route::Direct => WeightPlane::Synthesis { period_s: machine.spindle.electronics.sample_period_s() },
        Route::Emulation { .. } => WeightPlane::Laplace,
    };
    generalized_plane(&plane, modes, &weights, weight_plane).map_err(PipelineError::numeric("generalized plant"))
}

/// The generalized plant of one plane of the whole machine, sampled, in the w plane: what a loop is judged on. The
/// bound on T is a means of the design and no part of it.
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
    let weights = Weights { complementary_sensitivity_limit: None, ..weights.clone() };
    let weight_plane = WeightPlane::Analysis { period_s: machine.spindle.electronics.sample_period_s() };
    generalized_plane(&plane, modes, &weights, weight_plane)
        .map_err(PipelineError::numeric("generalized plant of the whole machine"))
}
