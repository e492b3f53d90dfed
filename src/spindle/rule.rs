//! A rule that a number keeps, and its error.

use super::SpindleError;
use crate::rotor::{Disc, Rotor, RotorError, Section, check_lists};

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

/// Rules that are broken, in the order in which they are looked at.
#[derive(Default)]
pub(super) struct BrokenRules(Vec<SpindleError>);

impl BrokenRules {
    /// Adds a rule that is broken.
    pub(super) fn note(&mut self, checked: Result<(), SpindleError>) {
        self.0.extend(checked.err());
    }

    /// The shaft of two lists, or none and all rules that its parts break.
    pub(super) fn rotor(
        &mut self,
        sections: &[Section],
        discs: &[Disc],
        of: fn(RotorError) -> SpindleError,
    ) -> Option<Rotor> {
        if let Err(error) = check_lists(sections, discs) {
            self.0.push(of(error));
            return None;
        }
        match Rotor::new(0.0, sections.to_vec(), discs) {
            Ok(rotor) => Some(rotor),
            Err(first) => {
                let all = Rotor::broken_rules(sections, discs);
                let all = if all.is_empty() { vec![first] } else { all };
                self.0.extend(all.into_iter().map(of));
                None
            }
        }
    }

    pub(super) fn list(self) -> Vec<SpindleError> {
        self.0
    }
}
