//! K(s) to firmware: PID, reduction, discretisation, realisation, export.

pub mod law;

pub use law::{ControlLaw, Controller};
