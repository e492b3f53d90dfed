//! One message for whatever went wrong: what, where, and what to do.

use crate::input::quote::excerpt;
use std::fmt;

/// An error as the user reads it: `error: …`, and after a blank line `hint: …`.
#[derive(Debug)]
pub struct Failure {
    message: String,
    hint: Option<String>,
    /// What went wrong besides, each told like the first.
    further: Vec<Failure>,
}

impl Failure {
    /// A failure with its message.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None, further: vec![] }
    }

    /// The same failure with advice on the next step.
    pub(crate) fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The same failure with others behind it.
    pub(crate) fn with_further(mut self, others: impl IntoIterator<Item = Self>) -> Self {
        self.further.extend(others);
        self
    }

    /// The same failure; a message that names none of the files that the command was given is led by them.
    pub(crate) fn naming(mut self, files: &[String]) -> Self {
        let named = |file: &String| self.message.contains(file.as_str());
        // Messages about options and about output files name these first.
        let about_files = !self.message.starts_with(['-', '\'']);
        if about_files && !files.is_empty() && !files.iter().any(named) {
            self.message = format!("{}: {}", files.join(", "), self.message);
        }
        self
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "error: {}", excerpt(&self.message))?;
        if let Some(hint) = &self.hint {
            writeln!(f, "\nhint: {}", excerpt(hint))?;
        }
        self.further.iter().try_for_each(|failure| write!(f, "{failure}"))
    }
}

impl From<crate::input::InputError> for Failure {
    fn from(error: crate::input::InputError) -> Self {
        let mut failures =
            error.into_each().map(|error| Self { message: error.to_string(), hint: error.hint, further: vec![] });
        let first = failures.next().unwrap_or_else(|| Self::new("a file cannot be read"));
        Self { further: failures.collect(), ..first }
    }
}

impl From<crate::spindle::SpindleError> for Failure {
    fn from(error: crate::spindle::SpindleError) -> Self {
        Self::new(error.to_string()).with_hint("`muspin check` on the spindle and tool files shows more")
    }
}
