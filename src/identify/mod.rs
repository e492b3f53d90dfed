//! Records to frequency responses with covariance, and whether they are plausible; resonances and antiresonances;
//! hammer tests.

mod antiresonances;
mod channel;
pub mod decay;
mod drift;
mod fourier;
pub(crate) mod free_free;
pub mod frf;
pub(crate) mod hammer;
mod line_noise;
mod local;
mod lscf;
mod odd_repeats;
pub mod peaks;
pub mod plausibility;
pub mod polluted;
pub(crate) mod rehearsal;
pub(crate) mod repeat_scatter;
mod selection;
pub mod spectra;
mod stabilisation;
mod window;

pub use drift::{PoleDrift, pole_drift};
pub use free_free::{Identification, Reading, identify};
pub use frf::{MeasuredFrf, SweepRecord, open_loop, open_loop_columns};
pub use hammer::{HammerFrf, shared_resonances};
pub use plausibility::{Plausibility, hammer_plausibility, sweep_plausibility};
pub use rehearsal::Rehearsal;

use crate::linalg::NumericError;
use crate::rotor::RotorError;
use crate::spindle::SpindleError;
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
    /// Not one experiment per axis, where that is needed.
    #[error("{name}: {found} of 4 injections: here G = Y U⁻¹ needs one per axis")]
    Experiments {
        /// The record.
        name: String,
        /// Experiments found.
        found: usize,
    },
    /// No response is determined.
    #[error("{name}: {why}")]
    Undetermined {
        /// The record.
        name: String,
        /// What is missing.
        why: String,
    },
    /// Experiments that do not tell the axes apart.
    #[error(
        "{name}: at {frequency_hz} Hz the four experiments are linearly dependent (condition number of U \
         {condition:.1e}): G = Y U⁻¹ does not exist"
    )]
    Singular {
        /// The record.
        name: String,
        /// The line, Hz.
        frequency_hz: f64,
        /// Condition number of U.
        condition: f64,
    },
    /// Whirl splits every peak at speed.
    #[error(
        "the sweep was taken at {speed_rpm} rpm: resonances and antiresonances of the rotor at rest need a sweep at 0 \
         rpm"
    )]
    NotAtRest {
        /// Speed, rpm.
        speed_rpm: f64,
    },
    /// Nothing to see.
    #[error("no lightly damped resonance stands out between {from_hz} and {to_hz} Hz")]
    NoResonance {
        /// First line, Hz.
        from_hz: f64,
        /// Last line, Hz.
        to_hz: f64,
    },
    /// The machine breaks a rule.
    #[error(transparent)]
    Machine(#[from] SpindleError),
    /// The rotor model breaks a rule.
    #[error(transparent)]
    Rotor(#[from] RotorError),
    /// A matrix computation failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}
