//! Which effects are missing: screening, selection, verdict, and what to measure next.

pub mod candidate;
pub mod detectability;
mod imitation;
pub(crate) mod judgement;
mod located;
pub mod misfit;
pub mod next_measurement;
mod relatives;
pub mod residuals;
pub(crate) mod screening;
pub(crate) mod selection;
pub(crate) mod small;
mod strong;
pub(crate) mod tie;
