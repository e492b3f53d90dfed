//! The output folder of a command: claimed before anything is computed, so that a run of minutes is not refused at its
//! end.

use super::Failure;
use crate::report::results::{self, ResultsError};
use crate::report::whole::ReportError;
use std::path::Path;

/// Files that every command with a report writes.
pub(super) const REPORT: [&str; 2] = ["summary.json", "report.html"];

/// Checks that the folder may be written and that nothing which the command reads would be replaced.
///
/// # Errors
/// [`Failure`] with the file or folder that must not be touched.
pub(super) fn claim<'a>(out: &str, names: &[&str], inputs: impl IntoIterator<Item = &'a str>) -> Result<(), Failure> {
    let inputs: Vec<&str> = inputs.into_iter().collect();
    Ok(results::claim(Path::new(out), names, &inputs)?)
}

impl From<ResultsError> for Failure {
    fn from(error: ResultsError) -> Self {
        let hint = match &error {
            ResultsError::Foreign { .. } | ResultsError::Edited { .. } => {
                "muspin replaces only unchanged files that its muspin-manifest.json lists: move the file away, delete \
                 it, or choose another folder with --out"
            }
            ResultsError::Manifest { .. } => {
                "delete the manifest if the folder is yours, or choose another folder with --out"
            }
            _ => "choose another folder with --out",
        };
        Self::new(error.to_string()).with_hint(hint)
    }
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        match error {
            ReportError::Results(inner) => inner.into(),
            ReportError::Pipeline(inner) => inner.into(),
            ReportError::Machine(inner) => inner.into(),
            other => Self::new(other.to_string()),
        }
    }
}
