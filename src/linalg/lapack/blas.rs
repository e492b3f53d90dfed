//! BLAS: products.

use super::arguments::*;
use core::ffi::{c_char, c_int};
use faer::Accum;
use faer::linalg::matmul::{
    matmul,
    triangular::{self, BlockStructure},
};

#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn dgemm_(
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
pub(crate) unsafe extern "C" fn dsyrk_(
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
        triangular::matmul(c, part, accumulate, a, full, a.transpose(), full, *alpha, PAR);
    }
}

#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn dsyr2k_(
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
            triangular::matmul(c.as_mut(), part, accumulate, x, full, y.transpose(), full, *alpha, PAR);
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
        if stride < 0 { (1 - len as isize) * stride } else { 0 }
    };
    let (x0, y0) = (start(incx, n), start(incy, m));
    for i in 0..m {
        unsafe {
            let sum: f64 = (0..n).map(|j| entry(i, j) * *x.offset(x0 + j as isize * incx)).sum();
            let target = y.offset(y0 + i as isize * incy);
            let old = if beta == 0.0 { 0.0 } else { beta * *target };
            *target = alpha * sum + old;
        }
    }
}

#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn dgemv_(
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
pub(crate) unsafe extern "C" fn dsymv_(
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
            if i == j || (i < j) == upper { a[(i, j)] } else { a[(j, i)] }
        };
        let (x, y) = ((x, *incx as isize), (y, *incy as isize));
        matrix_vector((n, n), *alpha, entry, x, *beta, y);
    }
}
