//! K(s) to the rows that a processor computes: reduction, polish, discretisation, realisation, arithmetic, stability
//! over speed.

pub mod amplifier_demand;
pub mod anti_windup;
pub mod arithmetic;
pub mod continuous;
pub mod discretise;
pub(crate) mod fidelity;
pub(crate) mod full_loop;
pub mod hand_over;
pub mod law;
pub mod modal;
mod modal_loop;
pub mod polish;
pub mod realise;
pub mod scaling;
pub mod sections;
pub mod speed_lift;
pub mod speed_proof;
pub mod stiffness_limit;
pub mod verification;
pub mod verification_error;

pub use law::{ControlLaw, Controller, MachineTag};
pub use realise::Realisation;

use crate::linalg::NumericError;
use thiserror::Error;

/// What can go wrong between a designed controller and its firmware tables.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ControllerError {
    /// A dense computation failed.
    #[error("{step}: {source}")]
    Numeric {
        /// The step.
        step: &'static str,
        /// Its failure.
        source: NumericError,
    },
    /// The realised controller does not reproduce the transfer matrix it came from.
    #[error("{step}: the transfer matrix changed by {error:.1e} of its peak, at most {allowed:.1e} is accepted")]
    Inaccurate {
        /// The step.
        step: &'static str,
        /// Largest relative change over the check frequencies.
        error: f64,
        /// Accepted change.
        allowed: f64,
    },
    /// The controller mixes axes, but the form needs independent axes.
    #[error(
        "second-order sections need a decentralised controller: output {output} depends on input {input}; use the \
         modal form"
    )]
    NotDecentralised {
        /// Output channel, from 0.
        output: usize,
        /// Input channel, from 0.
        input: usize,
    },
    /// A coefficient or a signal does not fit the arithmetic.
    #[error("{what} = {value:.3e} does not fit {format}; {advice}")]
    Range {
        /// The number.
        what: String,
        /// Its value.
        value: f64,
        /// The arithmetic.
        format: &'static str,
        /// What to do.
        advice: &'static str,
    },
    /// No parameters were found that meet the requirements.
    #[error("{step}: {reason}; {advice}")]
    Infeasible {
        /// The step.
        step: &'static str,
        /// What was not met, with numbers.
        reason: String,
        /// What to do.
        advice: &'static str,
    },
}

/// Names the step in front of a numeric failure.
pub(crate) fn in_step(step: &'static str) -> impl Fn(NumericError) -> ControllerError {
    move |source| ControllerError::Numeric { step, source }
}
