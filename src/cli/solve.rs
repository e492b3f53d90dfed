//! `muspin solve`.

use super::{Failure, Outcome};

/// Arguments of `muspin solve`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: &Arguments) -> Result<Outcome, Failure> {
    Err(Failure::new("solve: not available yet"))
}
