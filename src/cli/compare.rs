//! `muspin compare`.

use super::{Failure, Outcome};

/// Arguments of `muspin compare`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("compare: not available yet"))
}
