//! Controller JSON (formats.md, section 5) to [`Controller`]: u = C x + D y, matrices row by row, `sample_time_s` 0
//! means continuous time, channels front_x, front_y, rear_x, rear_y; `machine` is optional.

use super::controller_law::from_matrices;
pub use super::controller_law::{CHANNELS, TaggedController};
use super::error::InputError;
use super::error_list::ErrorList;
use super::file;
use super::json;
use super::mat;
use super::shipped;
use super::structure::check_structure;
use crate::controller::{Controller, MachineTag};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// A controller u = C x + D y, matrices row by row; positive feedback.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ControllerFile {
    /// Name in reports.
    name: String,
    /// `front_x`, `front_y`, `rear_x`, `rear_y`.
    inputs: Vec<String>,
    /// The same four names.
    outputs: Vec<String>,
    /// Sample time, s; 0 for continuous time.
    sample_time_s: f64,
    /// The machine that it was designed for.
    machine: Option<MachineFile>,
    /// n × n.
    #[serde(rename = "A")]
    a: Vec<Vec<f64>>,
    /// n × 4.
    #[serde(rename = "B")]
    b: Vec<Vec<f64>>,
    /// 4 × n, A/m.
    #[serde(rename = "C")]
    c: Vec<Vec<f64>>,
    /// 4 × 4, A/m.
    #[serde(rename = "D")]
    d: Vec<Vec<f64>>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MachineFile {
    /// Path of the spindle file, from this file.
    spindle: String,
    /// Path of the tool file, from this file.
    tool: String,
    /// SHA-256 of spindle and tool.
    hash: String,
}

/// A controller with the machine that its file names, from a path.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn load_tagged_controller(source: &str) -> Result<TaggedController, InputError> {
    let path = Path::new(source);
    let is_mat = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mat"));
    if is_mat && path.exists() {
        return mat::load_controller(source);
    }
    read_tagged_controller(source, &shipped::text_within(source, "controller", &[], file::MATRICES)?)
}

/// A controller from a path.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn load_controller(source: &str) -> Result<Controller, InputError> {
    Ok(load_tagged_controller(source)?.controller)
}

/// A controller from the text of a file; `file` names it in messages.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn read_controller(file: &str, text: &str) -> Result<Controller, InputError> {
    Ok(read_tagged_controller(file, text)?.controller)
}

/// As [`read_controller`], with the machine that the file names.
pub(crate) fn read_tagged_controller(file: &str, text: &str) -> Result<TaggedController, InputError> {
    let mut errors = ErrorList::new(file, text);
    let read = match json::parse::<ControllerFile>(text) {
        Ok(read) => Some(read),
        Err(error) => {
            // An error without a line is about the whole text.
            if error.is_data() && error.line() > 0 {
                check_structure::<ControllerFile>(&mut errors);
            }
            if errors.is_empty() {
                errors.add(InputError::json(file, &error));
            }
            None
        }
    };
    let controller = read.and_then(|read| controller(&mut errors, read));
    errors.finish(controller)
}

/// The controller of a file; what its values break is added to the errors.
fn controller(errors: &mut ErrorList<'_>, read: ControllerFile) -> Option<TaggedController> {
    if read.inputs == ["axial"] {
        let rule = "inputs: axial: a controller of the thrust axis; commands read those of the four radial axes";
        errors.add(InputError::new(errors.file, rule.to_owned()).with_hint("its firmware lies in the same folder"));
        return None;
    }
    for (key, names) in [("inputs", &read.inputs), ("outputs", &read.outputs)] {
        if names.iter().ne(CHANNELS.iter()) {
            let rule = format!("{key}: {} must be {}", names.join(", "), CHANNELS.join(", "));
            let error = InputError::new(errors.file, rule);
            errors.add(error.with_hint("reorder the rows or columns of the matrices to this channel order"));
        }
    }
    let parts = [read.a, read.b, read.c, read.d];
    let mut found = from_matrices(errors, &read.name, parts, read.sample_time_s)?;
    found.machine = read.machine.map(|m| MachineTag { spindle: m.spindle, tool: m.tool, hash: m.hash });
    Some(found)
}
