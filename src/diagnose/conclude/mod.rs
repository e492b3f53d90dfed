//! From records to a diagnosis: mistakes of the rig, then effects, then the verdict on both.

pub mod course;
mod unsearched;
pub mod verdict;
