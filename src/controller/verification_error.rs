//! Why the stability of a loop could not be checked.

use super::ControllerError;
use crate::spindle::SpindleError;

/// Failure of the stability check.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum VerificationError {
    /// The plant could not be built.
    #[error(transparent)]
    Plant(#[from] SpindleError),
    /// The loop could not be evaluated.
    #[error(transparent)]
    Loop(#[from] ControllerError),
}
