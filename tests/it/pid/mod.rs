//! The PID.

pub mod reference_pid;
mod surviving;
mod tuning;
