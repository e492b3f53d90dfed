//! The optimal diagonal D-scale of a complex structure: inf over D of σ_max(D_L M D_R⁻¹), one positive number per
//! block.
//!
//! Start: block Osborne balancing. Then the method of centres (`dscale_centre`), which ends with a certificate.
//!
//! Limits: blocks with one number each. Repeated scalars and real parameters go to `mixed`. The tests check both
//! against the matrix inequality, solved by clarabel.

use super::dscale_centre::{BlockRange, End, centres};
use crate::linalg::largest_singular::largest_singular_value;
use crate::linalg::planar::Planar;
use crate::linalg::{Mat, c64, max_singular_value_complex};
use crate::robust::structure::Structure;

/// A diagonal scale with what it proves.
#[derive(Clone, Debug)]
pub struct DiagonalScale {
    /// One positive number per block, the last is 1.
    pub d: Vec<f64>,
    /// σ_max(D_L M D_R⁻¹), evaluated.
    pub bound: f64,
    /// The infimum over all diagonal D is at least this.
    pub at_least: f64,
    /// Newton steps taken.
    pub steps: usize,
}

/// D-scale that balances the Frobenius norms of the blocks of M (Osborne 1960), last entry 1.
pub(crate) fn osborne(m: &Mat<c64>, structure: &Structure) -> Vec<f64> {
    let spans = &structure.spans;
    let n = spans.len();
    let size = Mat::from_fn(n, n, |a, b| {
        let rows = spans[a].z.clone();
        rows.flat_map(|i| spans[b].w.clone().map(move |j| (i, j))).map(|ij| m[ij].norm_sqr()).sum::<f64>()
    });
    let mut d = vec![1.0f64; n];
    // 200 sweeps also settle nearly reducible matrices, whose balance moves by many decades.
    for _ in 0..200 {
        let mut moved: f64 = 0.0;
        for a in 0..n {
            let (mut row, mut column) = (0.0, 0.0);
            for b in (0..n).filter(|b| *b != a) {
                row += size[(a, b)] * (d[a] / d[b]).powi(2);
                column += size[(b, a)] * (d[b] / d[a]).powi(2);
            }
            let factor = (column / row).sqrt().sqrt();
            if factor.is_finite() && factor > 0.0 {
                d[a] *= factor;
                moved = moved.max((factor - 1.0).abs());
            }
        }
        // The centring that follows needs a rough start only.
        if moved < 1e-2 {
            break;
        }
    }
    let last = d[n - 1];
    d.iter().map(|v| v / last).collect()
}

/// D_L M D_R⁻¹ divided by `size`, for one number per block.
fn scale_matrix(m: &Mat<c64>, structure: &Structure, d: &[f64], size: f64) -> Planar {
    let (mut rows, mut cols) = (vec![1.0; m.nrows()], vec![1.0; m.ncols()]);
    for (span, d) in structure.spans.iter().zip(d) {
        rows[span.z.clone()].fill(*d);
        cols[span.w.clone()].fill(1.0 / (d * size));
    }
    Planar::from_scaled(m, &rows, &cols)
}

/// σ_max(D_L M D_R⁻¹): the bound that a diagonal scale proves.
pub fn bound_scaled(m: &Mat<c64>, structure: &Structure, d: &[f64]) -> f64 {
    largest_singular_value(&scale_matrix(m, structure, d, 1.0))
}

/// Optimal diagonal scale of M for a structure whose blocks all have a single scale, with its proof. M should be
/// irreducible.
pub fn optimal(m: &Mat<c64>, structure: &Structure) -> DiagonalScale {
    seek_scaling(m, structure, End::Proven)
}

/// The same without the proof, whose last steps lower the bound by less than 2e-7 of it: about half the steps.
pub fn settle_scaling(m: &Mat<c64>, structure: &Structure) -> DiagonalScale {
    seek_scaling(m, structure, End::Settled)
}

fn seek_scaling(m: &Mat<c64>, structure: &Structure, until: End) -> DiagonalScale {
    let start = osborne(m, structure);
    let size = bound_scaled(m, structure, &start);
    let n = structure.spans.len();
    // NaN when the balance itself overflowed.
    if n == 1 || size.is_nan() || size <= 0.0 {
        let plain = max_singular_value_complex(m);
        return DiagonalScale { d: vec![1.0; n], bound: plain, at_least: if n == 1 { plain } else { 0.0 }, steps: 0 };
    }
    let spans = structure.spans.iter();
    let blocks: Vec<BlockRange> = spans.map(|s| (s.w.clone(), s.z.clone())).collect();
    let mut best = DiagonalScale { d: start, bound: size, at_least: 0.0, steps: 0 };
    for _ in 0..STARTS {
        let (before, least) = (best.bound, best.at_least);
        let end = centres(&scale_matrix(m, structure, &best.d, before), &blocks, until);
        best.steps += end.steps;
        best.at_least = best.at_least.max(before * end.at_least.max(0.0).sqrt());
        let reference = (best.d[n - 1], end.x[n - 1]);
        let pairs = best.d.iter().zip(&end.x);
        let d: Vec<f64> = pairs.map(|(d, x)| d / reference.0 * (x / reference.1).sqrt()).collect();
        let reached = bound_scaled(m, structure, &d);
        if reached < before {
            (best.d, best.bound) = (d, reached);
        }
        let settled = until == End::Settled && end.ended;
        let closed = settled || best.at_least >= best.bound * (1.0 - CLOSED);
        let gained = best.bound < before * (1.0 - GAINED) || best.at_least > least * (1.0 + GAINED);
        if closed || !gained {
            break;
        }
    }
    best
}

/// Starts of the method of centres: where the balance leaves scales many decades from their optimum, rounding ends it
/// early, and it goes on from what it found, in which the scales are near one.
const STARTS: usize = 40;
/// Gap between both bounds at which they agree: a tenth of what μ may be off by.
const CLOSED: f64 = 1e-5;
/// A start that moves neither bound by this share ends the method.
const GAINED: f64 = 1e-6;

/// The diagonal scale nearest to the balance of Osborne, in logarithms, among those between it and the optimum whose
/// bound is at most (1 + `slack`) times the optimum.
///
/// Where the bound is flat its optimal D is arbitrary and jumps from frequency to frequency; the balance is smooth, and
/// what a rational D(s) should follow there.
pub fn smooth(m: &Mat<c64>, structure: &Structure, slack: f64) -> Vec<f64> {
    let best = settle_scaling(m, structure);
    let balance = osborne(m, structure);
    let between = |t: f64| -> Vec<f64> {
        let pairs = best.d.iter().zip(&balance);
        pairs.map(|(d, o)| d.powf(1.0 - t) * o.powf(t)).collect()
    };
    let within = |t: f64| bound_scaled(m, structure, &between(t)) <= (1.0 + slack) * best.bound;
    if within(1.0) {
        return balance;
    }
    // ln σ is convex in ln d: the admissible part of the path is one interval from the optimum on.
    let (mut lo, mut hi) = (0.0, 1.0);
    for _ in 0..10 {
        let mid = 0.5 * (lo + hi);
        if within(mid) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    between(lo)
}
