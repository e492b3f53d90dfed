//! H∞ synthesis, µ, D-K iteration.

mod control_cases;
mod dfit;
mod dk;
mod mu_constant;
mod mu_system;
pub mod solve_cases;
mod regularise;
mod solve_hinfsyn;
