//! Controllers as files.

mod exchange;
pub mod firmware;
pub mod firmware_c;
mod section_tables;
mod units;
