//! The PID.

pub mod reference_pid;
mod tuning;
mod surviving;
