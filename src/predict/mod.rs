//! Closed loop, dynamic stiffness, sensitivity zones, worst case, time response.

pub mod amplification;
pub mod cascade;
pub mod chatter;
pub mod closed_loop;
pub mod dips;
pub mod disc_margins;
pub mod loop_gain;
pub mod loop_shape;
pub mod loop_sigma;
pub mod modes;
pub mod recovery;
pub mod sensitivity;
pub mod shaft_line;
pub mod stiffness;
pub mod time;
pub mod time_cases;
pub mod time_force;
pub mod tool_step;
pub mod worst_case;
mod worst_search;
