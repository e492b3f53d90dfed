//! Dense algebra.

mod eigenvalues;
mod polynomial;
mod solve_care;
