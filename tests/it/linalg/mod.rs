//! Dense algebra.

mod complex_eigenvalues;
mod polynomial;
mod solve_care;
