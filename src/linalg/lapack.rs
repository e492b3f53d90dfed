//! The BLAS and LAPACK routines that clarabel's semidefinite cone calls, answered by faer.
//!
//! clarabel's features `blas-src` and `lapack-src` leave eleven double-precision Fortran symbols open and expect a system
//! library to close them. They are closed here instead, so that cargo alone builds the program on any machine.
//! Interface: LP64 (32-bit integers), column-major, every argument by pointer, trailing underscore; the comments of the
//! reference implementation at netlib.org describe the arguments. Single-precision twins are never linked.
//!
//! Limits: `dsyevr_` answers range `A` only, `dgesvd_` needs `jobu = jobvt`; both report an invalid argument otherwise.
//! This is the only file of the crate with `unsafe`: raw pointers come from clarabel, which owns the buffers.
#![allow(
    unsafe_code,
    clippy::missing_safety_doc,
    clippy::too_many_arguments,
    missing_docs
)]

use core::ffi::{c_char, c_int};
use core::mem::MaybeUninit;
use faer::diag::DiagMut;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt;
use faer::linalg::evd::{self, ComputeEigenvectors};
use faer::linalg::matmul::{
    matmul,
    triangular::{self, BlockStructure},
};
use faer::linalg::solvers::Solve;
use faer::linalg::svd::{self, ComputeSvdVectors};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, MatMut, MatRef, Par, Spec};

const PAR: Par = Par::Seq;
/// Bytes added to a workspace so that faer can align itself inside memory that a Fortran caller has allocated.
const ALIGNMENT_SLACK: usize = 128;

/// Pulls this object file into the link whatever the order of the archives; call it before using clarabel.
#[inline(never)]
pub fn link() -> usize {
    core::hint::black_box(dgemm_ as *const () as usize)
}

unsafe fn letter(c: *const c_char) -> u8 {
    unsafe { (*c as u8).to_ascii_uppercase() }
}

unsafe fn size(n: *const c_int) -> usize {
    unsafe { usize::try_from(*n).unwrap_or(0) }
}

unsafe fn view<'a>(p: *const f64, rows: usize, cols: usize, ld: usize) -> MatRef<'a, f64> {
    unsafe { MatRef::from_raw_parts(p, rows, cols, 1, ld as isize) }
}

unsafe fn view_mut<'a>(p: *mut f64, rows: usize, cols: usize, ld: usize) -> MatMut<'a, f64> {
    unsafe { MatMut::from_raw_parts_mut(p, rows, cols, 1, ld as isize) }
}

fn words(request: StackReq) -> usize {
    (request.unaligned_bytes_required() + ALIGNMENT_SLACK).div_ceil(8)
}

/// The caller's WORK array as faer's scratch memory: no allocation per call.
unsafe fn workspace<'a>(work: *mut f64, words: usize) -> &'a mut MemStack {
    MemStack::new(unsafe {
        core::slice::from_raw_parts_mut(work.cast::<MaybeUninit<u8>>(), words * 8)
    })
}

