//! A number of a file that has to be positive.

use super::error::InputError;
use super::error_list::ErrorList;

/// Adds an error unless the number at `path` is positive or not there.
pub(super) fn positive(errors: &mut ErrorList<'_>, path: &str, value: Option<f64>) {
    if let Some(x) = value
        && !(x.is_finite() && x > 0.0)
    {
        let error = InputError::new(errors.file, format!("{path}: {x} must be a positive number"));
        errors.add_rule(error.with_hint("units stand in the key"));
    }
}
