//! The output folder of a command: claimed before anything is computed, so that a run of minutes is not refused at its
//! end.

use super::Failure;
use crate::report::results;
use std::path::Path;

/// Files that every command with a report writes.
pub(super) const REPORT: [&str; 2] = ["summary.json", "report.html"];

/// Checks that the folder may be written and that nothing which the command reads would be replaced.
pub(super) fn claim<'a>(out: &str, names: &[&str], inputs: impl IntoIterator<Item = &'a str>) -> Result<(), Failure> {
    let inputs: Vec<&str> = inputs.into_iter().collect();
    Ok(results::claim(Path::new(out), names, &inputs)?)
}
