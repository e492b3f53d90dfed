//! LAPACK: factorisations, eigenvalues, singular values.

use super::arguments::*;
use core::ffi::{c_char, c_int};
use faer::Spec;
use faer::diag::DiagMut;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::evd::{self, ComputeEigenvectors};
use faer::linalg::solvers::Solve;
use faer::linalg::svd::{self, ComputeSvdVectors};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};

#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn dpotrf_(
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
        let mut factor = faer::Mat::<f64>::from_fn(n, n, |i, j| if i >= j { a[(i, j)] } else { 0.0 });
        let params = Spec::new(<llt::factor::LltParams as faer::Auto<f64>>::auto());
        let scratch = llt::factor::cholesky_in_place_scratch::<f64>(n, PAR, params);
        let result = llt::factor::cholesky_in_place(
            factor.as_mut(),
            llt::factor::LltRegularization::default(),
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
pub(crate) unsafe extern "C" fn dpotrs_(
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
        let l = if letter(uplo) == b'U' { a.transpose() } else { a };
        let mut b = view_mut(b, size(n), size(nrhs), size(ldb));
        solve_lower_triangular_in_place(l, b.as_mut(), PAR);
        solve_upper_triangular_in_place(l.transpose(), b, PAR);
    }
}

#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn dgesv_(
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
pub(crate) unsafe extern "C" fn dsyevr_(
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
        let a = if letter(uplo) == b'U' { stored.transpose() } else { stored };
        let values = DiagMut::from_slice_mut(core::slice::from_raw_parts_mut(w, n));
        let u = vectors.then(|| view_mut(z, n, n, size(ldz)));
        let stack = workspace(work, size(lwork));
        if evd::self_adjoint_evd(a, values, u, PAR, stack, params).is_err() {
            *info = 1;
        }
    }
}

/// A matrix of a LAPACK caller and its leading dimension.
type Columns<T> = (T, usize);

/// Singular value decomposition for both LAPACK entry points; `job` is `S`, `A` or `N` for both sides; the answer is
/// LAPACK's `info`.
unsafe fn decompose(
    job: u8,
    (m, n): (usize, usize),
    (a, lda): Columns<*const f64>,
    s: *mut f64,
    [(u, ldu), (vt, ldvt)]: [Columns<*mut f64>; 2],
    (work, lwork): (*mut f64, c_int),
) -> c_int {
    unsafe {
        let k = m.min(n);
        let (wanted, left, right) = match job {
            b'S' => (ComputeSvdVectors::Thin, k, k),
            b'A' => (ComputeSvdVectors::Full, m, n),
            b'N' => (ComputeSvdVectors::No, 0, 0),
            _ => return -1,
        };
        let params = Spec::new(<svd::SvdParams as faer::Auto<f64>>::auto());
        if lwork == -1 {
            *work = words(svd::svd_scratch::<f64>(m, n, wanted, wanted, PAR, params)) as f64;
            return 0;
        }
        let values = DiagMut::from_slice_mut(core::slice::from_raw_parts_mut(s, k));
        let (u, v) = if job == b'N' {
            (None, None)
        } else {
            let v = view_mut(vt, right, n, ldvt).transpose_mut();
            (Some(view_mut(u, m, left, ldu)), Some(v))
        };
        let stack = workspace(work, usize::try_from(lwork).unwrap_or(0));
        let found = svd::svd(view(a, m, n, lda), values, u, v, PAR, stack, params);
        c_int::from(found.is_err())
    }
}

#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn dgesdd_(
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
        *info = decompose(
            letter(jobz),
            (size(m), size(n)),
            (a, size(lda)),
            s,
            [(u, size(ldu)), (vt, size(ldvt))],
            (work, *lwork),
        );
    }
}

#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn dgesvd_(
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
        *info = decompose(
            letter(jobu),
            (size(m), size(n)),
            (a, size(lda)),
            s,
            [(u, size(ldu)), (vt, size(ldvt))],
            (work, *lwork),
        );
    }
}
