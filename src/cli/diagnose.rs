//! `muspin diagnose`.

use super::{Failure, Outcome};

/// Arguments of `muspin diagnose`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("diagnose: not available yet"))
}
