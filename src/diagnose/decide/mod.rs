//! Which effects are missing: screening, selection, verdict, and what to measure next.

pub mod candidate;
pub mod detectability;
pub mod judgement;
pub mod misfit;
pub mod next_measurement;
pub mod residuals;
pub mod screening;
pub mod selection;
pub mod verdict;
