//! Facts about matrices. The only home of dense algebra: everything above calls these plain `f64`/`c64` functions.

pub(crate) mod balance;
pub(crate) mod basis;
pub(crate) mod block_diagonal;
pub(crate) mod complex_eigenvalues;
pub(crate) mod dense;
pub(crate) mod doubled;
pub(crate) mod doubling;
pub(crate) mod equal_planes;
pub(crate) mod error;
pub mod exponential;
pub(crate) mod fixed;
pub(crate) mod francis;
pub(crate) mod fused;
pub(crate) mod gram;
pub(crate) mod gramian;
pub mod hermitian;
pub(crate) mod hessenberg;
pub(crate) mod lanes;
pub(crate) mod lapack;
pub(crate) mod largest_singular;
pub mod lyapunov;
pub(crate) mod pade;
pub(crate) mod planar;
pub(crate) mod polynomial;
pub(crate) mod real_eigenvalues;
pub mod regulator;
pub mod riccati;
pub mod schur;
pub(crate) mod simplex_search;
pub(crate) mod small;
pub(crate) mod svd;
pub(crate) mod symmetric;

pub use complex_eigenvalues::eigenvalues_complex;
pub use dense::{max_singular_value, max_singular_value_complex, solve, solve_complex, symmetric_eigen};
pub use error::NumericError;
pub use exponential::exponential;
pub use faer::{Mat, MatRef, c64};
pub use polynomial::polynomial_roots;
pub use real_eigenvalues::eigenvalues;
pub use svd::{Svd, svd};
pub use symmetric::{
    ComplexEigen, DefiniteEigen, definite_eigen, definite_eigen_lifted, eigen_vectors, eigen_vectors_complex,
};
