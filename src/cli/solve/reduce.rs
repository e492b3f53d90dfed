//! `muspin solve reduce`.

use super::{Answer, Failure, Problem};

/// Solves the problem of the file.
pub fn solve(_problem: &Problem) -> Result<Answer, Failure> {
    Err(Failure::new("solve reduce: not available yet"))
}
