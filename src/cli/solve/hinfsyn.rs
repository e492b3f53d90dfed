//! `muspin solve hinfsyn`.

use super::{Answer, Failure, Problem};

/// Solves the problem of the file.
pub fn solve(_problem: &Problem) -> Result<Answer, Failure> {
    Err(Failure::new("solve hinfsyn: not available yet"))
}
