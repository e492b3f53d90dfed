//! Verification on the plant that runs: more modes than the design model, exact delay, sampled, at every speed asked.

use super::closed_loop::{close, growth_rate};
use crate::linalg::NumericError;
use crate::lti::{Discrete, StateSpace};
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use rayon::prelude::*;
use std::f64::consts::TAU;
use thiserror::Error;

/// Why a prediction could not be made.
#[derive(Debug, Error)]
pub enum PredictError {
    /// The plant.
    #[error(transparent)]
    Spindle(#[from] SpindleError),
    /// A matrix computation.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// Stability of the sampled loop at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedCheck {
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Largest growth rate of the closed loop, 1/s; negative when stable.
    pub growth_rate_per_s: f64,
}

impl SpeedCheck {
    /// True when every pole decays.
    pub fn is_stable(&self) -> bool {
        self.growth_rate_per_s < 0.0
    }
}

/// Stability of the machine's full sampled plant with a sampled controller at each speed.
///
/// # Errors
/// [`PredictError`] when a plant cannot be built or the loop is not well posed.
pub fn stability_over_speed(
    machine: &Machine,
    controller: &StateSpace<Discrete>,
    speeds_rpm: &[f64],
) -> Result<Vec<SpeedCheck>, PredictError> {
    speeds_rpm
        .par_iter()
        .map(|rpm| {
            let plant = Plant::new(machine, rpm * TAU / 60.0, ModelDetail::Full)?.sampled()?;
            Ok(SpeedCheck {
                speed_rpm: *rpm,
                growth_rate_per_s: growth_rate(&plant, controller)?,
            })
        })
        .collect()
}

/// Closed-loop poles of the full sampled plant at one speed as equivalent continuous poles, rad/s.
///
/// # Errors
/// As [`stability_over_speed`].
pub fn closed_loop_poles(
    machine: &Machine,
    controller: &StateSpace<Discrete>,
    speed_rpm: f64,
) -> Result<Vec<crate::linalg::c64>, PredictError> {
    let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?.sampled()?;
    Ok(super::closed_loop::equivalent_poles(&close(
        &plant, controller,
    )?)?)
}
