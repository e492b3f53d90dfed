//! Elimination for matrices too small for a blocked solver.

use super::c64;
use super::fused::{fused, fused_complex};

/// Solves A X = B in place (B becomes X), A n×n and B n×p row-major, by elimination with partial pivoting.
/// A singular A leaves values that are not finite.
pub(crate) fn eliminate(a: &mut [c64], b: &mut [c64], n: usize, p: usize) {
    for k in 0..n {
        let size = |i: usize| a[i * n + k].re.abs() + a[i * n + k].im.abs();
        let mut best = k;
        for i in k + 1..n {
            if size(i) > size(best) {
                best = i;
            }
        }
        if best != k {
            for j in 0..n {
                a.swap(k * n + j, best * n + j);
            }
            for j in 0..p {
                b.swap(k * p + j, best * p + j);
            }
        }
        let pivot = a[k * n + k].inv();
        for i in k + 1..n {
            let factor = a[i * n + k] * pivot;
            if factor == c64::new(0.0, 0.0) {
                continue;
            }
            for j in k + 1..n {
                let v = a[k * n + j];
                a[i * n + j] = fused_complex(-factor, v, a[i * n + j]);
            }
            for j in 0..p {
                let v = b[k * p + j];
                b[i * p + j] = fused_complex(-factor, v, b[i * p + j]);
            }
        }
    }
    for k in (0..n).rev() {
        let pivot = a[k * n + k].inv();
        for j in 0..p {
            let mut sum = b[k * p + j];
            for l in k + 1..n {
                sum = fused_complex(-a[k * n + l], b[l * p + j], sum);
            }
            b[k * p + j] = sum * pivot;
        }
    }
}

/// Solves A x = b in place (b becomes x), A n×n row-major, by elimination with partial pivoting. A singular A leaves
/// values that are not finite.
pub(crate) fn eliminate_real(a: &mut [f64], b: &mut [f64], n: usize) {
    for k in 0..n {
        let mut best = k;
        for i in k + 1..n {
            if a[i * n + k].abs() > a[best * n + k].abs() {
                best = i;
            }
        }
        if best != k {
            for j in k..n {
                a.swap(k * n + j, best * n + j);
            }
            b.swap(k, best);
        }
        let (above, below) = a.split_at_mut((k + 1) * n);
        let row = &above[k * n + k..];
        let pivot = row[0].recip();
        for (i, other) in below.chunks_exact_mut(n).enumerate() {
            let factor = other[k] * pivot;
            if factor == 0.0 {
                continue;
            }
            for (own, v) in other[k..].iter_mut().zip(row) {
                *own = fused(-factor, *v, *own);
            }
            b[k + 1 + i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known = (k + 1..n).fold(b[k], |sum, l| sum - a[k * n + l] * b[l]);
        b[k] = known / a[k * n + k];
    }
}
