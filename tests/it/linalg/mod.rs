//! Dense algebra.

mod polynomial;
mod solve_care;
