//! `muspin solve dksyn`.

use super::{Answer, Failure, Problem};

/// Solves the problem of the file.
pub fn solve(_problem: &Problem) -> Result<Answer, Failure> {
    Err(Failure::new("solve dksyn: not available yet"))
}
