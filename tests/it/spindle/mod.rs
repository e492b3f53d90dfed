//! Effects, plant and shipped tools.

pub mod alike;
mod corrections;
mod effects_table;
pub mod rotors_without_magnets;
mod spindle_effects;
pub mod spindle_plant;
mod springs_in_one_plane;
mod tools;
mod without_tool;
