//! Synthesis and analysis: H∞, μ bounds, D-scales and their fits, the D-K loop.
#![doc = include_str!("limits.md")]

pub(crate) mod conic;
pub mod coprime;
pub mod dfit;
pub mod disc_margin;
pub mod dk;
pub(crate) mod error;
mod frequency_floor;
pub mod h2;
pub mod hinf;
pub mod minimax;
pub mod mu;
pub mod prescale;
pub mod riccati_cause;
pub mod structure;

pub use error::{Condition, SynthesisError};
pub use hinf::{HinfSettings, HinfSolution, Limit, synthesise};
pub use structure::MuError;
