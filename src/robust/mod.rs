//! Synthesis and analysis: H∞, μ bounds, D-scales and their fits, the D-K loop.

pub mod assumptions;
pub mod error;
pub mod hinf;
pub mod hinf_controller;
pub mod hinf_level;
pub mod hinf_normal;

pub use error::{Condition, SynthesisError};
pub use hinf::{HinfSettings, HinfSolution, synthesise};
