//! Block-diagonal form by real similarity, A [X₁ X₂ …] = [X₁ X₂ …] diag(A₁, A₂, …), with limited coupling solutions.
//! From the ordered real Schur form [T₁₁ T₁₂; 0 T₂₂] the first block is separated by P with T₁₁P − PT₂₂ = −T₁₂. Where
//! ‖P‖ exceeds the limit the poles of both are too close to a common Jordan block: the pole of T₂₂ nearest to those of
//! T₁₁ is moved next to them and joins the block. So every block is found by orthogonal steps and one linear solve, and
//! poles that cannot be separated stay together. Source: Bavely and Stewart, SIAM J. Numer. Anal. 16 (1979) 359.

use super::basis::orthonormal_columns;
use super::error::NumericError;
use super::schur::{RealSchur, schur, small_sylvester};
use faer::{Mat, c64};

/// Separates a square matrix into blocks whose coupling solutions P have a Frobenius norm of at most `limit`; zero
/// gives one block, the Schur form itself. Returns an orthonormal basis of each block's invariant subspace (n×size):
/// AXₖ = XₖAₖ with Aₖ quasi upper triangular.
pub(crate) fn invariant_bases(a: &Mat<f64>, limit: f64) -> Result<Vec<Mat<f64>>, NumericError> {
    let n = a.nrows();
    let mut form = schur(a)?;
    let mut bases = Vec::new();
    let mut start = 0;
    while start < n {
        let mut end = start + form.block_at(start);
        while end < n {
            match coupling(&form, start, end, limit) {
                Some(p) => {
                    separate(&mut form, start, end, &p);
                    break;
                }
                None => end += raise_nearest(&mut form, start, end),
            }
        }
        bases.push(orthonormal_columns(&form.z.submatrix(0, start, n, end - start).to_owned()));
        start = end;
    }
    Ok(bases)
}

/// P with T₁₁P − PT₂₂ = −T₁₂ for T₁₁ at `start..end` and T₂₂ below it; nothing as soon as ‖P‖ exceeds `limit`.
fn coupling(form: &RealSchur, start: usize, end: usize, limit: f64) -> Option<Mat<f64>> {
    let t = &form.t;
    let n = t.nrows();
    let blocks = form.blocks();
    let rows: Vec<_> = blocks.iter().filter(|b| (start..end).contains(&b.0)).collect();
    let mut p = Mat::<f64>::zeros(end - start, n - end);
    let mut sum_of_squares = 0.0;
    for &(j, w) in blocks.iter().filter(|b| b.0 >= end) {
        for &&(i, h) in rows.iter().rev() {
            // What the known parts of P leave for this block of −T₁₂.
            let rest = Mat::from_fn(h, w, |r, c| {
                let below: f64 = (i + h..end).map(|k| t[(i + r, k)] * p[(k - start, j + c - end)]).sum();
                let before: f64 = (end..j).map(|k| p[(i + r - start, k - end)] * t[(k, j + c)]).sum();
                -t[(i + r, j + c)] - below + before
            });
            let left = |r1: usize, r2: usize| t[(i + r1, i + r2)];
            let right = |c1: usize, c2: usize| -t[(j + c2, j + c1)];
            let found = small_sylvester([h, w], left, right, |r, c| rest[(r, c)]);
            for (k, value) in found.into_iter().enumerate().take(h * w) {
                p[(i + k % h - start, j + k / h - end)] = value;
                sum_of_squares += value * value;
            }
            if sum_of_squares.is_nan() || sum_of_squares > limit * limit {
                return None;
            }
        }
    }
    Some(p)
}

/// Z ← Z [I P; 0 I] on the separated columns; the coupling T₁₂ is zero afterwards.
fn separate(form: &mut RealSchur, start: usize, end: usize, p: &Mat<f64>) {
    let n = form.t.nrows();
    let added = form.z.submatrix(0, start, n, end - start) * p;
    for j in end..n {
        for i in 0..n {
            form.z[(i, j)] += added[(i, j - end)];
        }
        for i in start..end {
            form.t[(i, j)] = 0.0;
        }
    }
}

/// Moves the block below `end` whose eigenvalue is nearest to those of `start..end` to `end`; returns its size.
fn raise_nearest(form: &mut RealSchur, start: usize, end: usize) -> usize {
    let upper: Vec<(usize, usize, c64)> =
        form.blocks().into_iter().map(|(at, size)| (at, size, form.eigenvalue_at(at))).collect();
    let distance = |z: c64| {
        upper
            .iter()
            .filter(|(at, ..)| (start..end).contains(at))
            .map(|(.., own)| (z - own).norm())
            .fold(f64::INFINITY, f64::min)
    };
    let below = upper.iter().enumerate().filter(|(_, (at, ..))| *at >= end);
    let Some((index, (_, size, _))) = below.min_by(|(_, x), (_, y)| distance(x.2).total_cmp(&distance(y.2))) else {
        return form.t.nrows() - end;
    };
    for (at, above, _) in upper[..index].iter().rev().filter(|(at, ..)| *at >= end) {
        form.swap(*at, *above, *size);
    }
    *size
}
