//! Updates the model, designs the controller and predicts what it does: pure functions without files, printing or
//! clock.

pub mod batch;
pub mod bracket;
pub mod certificates;
pub mod compared;
pub mod comparison;
pub(crate) mod consequence;
pub mod contact;
pub mod delivery;
pub mod design;
pub mod dk_design;
pub mod emulation;
pub(crate) mod firmware_proof;
pub mod growth;
pub mod instability;
pub mod judged;
pub mod least_mu;
pub(crate) mod levitating_pid;
pub mod loop_curves;
pub(crate) mod loop_stability;
pub mod model_curves;
pub mod order_curve;
pub(crate) mod overspeed;
pub(crate) mod pid_loop;
mod polish_job;
pub mod polish_outcome;
mod polishing;
pub mod posing;
pub(crate) mod problem_set;
pub mod problems;
pub mod progress;
pub mod real_corners;
mod reduction;
pub(crate) mod response_table;
mod rotating_loop;
pub mod run;
pub(crate) mod sampled;
pub mod settings;
pub mod shank_limit;
pub(crate) mod simulation;
pub mod specification_scale;
pub mod speed_mu;
pub mod stable;
mod starting_pid;
pub(crate) mod study;
pub mod synthesis;
pub mod thrust;
pub mod tightening;
pub mod variation;
pub mod widening;
pub mod worst;

use crate::controller::ControllerError;
use crate::controller::verification_error::VerificationError;
use crate::linalg::NumericError;
use crate::predict::chatter::ChatterError;
use crate::predict::time::TimeError;
use crate::robust::dk::DkError;
use crate::robust::{MuError, SynthesisError};
use crate::spindle::SpindleError;
use crate::update::UpdateError;
use thiserror::Error;

/// Which stage failed, and how.
#[derive(Debug, Error)]
pub enum PipelineError {
    /// Building the plant.
    #[error("plant: {0}")]
    Plant(#[from] SpindleError),
    /// A matrix computation.
    #[error("{stage}: {source}")]
    Numeric {
        /// Stage of the pipeline.
        stage: &'static str,
        /// What failed.
        source: NumericError,
    },
    /// H∞ synthesis.
    #[error("synthesis: {0}")]
    Synthesis(#[from] SynthesisError),
    /// The D-K iteration.
    #[error("D-K iteration: {0}")]
    Dk(#[from] DkError),
    /// μ of a loop.
    #[error("{stage}: μ: {source}")]
    Mu {
        /// Stage of the pipeline.
        stage: &'static str,
        /// What failed.
        source: MuError,
    },
    /// Reduction, realisation or rounding.
    #[error("controller: {0}")]
    Controller(#[from] ControllerError),
    /// A continuous design that does not survive sampling.
    #[error("emulation: the sampled loop is unstable at each of the {tried} prewarp frequencies tried")]
    Emulated {
        /// Prewarp frequencies tried.
        tried: usize,
    },
    /// Stability lobes.
    #[error("chatter: {0}")]
    Chatter(#[from] ChatterError),
    /// Model updating.
    #[error("model updating: {0}")]
    Update(#[from] UpdateError),
    /// A time response.
    #[error("simulation: {0}")]
    Time(#[from] TimeError),
    /// A sampled controller with the sample time of another machine.
    #[error(
        "sample_time_s {given_s} does not match the spindle's sample rate of {rate_hz} Hz (sample time {})",
        rate_hz.recip()
    )]
    SampleTime {
        /// Of the controller, s.
        given_s: f64,
        /// Of the machine, Hz.
        rate_hz: f64,
    },
    /// Stability over speed.
    #[error("verification: {0}")]
    Verification(#[from] VerificationError),
}

impl PipelineError {
    /// Tags a numeric failure with its stage, for `map_err`.
    pub(crate) fn numeric(stage: &'static str) -> impl Fn(NumericError) -> Self {
        move |source| Self::Numeric { stage, source }
    }

    /// Tags a failure of μ with its stage, for `map_err`.
    pub(crate) fn mu(stage: &'static str) -> impl Fn(MuError) -> Self {
        move |source| Self::Mu { stage, source }
    }
}
