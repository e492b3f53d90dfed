//! `muspin design`.

use super::{Failure, Outcome};

/// Arguments of `muspin design`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("design: not available yet"))
}
