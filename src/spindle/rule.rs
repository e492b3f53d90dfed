//! A rule that a number keeps, and its error.

use super::SpindleError;

/// Longest delay of the loop in sample periods. One and a half are usual; the sampled model has four states for each,
/// and no rotor on negative stiffness is held through twenty.
pub(super) const MOST_DELAY_SAMPLES: f64 = 20.0;

/// An error unless the value is positive.
pub(super) fn positive(path: &str, value: f64) -> Result<(), SpindleError> {
    rule(value > 0.0, path.into(), value, "must be a positive number")
}

/// An error unless the rule holds and the value is finite.
pub(super) fn rule(holds: bool, path: String, value: f64, text: &str) -> Result<(), SpindleError> {
    if holds && value.is_finite() {
        return Ok(());
    }
    Err(SpindleError::Value { path, value, rule: text.to_owned() })
}
