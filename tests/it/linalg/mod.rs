//! Dense algebra.

mod solve_care;
