//! Facts about matrices. The only home of dense algebra: everything above calls these plain `f64`/`c64` functions.

pub mod basis;
pub mod block_diagonal;
pub mod dense;
pub mod doubled;
pub mod doubling;
pub mod error;
pub mod exponential;
pub mod gramian;
pub mod hermitian;
pub mod lapack;
pub mod lyapunov;
pub mod planar;
pub mod riccati;
pub mod schur;
pub mod small;
pub mod svd;
pub mod symmetric;

pub use dense::{
    eigenvalues, eigenvalues_complex, max_singular_value, max_singular_value_complex, solve,
    solve_complex, symmetric_eigen,
};
pub use error::NumericError;
pub use exponential::exponential;
pub use faer::{Mat, MatRef, c64};
pub use svd::{Svd, svd};
pub use symmetric::{
    ComplexEigen, DefiniteEigen, definite_eigen, definite_eigen_lifted, eigen_vectors,
    eigen_vectors_complex,
};
