//! The most probable parameters of a set of effects, with nuisance parameters.

pub mod case;
mod columns;
pub(crate) mod estimate;
pub(crate) mod geodesic;
pub mod hypothesis;
pub(crate) mod jacobian;
pub(crate) mod levitated_line;
pub(crate) mod linearise;
pub mod model;
pub(crate) mod nuisance;
pub(crate) mod prediction;
pub mod problem;
pub(crate) mod record_number;
mod slope_reading;
pub(crate) mod smooth;
