//! The measurement, whitened: what a diagnosis is held against.

pub mod common_error;
pub mod corrected_evidence;
pub mod evidence;
pub mod measurement;
