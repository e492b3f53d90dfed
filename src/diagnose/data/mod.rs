//! The measurement, whitened: what a diagnosis is held against.

pub mod evidence;
pub mod measurement;
