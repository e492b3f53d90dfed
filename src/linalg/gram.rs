//! Products of a tall matrix with itself: half of the entries say all.

use super::Mat;
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, MatRef, Par};

/// Adds AᵀA to a symmetric matrix of which the lower triangle is kept; the upper one is left as it is.
pub(crate) fn add_gram(lower: &mut Mat<f64>, a: MatRef<f64>) {
    let whole = BlockStructure::Rectangular;
    matmul(
        lower.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Add,
        a.transpose(),
        whole,
        a,
        whole,
        1.0,
        Par::Seq,
    );
}

/// The whole of a symmetric matrix of which the lower triangle is known.
pub(crate) fn mirrored(mut lower: Mat<f64>) -> Mat<f64> {
    for j in 1..lower.ncols() {
        for i in 0..j {
            lower[(i, j)] = lower[(j, i)];
        }
    }
    lower
}

/// aᵀb, summed in eight parts at a time.
pub(crate) fn dot_in_lanes(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (left, right) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = left.remainder().iter().zip(right.remainder());
    let last: f64 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in left.zip(right) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + last
}
