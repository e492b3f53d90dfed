//! Products of a tall matrix with itself: half of the entries say all.

use super::fused::{fused_complex, multiply_add};
use super::planar::Part;
use super::{Mat, c64};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, MatRef, Par};

/// Adds AᵀA to a symmetric matrix of which the lower triangle is kept; the upper one is left as it is.
pub(crate) fn add_gram(lower: &mut Mat<f64>, a: MatRef<f64>) {
    let whole = BlockStructure::Rectangular;
    matmul(lower.as_mut(), BlockStructure::TriangularLower, Accum::Add, a.transpose(), whole, a, whole, 1.0, Par::Seq);
}

/// The whole of a symmetric matrix of which the lower triangle is known.
pub(crate) fn mirror_lower(mut lower: Mat<f64>) -> Mat<f64> {
    for j in 1..lower.ncols() {
        for i in 0..j {
            lower[(i, j)] = lower[(j, i)];
        }
    }
    lower
}

/// xᵀy of complex columns, real and imaginary parts apart, summed in four parts at a time.
pub(crate) fn complex_dot_in_lanes(x: Part, y: Part) -> c64 {
    let (mut re, mut im) = ([0.0; 4], [0.0; 4]);
    let whole = x.0.len() / 4 * 4;
    for k in (0..whole).step_by(4) {
        let four = |v: &[f64]| -> [f64; 4] { std::array::from_fn(|l| v[k + l]) };
        let (a, b, c, d) = (four(x.0), four(x.1), four(y.0), four(y.1));
        re = std::array::from_fn(|l| multiply_add(a[l], c[l], multiply_add(-b[l], d[l], re[l])));
        im = std::array::from_fn(|l| multiply_add(a[l], d[l], multiply_add(b[l], c[l], im[l])));
    }
    let at = |part: Part<'_>, k: usize| c64::new(part.0[k], part.1[k]);
    let first = c64::new((re[0] + re[1]) + (re[2] + re[3]), (im[0] + im[1]) + (im[2] + im[3]));
    (whole..x.0.len()).fold(first, |sum, k| fused_complex(at(x, k), at(y, k), sum))
}

/// aᵀb, summed in eight parts at a time.
pub(crate) fn dot_in_lanes(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (left, right) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = left.remainder().iter().zip(right.remainder());
    let last: f64 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in left.zip(right) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum = multiply_add(*a, *b, *sum);
        }
    }
    sums.iter().sum::<f64>() + last
}
