//! Records to frequency responses with covariance; resonances and antiresonances; hammer tests.

pub mod frf;
pub mod hammer;

pub use frf::{MeasuredFrf, SweepRecord, open_loop};
pub use hammer::HammerFrf;

use crate::linalg::NumericError;
use thiserror::Error;

/// Why a record gives no frequency response.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IdentifyError {
    /// No lines or no repeats.
    #[error("{name}: no frequency lines")]
    Empty {
        /// The record.
        name: String,
    },
    /// Not one experiment per axis.
    #[error("{name}: {found} experiments, G = Y U⁻¹ needs exactly 4, one injection per axis")]
    Experiments {
        /// The record.
        name: String,
        /// Experiments found.
        found: usize,
    },
    /// Experiments that do not tell the axes apart.
    #[error(
        "{name}: at {frequency_hz} Hz the four experiments are linearly dependent (condition number of U {condition:.1e}): G = Y U⁻¹ does not exist"
    )]
    Singular {
        /// The record.
        name: String,
        /// The line, Hz.
        frequency_hz: f64,
        /// Condition number of U.
        condition: f64,
    },
    /// A matrix computation failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}
