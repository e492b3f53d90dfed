//! `muspin batch`.

use super::{Failure, Outcome};

/// Arguments of `muspin batch`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("batch: not available yet"))
}
