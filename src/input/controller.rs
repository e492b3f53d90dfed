//! Controller JSON (formats.md, section 5) to [`Controller`]: u = C x + D y, matrices row by row, `sample_time_s` 0
//! means continuous time, channels front_x, front_y, rear_x, rear_y; `machine` is optional.

use super::error::InputError;
use super::shipped;
use crate::controller::{ControlLaw, Controller, MachineTag};
use crate::linalg::Mat;
use crate::lti::{Continuous, Discrete, StateSpace};
use serde::Deserialize;

/// Names of the channels, in order.
pub const CHANNELS: [&str; 4] = ["front_x", "front_y", "rear_x", "rear_y"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ControllerFile {
    name: String,
    inputs: Vec<String>,
    outputs: Vec<String>,
    sample_time_s: f64,
    machine: Option<MachineFile>,
    #[serde(rename = "A")]
    a: Vec<Vec<f64>>,
    #[serde(rename = "B")]
    b: Vec<Vec<f64>>,
    #[serde(rename = "C")]
    c: Vec<Vec<f64>>,
    #[serde(rename = "D")]
    d: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MachineFile {
    spindle: String,
    tool: String,
    hash: String,
}

/// A controller with the machine that its file names.
#[derive(Clone, Debug)]
pub struct TaggedController {
    /// The controller.
    pub controller: Controller,
    /// What it was designed for, when the file says so.
    pub machine: Option<MachineTag>,
}

/// A controller with the machine that its file names, from a path.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn load_tagged_controller(source: &str) -> Result<TaggedController, InputError> {
    read_tagged_controller(source, &shipped::text(source, "controller", &[])?)
}

/// A controller from a path.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn load_controller(source: &str) -> Result<Controller, InputError> {
    read_controller(source, &shipped::text(source, "controller", &[])?)
}

/// A controller from the text of a file; `file` names it in messages.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn read_controller(file: &str, text: &str) -> Result<Controller, InputError> {
    Ok(read_tagged_controller(file, text)?.controller)
}

/// As [`read_controller`], with the machine that the file names.
///
/// # Errors
/// As [`read_controller`].
pub fn read_tagged_controller(file: &str, text: &str) -> Result<TaggedController, InputError> {
    let read: ControllerFile =
        serde_json::from_str(text).map_err(|e| InputError::json(file, &e))?;
    for (key, names) in [("inputs", &read.inputs), ("outputs", &read.outputs)] {
        if names.iter().ne(CHANNELS.iter()) {
            let rule = format!(
                "{key}: {} must be {}",
                names.join(", "),
                CHANNELS.join(", ")
            );
            return Err(InputError::new(file, rule)
                .with_hint("reorder the rows or columns of the matrices to this channel order"));
        }
    }
    let n = read.a.len();
    let a = matrix(file, "A", &read.a, n, n)?;
    let b = matrix(file, "B", &read.b, n, CHANNELS.len())?;
    let c = matrix(file, "C", &read.c, CHANNELS.len(), n)?;
    let d = matrix(file, "D", &read.d, CHANNELS.len(), CHANNELS.len())?;
    let period_s = read.sample_time_s;
    if !(period_s.is_finite() && period_s >= 0.0) {
        let rule = format!("sample_time_s: {period_s} must be zero or a positive number");
        return Err(InputError::new(file, rule).with_hint("0 means continuous time"));
    }
    let numeric = |error: crate::linalg::NumericError| InputError::new(file, error.to_string());
    let law = if period_s == 0.0 {
        ControlLaw::Continuous(StateSpace::new(a, b, c, d, Continuous).map_err(numeric)?)
    } else {
        ControlLaw::Discrete(StateSpace::new(a, b, c, d, Discrete { period_s }).map_err(numeric)?)
    };
    Ok(TaggedController {
        controller: Controller {
            name: read.name,
            law,
        },
        machine: read.machine.map(|m| MachineTag {
            spindle: m.spindle,
            tool: m.tool,
            hash: m.hash,
        }),
    })
}

fn matrix(
    file: &str,
    key: &str,
    rows: &[Vec<f64>],
    expected_rows: usize,
    expected_columns: usize,
) -> Result<Mat<f64>, InputError> {
    let hint = "A is n×n, B n×4, C 4×n, D 4×4, row by row";
    if rows.len() != expected_rows {
        let rule = format!("{key}: has {} rows, must have {expected_rows}", rows.len());
        return Err(InputError::new(file, rule).with_hint(hint));
    }
    for (i, row) in rows.iter().enumerate() {
        if row.len() != expected_columns {
            let rule = format!(
                "{key}[{i}]: has {} columns, must have {expected_columns}",
                row.len()
            );
            return Err(InputError::new(file, rule).with_hint(hint));
        }
        if let Some(j) = row.iter().position(|x| !x.is_finite()) {
            return Err(InputError::new(
                file,
                format!("{key}[{i}][{j}]: must be a number"),
            ));
        }
    }
    Ok(Mat::from_fn(expected_rows, expected_columns, |i, j| {
        rows[i][j]
    }))
}
