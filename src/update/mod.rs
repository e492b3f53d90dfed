//! Element moduli from resonances and antiresonances.
//!
//! Parameters are the modulus factors θ of the update regions, always positive (the fit moves ln θ). Data are
//! resonances and antiresonances of the free-free rotor at rest, both from the full finite-element chain
//! ([`crate::rotor::spectrum`]): a truncated model moves antiresonances by tens of hertz. Two ways: Gauss–Newton with
//! analytic sensitivities and a prior ([`gauss_newton()`]), and the Nelder–Mead search of the reference method, Eq. (7)
//! ([`nelder_mead()`]).

pub(crate) mod alternatives;
pub(crate) mod determine;
pub mod gauss_newton;
pub mod hammers;
pub(crate) mod held_out;
pub mod machine;
pub(crate) mod matching;
mod moduli_fit;
pub mod nelder_mead;
pub(crate) mod outcome;
pub(crate) mod peak_kind;
mod problem;
pub(crate) mod shapes;
pub(crate) mod single_change;
pub(crate) mod targets;

pub use determine::{Combination, Determined};
pub use gauss_newton::gauss_newton_rotor;
pub use hammers::{PlacedTap, hammer_targets};
pub use held_out::tool_error_db;
pub use machine::{UpdatedMachine, front_and_rear, gauss_newton, nelder_mead};
pub use nelder_mead::nelder_mead_rotor;
pub use outcome::{Explanation, Method, ModulusFactor, PeakError, Updated};
pub use peak_kind::PeakKind;
pub use problem::UpdateSettings;
pub use shapes::ShapeComparison;
pub use targets::{FrfTargets, MeasuredShape, Target, Targets};

use crate::linalg::NumericError;
use crate::rotor::RotorError;
use crate::spindle::SpindleError;
use thiserror::Error;

/// Why a model could not be updated.
#[derive(Debug, Error)]
pub enum UpdateError {
    /// No element of spindle or tool belongs to an update region.
    #[error("no element carries a region: there is nothing to update")]
    NoRegions,
    /// Nothing to compare with.
    #[error("no measured frequency to compare with ({what})")]
    NoTargets {
        /// What was looked at.
        what: &'static str,
    },
    /// The model has no peak that could be the measured ones.
    #[error(
        "only {matched} of {measured} measured peaks have a partner in the model at the start; the model is too far \
         from the data"
    )]
    NoMatch {
        /// Peaks with a partner.
        matched: usize,
        /// Measured peaks.
        measured: usize,
    },
    /// A measured frequency that cannot be one.
    #[error("measured frequency {frequency_hz} Hz ({what}) is not a positive number")]
    BadTarget {
        /// Where it stands.
        what: String,
        /// The value.
        frequency_hz: f64,
    },
    /// The rotor model breaks a rule.
    #[error(transparent)]
    Rotor(#[from] RotorError),
    /// The machine breaks a rule.
    #[error(transparent)]
    Machine(#[from] SpindleError),
    /// A matrix computation failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}
