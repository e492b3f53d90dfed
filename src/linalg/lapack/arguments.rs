//! Arguments of Fortran calls as views and numbers.

use core::ffi::{c_char, c_int};
use core::mem::MaybeUninit;
use faer::dyn_stack::{MemStack, StackReq};
use faer::linalg::matmul::triangular::BlockStructure;
use faer::{Accum, MatMut, MatRef, Par};

pub(super) const PAR: Par = Par::Seq;
/// Bytes added to a workspace so that faer can align itself inside memory that a Fortran caller has allocated.
pub(super) const ALIGNMENT_SLACK: usize = 128;

pub(super) unsafe fn letter(c: *const c_char) -> u8 {
    unsafe { (*c as u8).to_ascii_uppercase() }
}

pub(super) unsafe fn size(n: *const c_int) -> usize {
    unsafe { usize::try_from(*n).unwrap_or(0) }
}

pub(super) unsafe fn view<'a>(p: *const f64, rows: usize, cols: usize, ld: usize) -> MatRef<'a, f64> {
    unsafe { MatRef::from_raw_parts(p, rows, cols, 1, ld as isize) }
}

pub(super) unsafe fn view_mut<'a>(p: *mut f64, rows: usize, cols: usize, ld: usize) -> MatMut<'a, f64> {
    unsafe { MatMut::from_raw_parts_mut(p, rows, cols, 1, ld as isize) }
}

pub(super) fn words(request: StackReq) -> usize {
    (request.unaligned_bytes_required() + ALIGNMENT_SLACK).div_ceil(8)
}

/// The caller's WORK array as faer's scratch memory: no allocation per call.
pub(super) unsafe fn workspace<'a>(work: *mut f64, words: usize) -> &'a mut MemStack {
    MemStack::new(unsafe { core::slice::from_raw_parts_mut(work.cast::<MaybeUninit<u8>>(), words * 8) })
}

/// C ← βC on the whole matrix or one triangle, and how the product is to be accumulated on it.
pub(super) fn prescale(mut c: MatMut<'_, f64>, beta: f64, triangle: Option<u8>) -> Accum {
    if beta == 0.0 {
        return Accum::Replace;
    }
    if beta != 1.0 {
        let n = c.nrows();
        for j in 0..c.ncols() {
            let rows = match triangle {
                None => 0..n,
                Some(b'U') => 0..j + 1,
                Some(_) => j..n,
            };
            for i in rows {
                c[(i, j)] *= beta;
            }
        }
    }
    Accum::Add
}

pub(super) fn triangle_of(uplo: u8) -> BlockStructure {
    if uplo == b'U' { BlockStructure::TriangularUpper } else { BlockStructure::TriangularLower }
}
