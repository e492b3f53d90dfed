//! A controller from its matrices, whatever file they come from: sizes, sample time, and the machine that it was
//! designed for.

use super::error::InputError;
use crate::controller::{ControlLaw, Controller, MachineTag};
use crate::linalg::Mat;
use crate::lti::{Continuous, Discrete, StateSpace};

/// Names of the channels, in order.
pub const CHANNELS: [&str; 4] = ["front_x", "front_y", "rear_x", "rear_y"];

/// Most states of a controller that is read: firmware has tens.
pub(super) const MOST_STATES: usize = 1000;

/// A controller with the machine that its file names.
#[derive(Clone, Debug)]
pub struct TaggedController {
    /// The controller.
    pub controller: Controller,
    /// What it was designed for, when the file says so.
    pub machine: Option<MachineTag>,
}

/// A controller from the rows of A, B, C and D; sample time 0 is continuous time.
///
/// # Errors
/// [`InputError`] with the matrix of other sizes.
pub(super) fn from_matrices(
    file: &str,
    name: &str,
    [a, b, c, d]: [Vec<Vec<f64>>; 4],
    period_s: f64,
) -> Result<TaggedController, InputError> {
    let n = a.len();
    if n > MOST_STATES {
        let rule = format!("A: has {n} rows; a controller has {MOST_STATES} states at most");
        return Err(InputError::new(file, rule).with_hint("reduce the order first"));
    }
    let a = matrix(file, "A", &a, n, n)?;
    let b = matrix(file, "B", &b, n, CHANNELS.len())?;
    let c = matrix(file, "C", &c, CHANNELS.len(), n)?;
    let d = matrix(file, "D", &d, CHANNELS.len(), CHANNELS.len())?;
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
    Ok(TaggedController { controller: Controller { name: name.to_owned(), law }, machine: None })
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
            let rule = format!("{key}[{i}]: has {} columns, must have {expected_columns}", row.len());
            return Err(InputError::new(file, rule).with_hint(hint));
        }
        if let Some(j) = row.iter().position(|x| !x.is_finite()) {
            return Err(InputError::new(file, format!("{key}[{i}][{j}]: must be a number")));
        }
    }
    Ok(Mat::from_fn(expected_rows, expected_columns, |i, j| rows[i][j]))
}
