//! A controller from its matrices, whatever file they come from: sizes, sample time, and the machine that it was
//! designed for.

use super::error::InputError;
use super::error_list::ErrorList;
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

/// A controller from the rows of A, B, C and D; sample time 0 is continuous time. None where what is wrong with them
/// has been added to the errors.
pub(super) fn from_matrices(
    errors: &mut ErrorList<'_>,
    name: &str,
    [a, b, c, d]: [Vec<Vec<f64>>; 4],
    period_s: f64,
) -> Option<TaggedController> {
    let (n, file) = (a.len(), errors.file);
    if n > MOST_STATES {
        let rule = format!("A: has {n} rows; a controller has {MOST_STATES} states at most");
        errors.add(InputError::new(file, rule).with_hint("reduce the order first"));
        return None;
    }
    let a = matrix(errors, "A", &a, [n, n]);
    let b = matrix(errors, "B", &b, [n, CHANNELS.len()]);
    let c = matrix(errors, "C", &c, [CHANNELS.len(), n]);
    let d = matrix(errors, "D", &d, [CHANNELS.len(); 2]);
    if !(period_s.is_finite() && period_s >= 0.0) {
        let rule = format!("sample_time_s: {period_s} must be zero or a positive number");
        errors.add(InputError::new(file, rule).with_hint("0 means continuous time"));
        return None;
    }
    let (a, b, c, d) = (a?, b?, c?, d?);
    let law = if period_s == 0.0 {
        StateSpace::new(a, b, c, d, Continuous).map(ControlLaw::Continuous)
    } else {
        StateSpace::new(a, b, c, d, Discrete { period_s }).map(ControlLaw::Discrete)
    };
    let law = errors.take(law.map_err(|error| InputError::new(file, error.to_string())))?;
    Some(TaggedController { controller: Controller { name: name.to_owned(), law }, machine: None })
}

/// A matrix of the expected rows and columns, or none and an error for each row that is wrong.
fn matrix(
    errors: &mut ErrorList<'_>,
    key: &str,
    rows: &[Vec<f64>],
    [expected_rows, expected_columns]: [usize; 2],
) -> Option<Mat<f64>> {
    let hint = "A is n×n, B n×4, C 4×n, D 4×4, row by row";
    let mut wrong = vec![];
    if rows.len() != expected_rows {
        let rule = format!("{key}: has {} rows, must have {expected_rows}", rows.len());
        wrong.push(InputError::new(errors.file, rule).with_hint(hint));
    }
    for (i, row) in rows.iter().enumerate() {
        if row.len() != expected_columns {
            let rule = format!("{key}[{i}]: has {} columns, must have {expected_columns}", row.len());
            wrong.push(InputError::new(errors.file, rule).with_hint(hint));
        }
        if let Some(j) = row.iter().position(|x| !x.is_finite()) {
            wrong.push(InputError::new(errors.file, format!("{key}[{i}][{j}]: must be a number")));
        }
    }
    let is_right = wrong.is_empty();
    wrong.into_iter().for_each(|error| errors.add(error));
    is_right.then(|| Mat::from_fn(expected_rows, expected_columns, |i, j| rows[i][j]))
}
