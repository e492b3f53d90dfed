//! `muspin modes`.

use super::{Failure, Outcome};

/// Arguments of `muspin modes`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("modes: not available yet"))
}
