//! The most probable parameters of a set of effects, with nuisance parameters.

pub mod case;
pub mod estimate;
pub mod geodesic;
pub mod hypothesis;
pub mod jacobian;
pub mod linearise;
pub mod model;
pub mod nuisance;
pub mod prediction;
pub mod problem;
pub mod record_number;
pub mod smooth;
