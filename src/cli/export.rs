//! `muspin export`.

use super::{Failure, Outcome};

/// Arguments of `muspin export`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("export: not available yet"))
}
