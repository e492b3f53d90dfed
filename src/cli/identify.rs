//! `muspin identify`.

use super::{Failure, Outcome};

/// Arguments of `muspin identify`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("identify: not available yet"))
}
