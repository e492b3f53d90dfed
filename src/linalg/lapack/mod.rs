//! The BLAS and LAPACK routines that clarabel's semidefinite cone calls, answered by faer.
//!
//! clarabel's features `blas-src` and `lapack-src` leave eleven double-precision Fortran symbols open and expect a
//! system library to close them. They are closed here instead, so that cargo alone builds the program on any machine.
//! Interface: LP64 (32-bit integers), column-major, every argument by pointer, trailing underscore; the comments of the
//! reference implementation at netlib.org describe the arguments. Single-precision twins are never linked.
//!
//! Limits: `dsyevr_` answers range `A` only, `dgesvd_` needs `jobu = jobvt`; both report an invalid argument otherwise.
//! This is the only folder of the crate with `unsafe`: raw pointers come from clarabel, which owns the buffers.
#![allow(unsafe_code, clippy::missing_safety_doc, clippy::too_many_arguments, missing_docs)]

mod arguments;
pub(crate) mod blas;
pub(crate) mod factorisations;

/// Pulls this object file into the link whatever the order of the archives; call it before using clarabel.
#[inline(never)]
pub(crate) fn link() -> usize {
    core::hint::black_box(blas::dgemm_ as *const () as usize)
}
