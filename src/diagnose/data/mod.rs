//! The measurement, whitened: what a diagnosis is held against.

pub(crate) mod common_error;
pub(crate) mod corrected_evidence;
pub(crate) mod covariance;
pub mod evidence;
pub mod levitated;
pub mod measurement;
