//! H∞ synthesis, µ, D-K iteration.

mod control_cases;
mod dfit;
mod dk;
mod hinf_square;
mod minimax_step;
mod mu_constant;
mod mu_system;
mod regularise;
pub mod solve_cases;
mod solve_hinfsyn;
pub mod solve_keys;
mod solve_peers;
mod solve_sampled;
mod solve_shaping;
mod solve_singular;
