//! The PID.

mod tuning;
