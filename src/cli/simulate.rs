//! `muspin simulate`.

use super::{Failure, Outcome};

/// Arguments of `muspin simulate`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("simulate: not available yet"))
}
