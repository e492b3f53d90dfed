//! Find where simulation and measurement disagree, name the missing effect, show the gap shrink.
//!
//! [`data`]: measured records become whitened evidence. [`fit`]: the reduced model of the machine
//! ([`crate::spindle::response`]) is fitted with nuisance parameters and any effects of the catalogue. [`locate`]: the
//! place of a discrepancy without a hypothesis. [`decide`]: screening, selection by BIC, verdict, next measurement.
//! [`conclude`]: mistakes of the rig, then effects, and the diagnosis.

pub mod conclude;
pub mod data;
pub mod decide;
pub mod fit;
pub mod locate;
pub(crate) mod records;
pub(crate) mod rotor_alone;

pub use conclude::course::{diagnose, diagnose_with};
pub use conclude::verdict::{Diagnosis, NamedEffect, Rival};
pub use data::evidence::{Evidence, Gap};
pub use decide::judgement::Verdict;
pub use records::finding::{Alternatives, FoundFault};

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
}

impl From<crate::rotor::RotorError> for DiagnoseError {
    fn from(error: crate::rotor::RotorError) -> Self {
        Self::Machine(SpindleError::Shaft(error))
    }
}
