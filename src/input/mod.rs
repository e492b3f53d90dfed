//! Files in: YAML, CSV, JSON, UFF to validated domain values. The only home of parsing.
//!
//! Every function takes a path or the name of a shipped file, and either returns a domain value that keeps all rules or
//! one [`InputError`] that says file, line or key path, rule and hint.

mod by_plane;
mod consistency;
pub mod controller;
pub(crate) mod controller_law;
pub(crate) mod correction;
mod curve;
mod disc;
mod effect;
pub mod error;
mod error_list;
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
pub mod pid;
pub mod plausible;
mod positive;
pub mod problem;
pub mod problem_keys;
mod problem_matrix;
pub mod problem_schema;
mod problem_system;
pub(crate) mod quote;
mod response_unit;
pub mod ross;
pub(crate) mod ross_magnet;
mod ross_notes;
pub(crate) mod ross_parts;
mod ross_table;
pub mod rotor;
pub mod rotor_kind;
pub mod schema;
pub mod shipped;
pub mod spindle;
mod structure;
pub mod sweep;
mod table;
pub mod time_record;
pub mod tool;
mod tree;
pub mod uff;
pub mod uff_frf;
mod uff_units;
mod uncertainty;
pub mod wav;
pub mod weights;
pub mod write;
pub mod yaml;

pub use controller::{load_controller, load_tagged_controller, read_controller};
pub use correction::with_correction;
pub use error::InputError;
pub use measurement::{Measurement, load_measurement, load_measurement_watched};
pub use plausible::Warning;
pub use rotor::{load_rotor, read_rotor};
pub use rotor_kind::is_rotor;
pub use spindle::{load_spindle, read_spindle};
pub use tool::{load_tool, read_tool};
pub use weights::{load_weights, read_weights};
pub(crate) use write::machine_files;
pub use write::{rotor_yaml, spindle_yaml, tool_yaml};

use crate::spindle::{Machine, Spindle, Tool};

/// In the place of a tool where there is none.
pub(crate) const NO_TOOL: &str = "none";

/// The tool of a spindle for which none is named: none where the file says where stiffness counts without one.
///
/// # Errors
/// [`InputError`] of the spindle file.
pub(crate) fn usual_tool(spindle: &str) -> Result<&'static str, InputError> {
    Ok(if load_spindle(spindle)?.output_m.is_some() { NO_TOOL } else { "paper-tool" })
}

/// The spindle and the tool of one machine; `none` for no tool.
///
/// # Errors
/// [`InputError`] of whichever file is wrong: all errors of the spindle, else of the tool, else of the two together.
pub fn load_machine(spindle: &str, tool: &str) -> Result<Machine, InputError> {
    let spindle_value = load_spindle(spindle)?;
    if tool == NO_TOOL {
        return Machine::without_tool(spindle_value).map_err(|error| InputError::rule(spindle, &error));
    }
    let tool_value = load_tool(tool, &spindle_value)?;
    join_machine(&format!("{spindle} with {tool}"), spindle_value, tool_value)
}

/// The machine of a spindle and a tool that are right alone; `file` names it in messages.
pub(crate) fn join_machine(file: &str, spindle: Spindle, tool: Tool) -> Result<Machine, InputError> {
    let mut errors = error_list::ErrorList::new(file, "");
    for error in Machine::broken_rules(&spindle, &tool) {
        errors.add(InputError::rule(file, &error));
    }
    let machine = Machine::new(spindle, tool).map_err(|error| InputError::rule(file, &error));
    errors.finish(machine.ok())
}
