//! The way from files to a report, as the commands and the Python package go it: records with their plausibility, what
//! lies beside them, each stage with its verdict, and a failure with what to do about it.

mod advice;
pub(crate) mod diagnose;
pub(crate) mod diagnose_rotor;
mod failure;
pub(crate) mod identify;
pub(crate) mod plausibility;
pub(crate) mod solve;
pub(crate) mod surroundings;
pub(crate) mod update;

pub use failure::Failure;
