//! What is wrong with a file: file, line or key path, rule, hint. Unknown keys name the nearest known one.

use super::quote::{excerpt, printable};
use crate::spindle::SpindleError;
use thiserror::Error;

/// One message about one file. What it quotes of the file is shown cut and printable.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{}{}: {}", printable(.file), .line.map(|l| format!(":{l}")).unwrap_or_default(), excerpt(.message))]
pub struct InputError {
    /// The file, or the name of the shipped file.
    pub file: String,
    /// Line, from 1, where it is known.
    pub line: Option<usize>,
    /// What is wrong, key path included.
    pub message: String,
    /// The next step.
    pub hint: Option<String>,
    /// What else is wrong, by line.
    pub further: Vec<InputError>,
}

impl InputError {
    /// A message without a line.
    pub fn new(file: &str, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line: None, message: message.into(), hint: None, further: vec![] }
    }

    /// The key path that the message begins with; empty when it begins with none.
    pub(crate) fn key_path(&self) -> &str {
        let path = self.message.split_once(": ").map_or("", |(path, _)| path);
        // Rules of a shaft say whose it is.
        let path = path.strip_prefix("tool ").unwrap_or(path);
        if path.contains(' ') { "" } else { path }
    }

    /// This error and all further ones, each alone.
    pub(crate) fn into_each(mut self) -> impl Iterator<Item = Self> {
        let further = std::mem::take(&mut self.further);
        std::iter::once(self).chain(further)
    }

    /// The same message with the next step.
    pub(crate) fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// A rule of the domain that the file breaks.
    pub(crate) fn rule(file: &str, error: &SpindleError) -> Self {
        let hint = match error {
            SpindleError::Name { .. } => {
                "take one of the names listed, or complete the entry as the rule says".to_owned()
            }
            SpindleError::Numeric(_) => "look for extreme or inconsistent numbers in the file".to_owned(),
            _ => {
                let text = error.to_string();
                if text.contains("node") {
                    "a node lies at every end of an element: split an element there, or move the disc".to_owned()
                } else {
                    "correct the value; the file format gives units in the key".to_owned()
                }
            }
        };
        Self::new(file, error.to_string()).with_hint(hint)
    }

    /// An error of the YAML reader.
    pub(crate) fn yaml(file: &str, error: &serde_yaml::Error) -> Self {
        let line = error.location().map(|l| l.line());
        Self::of_parser(file, line, &error.to_string())
    }

    /// An error of the JSON reader.
    pub(crate) fn json(file: &str, error: &serde_json::Error) -> Self {
        // An error about the whole text has line 0.
        Self::of_parser(file, Some(error.line()).filter(|line| *line > 0), &error.to_string())
    }

    /// An error in the words of a parser.
    pub(super) fn of_parser(file: &str, line: Option<usize>, text: &str) -> Self {
        // The position stands in front of the message already.
        let text = text.split(" at line ").next().unwrap_or(text);
        let quoted: Vec<&str> = text.split('`').skip(1).step_by(2).collect();
        let hint = if text.contains("unknown field") {
            match quoted.split_first() {
                Some((unknown, known)) => nearest_key(unknown, known.iter().copied())
                    .map_or("remove the key".to_owned(), |best| format!("did you mean `{best}`?")),
                None => "remove the key".to_owned(),
            }
        } else if text.contains("missing field") {
            "add the key; spindles/reference.yaml shows a complete file".to_owned()
        } else if text.starts_with("more than") {
            "leave out what is not needed, and reduce the order of large systems first".to_owned()
        } else if text.contains("duplicate") {
            "keep one of the two".to_owned()
        } else if text.contains("invalid type") || text.contains("invalid value") {
            "numbers are written plainly, without units or quotes; units stand in the key".to_owned()
        } else {
            "check indentation, brackets and colons at this line".to_owned()
        };
        Self { file: file.to_owned(), line, message: plain_words(text), hint: Some(hint), further: vec![] }
    }
}

/// The parser's names of types in words of the file.
fn plain_words(text: &str) -> String {
    let mut text = text.to_owned();
    for (name, words) in [
        ("expected f64", "expected a number"),
        ("expected usize", "expected a whole number, zero or more"),
        ("expected a sequence", "expected a list"),
        ("expected a map", "expected a mapping of keys to values"),
    ] {
        // The parser's own words may already be those of the file.
        if !text.contains(words) {
            text = text.replace(name, words);
        }
    }
    match text.split_once("expected struct ") {
        Some((before, _)) => format!("{before}expected a mapping of keys to values"),
        None => text,
    }
}

/// The known name with the smallest edit distance, if any is known.
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // The distance takes the product of the lengths; what is this long is no misspelt key.
    const LONGEST: usize = 100;
    let beginning = name.char_indices().nth(LONGEST).map_or(name, |(end, _)| &name[..end]);
    known.min_by_key(|k| strsim::damerau_levenshtein(beginning, k))
}

/// The known key that is meant by another: the shortest one that goes on with a unit or more words, else the one with
/// the smallest edit distance.
pub fn nearest_key<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let known: Vec<&str> = known.collect();
    let beginning = name.to_lowercase();
    let goes_on = |key: &&&str| key.strip_prefix(beginning.as_str()).is_some_and(|rest| rest.starts_with('_'));
    let longer = known.iter().filter(goes_on).min_by_key(|key| key.len());
    longer.copied().or_else(|| nearest(&beginning, known.into_iter()))
}

/// True for a key that goes on with a unit or more words behind the name, or differs from it in a third of the letters
/// at most: it is taken for the one that was meant.
pub(super) fn is_meant(name: &str, key: &str) -> bool {
    let goes_on = key.strip_prefix(&name.to_lowercase()).is_some_and(|rest| rest.starts_with('_'));
    // The distance takes the product of the lengths; no key has this many bytes.
    goes_on || name.len() <= 100 && 3 * strsim::damerau_levenshtein(name, key) <= name.chars().count()
}