/// C ← βC on the whole matrix or one triangle, and how the product is to be accumulated on it.
fn prescale(mut c: MatMut<'_, f64>, beta: f64, triangle: Option<u8>) -> Accum {
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

fn triangle_of(uplo: u8) -> BlockStructure {
    if uplo == b'U' {
        BlockStructure::TriangularUpper
    } else {
        BlockStructure::TriangularLower
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgemm_(
    transa: *const c_char,
    transb: *const c_char,
    m: *const c_int,
    n: *const c_int,
    k: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    b: *const f64,
    ldb: *const c_int,
    beta: *const f64,
    c: *mut f64,
    ldc: *const c_int,
) {
    unsafe {
        let (m, n, k) = (size(m), size(n), size(k));
        let a = match letter(transa) {
            b'N' => view(a, m, k, size(lda)),
            _ => view(a, k, m, size(lda)).transpose(),
        };
        let b = match letter(transb) {
            b'N' => view(b, k, n, size(ldb)),
            _ => view(b, n, k, size(ldb)).transpose(),
        };
        let mut c = view_mut(c, m, n, size(ldc));
        let accumulate = prescale(c.as_mut(), *beta, None);
        matmul(c, accumulate, a, b, *alpha, PAR);
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dsyrk_(
    uplo: *const c_char,
    trans: *const c_char,
    n: *const c_int,
    k: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    beta: *const f64,
    c: *mut f64,
    ldc: *const c_int,
) {
    unsafe {
        let (n, k) = (size(n), size(k));
        let a = match letter(trans) {
            b'N' => view(a, n, k, size(lda)),
            _ => view(a, k, n, size(lda)).transpose(),
        };
        let part = triangle_of(letter(uplo));
        let mut c = view_mut(c, n, n, size(ldc));
        let accumulate = prescale(c.as_mut(), *beta, Some(letter(uplo)));
        let full = BlockStructure::Rectangular;
        triangular::matmul(
            c,
            part,
            accumulate,
            a,
            full,
            a.transpose(),
            full,
            *alpha,
            PAR,
        );
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dsyr2k_(
    uplo: *const c_char,
    trans: *const c_char,
    n: *const c_int,
    k: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    b: *const f64,
    ldb: *const c_int,
    beta: *const f64,
    c: *mut f64,
    ldc: *const c_int,
) {
    unsafe {
        let (n, k) = (size(n), size(k));
        let oriented = |p, ld| match letter(trans) {
            b'N' => view(p, n, k, size(ld)),
            _ => view(p, k, n, size(ld)).transpose(),
        };
        let (a, b) = (oriented(a, lda), oriented(b, ldb));
        let part = triangle_of(letter(uplo));
        let mut c = view_mut(c, n, n, size(ldc));
        let first = prescale(c.as_mut(), *beta, Some(letter(uplo)));
        let full = BlockStructure::Rectangular;
        for (x, y, accumulate) in [(a, b, first), (b, a, Accum::Add)] {
            triangular::matmul(
                c.as_mut(),
                part,
                accumulate,
                x,
                full,
                y.transpose(),
                full,
                *alpha,
                PAR,
            );
        }
    }
}

/// y ← αAx + βy with strides; `entry` reads A (a triangle of it for the symmetric case).
unsafe fn matrix_vector(
    shape: (usize, usize),
    alpha: f64,
    entry: impl Fn(usize, usize) -> f64,
    (x, incx): (*const f64, isize),
    beta: f64,
    (y, incy): (*mut f64, isize),
) {
    let (m, n) = shape;
    let start = |stride: isize, len: usize| {
        if stride < 0 {
            (1 - len as isize) * stride
        } else {
            0
        }
    };
    let (x0, y0) = (start(incx, n), start(incy, m));
    for i in 0..m {
        unsafe {
            let sum: f64 = (0..n)
                .map(|j| entry(i, j) * *x.offset(x0 + j as isize * incx))
                .sum();
            let target = y.offset(y0 + i as isize * incy);
            let old = if beta == 0.0 { 0.0 } else { beta * *target };
            *target = alpha * sum + old;
        }
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgemv_(
    trans: *const c_char,
    m: *const c_int,
    n: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    x: *const f64,
    incx: *const c_int,
    beta: *const f64,
    y: *mut f64,
    incy: *const c_int,
) {
    unsafe {
        let stored = view(a, size(m), size(n), size(lda));
        let a = match letter(trans) {
            b'N' => stored,
            _ => stored.transpose(),
        };
        let (x, y) = ((x, *incx as isize), (y, *incy as isize));
        let shape = (a.nrows(), a.ncols());
        matrix_vector(shape, *alpha, |i, j| a[(i, j)], x, *beta, y);
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dsymv_(
    uplo: *const c_char,
    n: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    x: *const f64,
    incx: *const c_int,
    beta: *const f64,
    y: *mut f64,
    incy: *const c_int,
) {
    unsafe {
        let n = size(n);
        let upper = letter(uplo) == b'U';
        let a = view(a, n, n, size(lda));
        let entry = |i: usize, j: usize| {
            if i == j || (i < j) == upper {
                a[(i, j)]
            } else {
                a[(j, i)]
            }
        };
        let (x, y) = ((x, *incx as isize), (y, *incy as isize));
        matrix_vector((n, n), *alpha, entry, x, *beta, y);
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpotrf_(
    uplo: *const c_char,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    info: *mut c_int,
) {
    unsafe {
        let n = size(n);
        *info = 0;
        if n == 0 {
            return;
        }
        // UᵀU of the upper triangle is LLᵀ of the transposed view.
        let mut a = view_mut(a, n, n, size(lda));
        if letter(uplo) == b'U' {
            a = a.transpose_mut();
        }
        // faer's kernel writes the other triangle too, which the caller reads: factor a copy.
        let mut factor =
            faer::Mat::<f64>::from_fn(n, n, |i, j| if i >= j { a[(i, j)] } else { 0.0 });
        let params = Spec::new(<llt::factor::LltParams as faer::Auto<f64>>::auto());
        let scratch = llt::factor::cholesky_in_place_scratch::<f64>(n, PAR, params);
        let result = llt::factor::cholesky_in_place(
            factor.as_mut(),
            Default::default(),
            PAR,
            MemStack::new(&mut MemBuffer::new(scratch)),
            params,
        );
        for j in 0..n {
            for i in j..n {
                a[(i, j)] = factor[(i, j)];
            }
        }
        if let Err(llt::factor::LltError::NonPositivePivot { index }) = result {
            *info = index as c_int + 1;
        }
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpotrs_(
    uplo: *const c_char,
    n: *const c_int,
    nrhs: *const c_int,
    a: *const f64,
    lda: *const c_int,
    b: *mut f64,
    ldb: *const c_int,
    info: *mut c_int,
) {
    unsafe {
        *info = 0;
        let a = view(a, size(n), size(n), size(lda));
        let l = if letter(uplo) == b'U' {
            a.transpose()
        } else {
            a
        };
        let mut b = view_mut(b, size(n), size(nrhs), size(ldb));
        solve_lower_triangular_in_place(l, b.as_mut(), PAR);
        solve_upper_triangular_in_place(l.transpose(), b, PAR);
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgesv_(
    n: *const c_int,
    nrhs: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    ipiv: *mut c_int,
    b: *mut f64,
    ldb: *const c_int,
    info: *mut c_int,
) {
    unsafe {
        let n = size(n);
        *info = 0;
        let lu = view(a, n, n, size(lda)).partial_piv_lu();
        let u = lu.U();
        for i in 0..n {
            // clarabel reads the solution only; the pivots are written as the identity.
            *ipiv.add(i) = i as c_int + 1;
            if *info == 0 && u[(i, i)] == 0.0 {
                *info = i as c_int + 1;
            }
        }
        if *info == 0 {
            lu.solve_in_place(view_mut(b, n, size(nrhs), size(ldb)));
        }
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dsyevr_(
    jobz: *const c_char,
    range: *const c_char,
    uplo: *const c_char,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    _vl: *const f64,
    _vu: *const f64,
    _il: *const c_int,
    _iu: *const c_int,
    _abstol: *const f64,
    m: *mut c_int,
    w: *mut f64,
    z: *mut f64,
    ldz: *const c_int,
    _isuppz: *mut c_int,
    work: *mut f64,
    lwork: *const c_int,
    iwork: *mut c_int,
    liwork: *const c_int,
    info: *mut c_int,
) {
    unsafe {
        let n = size(n);
        *info = 0;
        if letter(range) != b'A' {
            *info = -2;
            return;
        }
        let (wanted, vectors) = match letter(jobz) {
            b'V' => (ComputeEigenvectors::Yes, true),
            _ => (ComputeEigenvectors::No, false),
        };
        let params = Spec::new(<evd::SelfAdjointEvdParams as faer::Auto<f64>>::auto());
        if *lwork == -1 || *liwork == -1 {
            *work = words(evd::self_adjoint_evd_scratch::<f64>(n, wanted, PAR, params)) as f64;
            *iwork = 1;
            return;
        }
        *m = n as c_int;
        // faer reads the lower triangle.
        let stored = view(a, n, n, size(lda));
        let a = if letter(uplo) == b'U' {
            stored.transpose()
        } else {
            stored
        };
        let values = DiagMut::from_slice_mut(core::slice::from_raw_parts_mut(w, n));
        let u = vectors.then(|| view_mut(z, n, n, size(ldz)));
        let stack = workspace(work, size(lwork));
        if evd::self_adjoint_evd(a, values, u, PAR, stack, params).is_err() {
            *info = 1;
        }
    }
}

/// Singular value decomposition for both LAPACK entry points; `job` is `S`, `A` or `N` for both sides.
unsafe fn decompose(
    job: u8,
    (m, n): (usize, usize),
    (a, lda): (*const f64, usize),
    s: *mut f64,
    (u, ldu): (*mut f64, usize),
    (vt, ldvt): (*mut f64, usize),
    (work, lwork): (*mut f64, c_int),
    info: *mut c_int,
) {
    unsafe {
        *info = 0;
        let k = m.min(n);
        let (wanted, left, right) = match job {
            b'S' => (ComputeSvdVectors::Thin, k, k),
            b'A' => (ComputeSvdVectors::Full, m, n),
            b'N' => (ComputeSvdVectors::No, 0, 0),
            _ => {
                *info = -1;
                return;
            }
        };
        let params = Spec::new(<svd::SvdParams as faer::Auto<f64>>::auto());
        if lwork == -1 {
            *work = words(svd::svd_scratch::<f64>(m, n, wanted, wanted, PAR, params)) as f64;
            return;
        }
        let values = DiagMut::from_slice_mut(core::slice::from_raw_parts_mut(s, k));
        let (u, v) = if job == b'N' {
            (None, None)
        } else {
            let v = view_mut(vt, right, n, ldvt).transpose_mut();
            (Some(view_mut(u, m, left, ldu)), Some(v))
        };
        let stack = workspace(work, usize::try_from(lwork).unwrap_or(0));
        if svd::svd(view(a, m, n, lda), values, u, v, PAR, stack, params).is_err() {
            *info = 1;
        }
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgesdd_(
    jobz: *const c_char,
    m: *const c_int,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    s: *mut f64,
    u: *mut f64,
    ldu: *const c_int,
    vt: *mut f64,
    ldvt: *const c_int,
    work: *mut f64,
    lwork: *const c_int,
    _iwork: *mut c_int,
    info: *mut c_int,
) {
    unsafe {
        decompose(
            letter(jobz),
            (size(m), size(n)),
            (a, size(lda)),
            s,
            (u, size(ldu)),
            (vt, size(ldvt)),
            (work, *lwork),
            info,
        );
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dgesvd_(
    jobu: *const c_char,
    jobvt: *const c_char,
    m: *const c_int,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    s: *mut f64,
    u: *mut f64,
    ldu: *const c_int,
    vt: *mut f64,
    ldvt: *const c_int,
    work: *mut f64,
    lwork: *const c_int,
    info: *mut c_int,
) {
    unsafe {
        if letter(jobu) != letter(jobvt) {
            *info = -2;
            return;
        }
        decompose(
            letter(jobu),
            (size(m), size(n)),
            (a, size(lda)),
            s,
            (u, size(ldu)),
            (vt, size(ldvt)),
            (work, *lwork),
            info,
        );
    }
}
