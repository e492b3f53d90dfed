//! The values of a file against the table of its keys: what is missing, what cannot be, and what looks like another
//! unit.

use super::error::InputError;
use super::error_list::ErrorList;
use super::keys::{Key, KeyGroup, other_units};
use super::positive::positive;
use super::quote::{excerpt, printable};
use serde_yaml::Value;

/// A value that is read and used, and looks wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// The file.
    pub file: String,
    /// Key path, value, and what is odd about it.
    pub message: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "warning: {}: {}", printable(&self.file), excerpt(&self.message))
    }
}

/// Adds every value whose size cannot be to the errors of a file.
pub(super) fn refuse(errors: &mut ErrorList<'_>, groups: &[KeyGroup], value: &Value) {
    each_number(groups, value, &mut |path, key, size| {
        let [low, high] = key.possible;
        if !size.is_nan() && !(low..=high).contains(&size.abs()) {
            errors.add(outside(errors.file, path, key, size));
        }
    });
}

/// Adds an error for every number that has to be positive and is not.
pub(super) fn refuse_negative(errors: &mut ErrorList<'_>, groups: &[KeyGroup], value: &Value) {
    each_number(groups, value, &mut |path, key, x| {
        if key.is_positive {
            positive(errors, path, Some(x));
        }
    });
}

fn outside(file: &str, path: &str, key: &Key, size: f64) -> InputError {
    let [low, high] = key.possible;
    // A rule of sign or finiteness reads the same for every key.
    let rule = match size {
        x if !x.is_finite() => "must be a finite number".to_owned(),
        x if x <= 0.0 => "must be a positive number".to_owned(),
        _ => format!("must lie between {} and {}{}: {}", short(low), short(high), unit(key), key.reason),
    };
    let told = InputError::new(file, format!("{path}: {size} {rule}"));
    match looks_like(key, size) {
        Some(words) => told.with_hint(words),
        None => told.with_hint("correct the value; the file format gives units in the key"),
    }
}

/// Values outside the plausible range of their key.
pub fn warnings(file: &str, groups: &[KeyGroup], value: &Value) -> Vec<Warning> {
    let mut found = vec![];
    each_number(groups, value, &mut |path, key, size| {
        let [low, high] = key.plausible;
        if size == 0.0 || (low..=high).contains(&size.abs()) {
            return;
        }
        let guess = looks_like(key, size).map_or(String::new(), |words| format!("; {words}"));
        let message = format!(
            "{path}: {size} lies outside {} to {}{} ({}){guess}",
            short(low),
            short(high),
            unit(key),
            key.reason
        );
        found.push(Warning { file: file.to_owned(), message });
    });
    found
}

/// A number as people write it: six digits, powers of ten for small and large ones.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    match rounded.abs() {
        0.0 => "0".to_owned(),
        size if (0.01..1e4).contains(&size) => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

fn unit(key: &Key) -> String {
    match key.unit {
        "" => String::new(),
        unit => format!(" {unit}"),
    }
}

/// The unit in which the number would be plausible.
fn looks_like(key: &Key, size: f64) -> Option<String> {
    let [low, high] = key.plausible;
    let fits = |factor: f64| (low..=high).contains(&(size.abs() * factor));
    let (name, factor) = other_units(key.unit).iter().find(|(_, factor)| fits(*factor))?;
    let right = short(size * factor);
    Some(match key.unit {
        "" => format!("{size} looks like {name}: write {right}"),
        unit => format!("{size} looks like {name}: write {right} for {unit}"),
    })
}

/// Calls back for every number of the file that the table knows: path, key, value.
fn each_number(groups: &[KeyGroup], file: &Value, see: &mut dyn FnMut(&str, &Key, f64)) {
    for group in groups {
        for (path, holder) in holders(file, group.at) {
            for key in group.keys {
                let name = key.name.trim_end_matches("[]");
                let path = join(&path, name);
                match holder.get(name) {
                    Some(Value::Sequence(list)) => {
                        for (k, entry) in list.iter().enumerate() {
                            if let Some(x) = entry.as_f64() {
                                see(&format!("{path}[{k}]"), key, x);
                            }
                        }
                    }
                    Some(value) => {
                        if let Some(x) = value.as_f64() {
                            see(&path, key, x);
                        }
                    }
                    None => {}
                }
            }
        }
    }
}

fn join(path: &str, name: &str) -> String {
    match path {
        "" => name.to_owned(),
        path => format!("{path}.{name}"),
    }
}

/// Mappings at a path, each with its own path.
fn holders<'a>(file: &'a Value, at: &str) -> Vec<(String, &'a Value)> {
    let mut open = vec![(String::new(), file)];
    for part in at.split('.').filter(|part| !part.is_empty()) {
        let mut next = vec![];
        for (path, value) in open {
            if part == "*" {
                for (name, entry) in value.as_mapping().into_iter().flatten() {
                    next.push((join(&path, name.as_str().unwrap_or("?")), entry));
                }
                continue;
            }
            let name = part.trim_end_matches("[]");
            let path = join(&path, name);
            match value.get(name) {
                None => {}
                Some(Value::Sequence(list)) if part.ends_with("[]") => {
                    let entries = list.iter().enumerate();
                    next.extend(entries.map(|(k, entry)| (format!("{path}[{k}]"), entry)));
                }
                Some(value) => next.push((path, value)),
            }
        }
        open = next;
    }
    // What is no mapping is the reader's to refuse.
    open.retain(|(_, value)| value.is_mapping() || value.is_null());
    open
}
