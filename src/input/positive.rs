//! A number of a file that has to be positive.

use super::error::InputError;

/// Refuses a number at `path` of `file` that is not positive; one that is not there is.
pub(super) fn positive(file: &str, path: &str, value: Option<f64>) -> Result<(), InputError> {
    match value {
        Some(x) if !(x.is_finite() && x > 0.0) => {
            let rule = format!("{path}: {x} must be a positive number");
            Err(InputError::new(file, rule).with_hint("units stand in the key"))
        }
        _ => Ok(()),
    }
}
