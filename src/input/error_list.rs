//! All that is wrong with one file, by line.

use super::error::InputError;
use super::tree::key_line;

const MOST_TOLD: usize = 100;

/// Values that rules tie to others of the same mapping: while the second is wrong, nothing is said of the first.
const FOLLOWS_SIBLING: [(&str, &str); 6] = [
    ("inner_diameter_m", "outer_diameter_m"),
    ("mass_inner_diameter_m", "mass_outer_diameter_m"),
    ("polar_inertia_kg_m2", "diametral_inertia_kg_m2"),
    ("bias_current_a", "max_current_a"),
    ("delay_s", "sample_rate_hz"),
    ("to_hz", "from_hz"),
];
/// The same of values elsewhere in the file.
const FOLLOWS: [(&str, &str); 9] = [
    ("rotor.discs[].position_m", "rotor.elements[].length_m"),
    ("discs[].position_m", "elements[].length_m"),
    ("effects[].position_m", "rotor.elements[].length_m"),
    ("planes", "rotor.elements[].length_m"),
    ("planes.rear_sensor_m", "planes.front_sensor_m"),
    ("planes.rear_actuator_m", "planes.front_actuator_m"),
    ("tool_plane_m", "elements[].length_m"),
    ("backup_clearance_m", "bearings.front.gap_m"),
    ("backup_clearance_m", "bearings.rear.gap_m"),
];

/// Errors of one file in the order in which they are found.
pub(super) struct ErrorList<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
    errors: Vec<InputError>,
}

impl<'a> ErrorList<'a> {
    pub(super) fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, text: text.strip_prefix('\u{feff}').unwrap_or(text), errors: vec![] }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// Adds an error of this file or of one that it names.
    pub(super) fn add(&mut self, error: InputError) {
        self.errors.push(error);
    }

    /// Adds an error about the value of a key unless that key, or one that its rule goes back to, is wrong already.
    pub(super) fn add_rule(&mut self, error: InputError) {
        let path = error.key_path();
        let (parent, name) = path.rsplit_once('.').unwrap_or(("", path));
        let sibling =
            FOLLOWS_SIBLING.iter().find(|(what, _)| *what == name).map(|(_, cause)| format!("{parent}.{cause}"));
        let whole = without_numbers(path);
        let causes: Vec<&str> =
            FOLLOWS.iter().filter(|(what, _)| is_inside(&whole, what)).map(|(_, cause)| *cause).collect();
        let is_known = !path.is_empty()
            && self.errors.iter().map(InputError::key_path).any(|wrong| {
                wrong == path || sibling.as_deref() == Some(wrong) || causes.contains(&without_numbers(wrong).as_str())
            });
        if !is_known {
            self.add(error);
        }
    }

    /// The value, or none and its errors in the list.
    pub(super) fn take<T>(&mut self, result: Result<T, InputError>) -> Option<T> {
        result.map_err(|error| error.into_each().for_each(|e| self.add(e))).ok()
    }

    /// The value of a rule of the file, or none and its error in the list unless it follows from another.
    pub(super) fn take_rule<T>(&mut self, result: Result<T, InputError>) -> Option<T> {
        result.map_err(|error| error.into_each().for_each(|e| self.add_rule(e))).ok()
    }

    /// The value of a file that is right.
    pub(super) fn finish<T>(mut self, value: Option<T>) -> Result<T, InputError> {
        if self.errors.is_empty()
            && let Some(value) = value
        {
            return Ok(value);
        }
        let left_out = self.errors.len().saturating_sub(MOST_TOLD);
        self.errors.truncate(MOST_TOLD);
        for error in self.errors.iter_mut().filter(|e| e.line.is_none() && e.file == self.file) {
            error.line = key_line(self.text, error.key_path(), 0);
        }
        // Those without a line follow, then those of other files in the order in which they are named.
        let last = usize::MAX;
        self.errors
            .sort_by_key(|error| if error.file == self.file { (0, error.line.unwrap_or(last)) } else { (1, last) });
        if left_out > 0 {
            let words = format!("has {left_out} more errors");
            self.errors.push(InputError::new(self.file, words).with_hint("correct these first, then check again"));
        }
        let mut errors = self.errors.into_iter();
        let mut first = errors.next().unwrap_or_else(|| InputError::new(self.file, "cannot be read"));
        first.further.extend(errors);
        Err(first)
    }
}

/// True for a path and all paths below it.
fn is_inside(path: &str, parent: &str) -> bool {
    path.strip_prefix(parent).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

fn without_numbers(path: &str) -> String {
    path.split('[').map(|part| part.split_once(']').map_or(part.to_owned(), |(_, rest)| format!("[]{rest}"))).collect()
}
