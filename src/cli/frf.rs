//! `muspin frf`.

use super::{Failure, Outcome};

/// Arguments of `muspin frf`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("frf: not available yet"))
}
