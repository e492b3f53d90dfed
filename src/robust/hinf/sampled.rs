//! Synthesis for sampled plants in the w plane, s = (2/T)(z − 1)/(z + 1). The map takes the unit circle to the
//! imaginary axis and keeps gains on it, stability and structure: the level of the mapped problem is that of the
//! sampled one. The controller is mapped back exactly, and its loop is closed and measured in z.

use super::singular::{NORM_TOL, Perturbation, synthesise_perturbed};
use super::{CLOSE, HinfSettings, HinfSolution, Limit};
use crate::augment::GeneralizedPlant;
use crate::linalg::NumericError;
use crate::lti::connect::lower_lft;
use crate::lti::norm::hinf_norm_discrete;
use crate::lti::sample::{inverse_tustin, tustin};
use crate::lti::{Continuous, Discrete, StateSpace};
use crate::robust::error::SynthesisError;

/// A sampled generalized plant with its image in the w plane.
#[derive(Clone, Debug)]
pub struct SampledPlant {
    system: StateSpace<Discrete>,
    /// The image, in the states of the plant.
    pub image: GeneralizedPlant,
}

impl SampledPlant {
    /// From the matrices with the partition of [`GeneralizedPlant`], read as those of sampled time.
    ///
    /// # Errors
    /// [`NumericError::PoleAtNyquist`].
    pub fn new(plant: GeneralizedPlant, time: Discrete) -> Result<Self, NumericError> {
        let system = plant.system.with_time(time);
        Ok(Self { image: GeneralizedPlant { system: inverse_tustin(&system)?, ..plant }, system })
    }

    /// The time base.
    pub fn time(&self) -> Discrete {
        self.system.time
    }

    /// A controller of the image as one of the plant.
    ///
    /// # Errors
    /// [`NumericError`] for a pole at s = 2/T, which is no pole of a sampled system.
    pub fn sample_controller(&self, of_image: &StateSpace<Continuous>) -> Result<StateSpace<Discrete>, NumericError> {
        tustin(of_image, self.system.time.period_s)
    }

    /// The loop with a controller u = K y.
    ///
    /// # Errors
    /// [`NumericError::IllPosed`] for an algebraic loop without a solution.
    pub fn close(&self, controller: &StateSpace<Discrete>) -> Result<StateSpace<Discrete>, NumericError> {
        lower_lft(&self.system, controller)
    }
}

/// [`synthesise_perturbed`] in sampled time. Levels and margins are those of the image; the norm, its frequency and the
/// growth rate are those of the sampled loop, and a level below that norm is raised to it.
///
/// # Errors
/// As [`synthesise_perturbed`]; [`SynthesisError::Refuted`] where the sampled loop misses the level by more than one
/// percent.
pub fn synthesise_sampled(
    plant: &SampledPlant,
    settings: &HinfSettings,
) -> Result<(HinfSolution<Discrete>, Option<Perturbation>), SynthesisError> {
    let (found, perturbation) = synthesise_perturbed(&plant.image, settings)?;
    let controller = plant.sample_controller(&found.controller)?;
    let closed = plant.close(&controller)?;
    let norm = hinf_norm_discrete(&closed, NORM_TOL)?;
    let time = plant.system.time;
    let mut certificate = found.certificate;
    certificate.growth_rate = closed.growth_rate()?;
    certificate.limit = certificate.limit.map(|limit| match limit {
        Limit::ControlSide { omega_rad_s } => Limit::ControlSide { omega_rad_s: time.true_frequency(omega_rad_s) },
        Limit::FilterSide { omega_rad_s } => Limit::FilterSide { omega_rad_s: time.true_frequency(omega_rad_s) },
        other => other,
    });
    let (gamma, growth_rate) = (found.gamma, certificate.growth_rate);
    // What the mapping of the controller may lose to rounding; more is another controller.
    if norm.norm > (1.0 + CLOSE) * gamma {
        return Err(SynthesisError::Refuted { gamma, norm: norm.norm, growth_rate });
    }
    let solution = HinfSolution {
        controller,
        gamma: gamma.max(norm.norm),
        gamma_opt: found.gamma_opt,
        closed_loop_norm: norm.norm,
        closed_loop_peak_rad_s: norm.peak_omega_rad_s,
        certificate,
    };
    Ok((solution, perturbation))
}
