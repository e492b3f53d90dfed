//! Damaged files: every format with its reader, and what damages them.

pub mod formats;
pub mod mutate;
