//! YAML text to values: byte order marks, nesting, missing keys and impossible sizes are dealt with before anything
//! else.

use super::error::InputError;
use super::file::KEYS;
use super::keys::Group;
use super::list_limits::check_lists;
use super::plausible;
use serde::de::DeserializeOwned;
use serde_yaml::Value;

/// Deepest nesting that is read: the deepest file format has five levels. The parser's time grows with the square of
/// it.
const DEEPEST: usize = 64;

/// A file of keys, checked against its table.
///
/// # Errors
/// [`InputError`]: the line of what is no YAML or has an unknown key, all missing keys at once, or the first impossible
/// size.
pub fn read<T: DeserializeOwned>(file: &str, text: &str, groups: &[Group]) -> Result<T, InputError> {
    let text = checked(file, text)?;
    let read: T = serde_yaml::from_str(text).map_err(|error| {
        let told = InputError::yaml(file, &error);
        match value(file, text) {
            Ok(value) if told.message.contains("missing field") => {
                told.with_missing(&plausible::missing(groups, &value))
            }
            _ => told,
        }
    })?;
    let value = value(file, text)?;
    check_lists(file, &value)?;
    plausible::refuse(file, groups, &value)?;
    Ok(read)
}

/// A file as a tree of values.
///
/// # Errors
/// [`InputError`] with the line of what is no YAML.
pub fn value(file: &str, text: &str) -> Result<Value, InputError> {
    serde_yaml::from_str(checked(file, text)?).map_err(|e| InputError::yaml(file, &e))
}

/// The text without a byte order mark; refused when it is too large or nested too deeply.
fn checked<'a>(file: &str, text: &'a str) -> Result<&'a str, InputError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    KEYS.admit(text.len()).map_err(|error| error.of(file))?;
    let mut depth = 0usize;
    for (k, line) in text.lines().enumerate() {
        // Brackets in quotes and comments count as well: no name needs this many.
        let mut opened = depth;
        for byte in line.bytes() {
            match byte {
                b'[' | b'{' => opened += 1,
                b']' | b'}' => opened = opened.saturating_sub(1),
                _ => {}
            }
            depth = opened;
            if opened > DEEPEST {
                return Err(too_deep(file, k + 1));
            }
        }
        let marks = line.trim_start().split(' ').take_while(|w| matches!(*w, "-" | "?" | ":" | ""));
        let indent = line.len() - line.trim_start().len();
        if marks.filter(|w| !w.is_empty()).count() > DEEPEST || indent > 8 * DEEPEST {
            return Err(too_deep(file, k + 1));
        }
    }
    Ok(text)
}

fn too_deep(file: &str, line: usize) -> InputError {
    let mut error = InputError::new(file, format!("is nested more than {DEEPEST} levels deep"));
    error.line = Some(line);
    error.with_hint("close the brackets; the deepest file of muspin has five levels")
}
