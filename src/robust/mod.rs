//! Synthesis and analysis: H∞, μ bounds, D-scales and their fits, the D-K loop.
#![doc = include_str!("limits.md")]

pub mod dfit;
pub mod dfit_factors;
pub mod dfit_linear;
pub mod dfit_magnitudes;
pub mod dfit_polish;
pub mod dk;
pub mod dk_descent;
pub mod dk_record;
pub mod dk_scale;
pub mod dscale;
pub mod dscale_centre;
pub mod lmi;
pub mod minimax_step;
pub mod mu;
pub mod mu_certificate;
pub mod mu_lower;
pub mod mu_mixed;
pub mod mu_peak;
pub mod mu_reduction;
mod mu_search;
pub mod mu_system;
pub mod prescale;
pub mod robstab;
pub mod structure;

pub use structure::MuError;
pub mod assumptions;
pub mod error;
pub mod hinf;
pub mod hinf_controller;
mod hinf_feedthrough;
pub mod hinf_level;
pub mod hinf_normal;
mod hinf_pair;
mod hinf_search;
pub mod hinf_settings;

pub use error::{Condition, SynthesisError};
pub use hinf::{HinfSettings, HinfSolution, synthesise};
