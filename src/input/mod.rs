//! Files in: YAML, CSV, JSON, UFF to validated domain values. The only home of parsing.
//!
//! Every function takes a path or the name of a shipped file, and either returns a domain value that keeps all rules or
//! one [`InputError`] that says file, line or key path, rule and hint.

pub mod controller;
pub(crate) mod controller_law;
mod curve;
mod effect;
pub mod error;
pub mod file;
pub mod hammer;
pub(crate) mod json;
mod key;
pub mod keys;
pub mod kind;
mod list_limits;
pub mod mat;
pub mod measurement;
pub mod name;
pub mod plausible;
mod positive;
pub mod problem;
pub mod problem_keys;
mod problem_matrix;
pub mod problem_schema;
pub(crate) mod quote;
pub mod ross;
pub(crate) mod ross_magnet;
mod ross_notes;
pub(crate) mod ross_parts;
mod ross_table;
pub mod schema;
pub mod shipped;
pub mod spindle;
pub mod sweep;
mod table;
pub mod tool;
pub mod uff;
pub mod uff_frf;
mod uff_units;
mod uncertainty;
pub mod weights;
pub mod write;
pub mod yaml;

pub use controller::{load_controller, load_tagged_controller, read_controller};
pub use error::InputError;
pub use measurement::{Measurement, load_measurement, load_measurement_watched};
pub use plausible::Warning;
pub use spindle::{load_spindle, read_spindle};
pub use tool::{load_tool, read_tool};
pub use weights::{load_weights, read_weights};
pub use write::{spindle_yaml, tool_yaml};

use crate::spindle::{Machine, SpindleError};

/// The spindle and the tool of one machine.
///
/// # Errors
/// [`InputError`] of whichever file is wrong.
pub fn load_machine(spindle: &str, tool: &str) -> Result<Machine, InputError> {
    let spindle_value = load_spindle(spindle)?;
    let tool_value = load_tool(tool, &spindle_value)?;
    let in_both = |error: SpindleError| InputError::rule(&format!("{spindle} with {tool}"), &error);
    Machine::new(spindle_value, tool_value).map_err(in_both)
}
