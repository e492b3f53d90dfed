//! `muspin report`.

use super::{Failure, Outcome};

/// Arguments of `muspin report`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("report: not available yet"))
}
