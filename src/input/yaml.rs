//! YAML text to values: byte order marks, nesting, missing keys and impossible sizes are dealt with before anything
//! else.

use super::error::InputError;
use super::error_list::ErrorList;
use super::file::KEYS;
use super::keys::KeyGroup;
use super::list_limits::check_lists;
use super::plausible;
use super::structure::check_structure;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_yaml::Value;

/// Deepest nesting that is read: the deepest file format has five levels. The parser's time grows with the square of
/// it.
const DEEPEST: usize = 64;

/// A file of keys, checked against its table; none when what is wrong leaves no value. Unknown and missing keys, values
/// of another kind and impossible sizes are added to the errors of the file, all of them.
pub(super) fn read<T: DeserializeOwned + JsonSchema>(errors: &mut ErrorList<'_>, groups: &[KeyGroup]) -> Option<T> {
    let (file, text) = (errors.file, errors.text);
    errors.take(check_text(file, text))?;
    let (read, tree) = match serde_yaml::from_str(text) {
        Ok(read) => (Some(read), errors.take(value(file, text))?),
        Err(error) => {
            let tree = check_structure::<T>(errors);
            if errors.is_empty() {
                errors.add(InputError::yaml(file, &error));
            }
            let tree = tree?;
            (serde_yaml::from_value(tree.clone()).ok(), tree)
        }
    };
    errors.take(check_lists(file, &tree))?;
    plausible::refuse(errors, groups, &tree);
    if read.is_some() {
        plausible::refuse_negative(errors, groups, &tree);
    }
    read
}

/// A file as a tree of values.
///
/// # Errors
/// [`InputError`] with the line of what is no YAML.
pub fn value(file: &str, text: &str) -> Result<Value, InputError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    check_text(file, text)?;
    serde_yaml::from_str(text).map_err(|e| InputError::yaml(file, &e))
}

/// Refuses a text that is too large or nested too deeply.
fn check_text(file: &str, text: &str) -> Result<(), InputError> {
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
    Ok(())
}

fn too_deep(file: &str, line: usize) -> InputError {
    let mut error = InputError::new(file, format!("is nested more than {DEEPEST} levels deep"));
    error.line = Some(line);
    error.with_hint("close the brackets; the deepest file of muspin has five levels")
}
