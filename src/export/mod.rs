//! A controller as files that other programs and processors read: JSON, `.mat`, CSV, C with its test vectors, units for
//! co-simulation.

pub mod c;
pub(crate) mod error;
pub mod firmware;
pub mod fmu;
pub mod json;
pub mod mat;
pub(crate) mod problem;
pub(crate) mod ross;
pub mod rows;
pub(crate) mod sections;
pub mod table;
mod zip;
