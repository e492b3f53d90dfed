//! Dense algebra.

mod eigenvalues;
mod polynomial;
mod schur;
mod solve_care;
