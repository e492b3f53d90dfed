//! Effects, plant and shipped tools.

pub mod alike;
mod effects_table;
mod spindle_effects;
pub mod spindle_plant;
mod springs_in_one_plane;
mod tools;
