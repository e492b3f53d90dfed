//! `muspin update`.

use super::{Failure, Outcome};

/// Arguments of `muspin update`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("update: not available yet"))
}
