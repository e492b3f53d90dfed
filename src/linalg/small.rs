//! Elimination for matrices too small for a blocked solver.

use super::c64;
use super::fused::{fused_complex, multiply_add};

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
        let (above, below) = a.split_at_mut((k + 1) * n);
        let (b_above, b_below) = b.split_at_mut((k + 1) * p);
        let (row, b_row) = (&above[k * n + k..], &b_above[k * p..]);
        for (i, other) in below.chunks_exact_mut(n).enumerate() {
            let factor = other[k] * pivot;
            if factor == c64::new(0.0, 0.0) {
                continue;
            }
            for (own, v) in other[k..].iter_mut().zip(row) {
                *own = fused_complex(-factor, *v, *own);
            }
            for (own, v) in b_below[i * p..(i + 1) * p].iter_mut().zip(b_row) {
                *own = fused_complex(-factor, *v, *own);
            }
        }
    }
    for k in (0..n).rev() {
        let row = &a[k * n..(k + 1) * n];
        let pivot = row[k].inv();
        let (b_above, b_below) = b.split_at_mut((k + 1) * p);
        let b_row = &mut b_above[k * p..];
        for (factor, known) in row[k + 1..].iter().zip(b_below.chunks_exact(p.max(1))) {
            for (own, v) in b_row.iter_mut().zip(known) {
                *own = fused_complex(-factor, *v, *own);
            }
        }
        for own in b_row {
            *own *= pivot;
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
                *own = multiply_add(-factor, *v, *own);
            }
            b[k + 1 + i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known = (k + 1..n).fold(b[k], |sum, l| sum - a[k * n + l] * b[l]);
        b[k] = known / a[k * n + k];
    }
}
