//! `muspin run`.

use super::{Failure, Outcome};

/// Arguments of `muspin run`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("run: not available yet"))
}
