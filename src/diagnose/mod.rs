//! Find where simulation and measurement disagree, name the missing effect, show the gap shrink.
//!
//! Measured records become whitened evidence ([`evidence`]); a Ritz-reduced refined model ([`skeleton`], [`model`]) answers
//! for any small parameters ([`nuisance`]) and any hypothesis of the catalogue ([`hypothesis`]) in milliseconds; [`fit`]
//! finds the most probable parameters; [`search`] chooses; [`localise`] looks for the place without a hypothesis;
//! [`judge`] gives the verdict.

mod choose;
pub mod compare;
pub mod correction;
pub mod coverage;
pub mod evidence;
pub mod experiment;
pub mod fit;
mod geodesic;
pub mod hypothesis;
pub mod impedance;
pub mod jacobian;
pub mod judge;
pub mod linearise;
pub mod localise;
pub mod model;
pub mod next;
pub mod nuisance;
pub mod place;
pub mod problem;
pub mod projection;
pub mod search;
pub mod view;

pub use evidence::{Evidence, Gap};
pub use judge::{Diagnosis, NamedEffect, Verdict, diagnose};

use crate::identify::IdentifyError;
use crate::linalg::NumericError;
use crate::spindle::SpindleError;
use thiserror::Error;

/// Why there is no diagnosis.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DiagnoseError {
    /// Nothing to compare with.
    #[error("the measurement has no sweep record: a diagnosis needs at least one 4×4 sweep")]
    NoSweep,
    /// A record that gives no frequency response.
    #[error(transparent)]
    Record(#[from] IdentifyError),
    /// A machine that breaks a rule.
    #[error(transparent)]
    Machine(#[from] SpindleError),
    /// A matrix computation failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// A hammer record and no controller for it.
    #[error(
        "hammer record at {speed_rpm} rpm names no controller: the levitated compliance depends on it"
    )]
    NoController {
        /// Speed, rpm.
        speed_rpm: f64,
    },
}

impl From<crate::rotor::RotorError> for DiagnoseError {
    fn from(error: crate::rotor::RotorError) -> Self {
        Self::Machine(SpindleError::Shaft(error))
    }
}
