//! `muspin check`.

use super::{Failure, Outcome};

/// Arguments of `muspin check`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("check: not available yet"))
}
