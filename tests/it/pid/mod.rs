//! The PID.

mod given;
pub mod reference_pid;
mod surviving;
mod tuning;
