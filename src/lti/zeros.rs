//! Zeros of a system with one input and one output.
//! They come from the resolvent at a real point s₀ where the system responds, so zeros at infinity need no care:
//! with w = 1/(s − s₀) and M = (s₀I − A)⁻¹, G = D′ − cM(wI + M)⁻¹Mb, D′ = d + cMb, zeros w = eig(−M + Mb·cM/D′).

use super::state_space::{StateSpace, TimeBase};
use crate::linalg::{Mat, NumericError, c64, eigenvalues, solve};
use std::f64::consts::PI;

/// Largest part that roots taken as infinite, or as zero, have in the response: rounding of a few products. (A k-fold
/// root comes out as a ring of k roots at the k-th root of rounding, whose product is right all the same.)
const NEGLIGIBLE_PART: f64 = 1e-12;
/// Real points outside the circle of interest where the numerator is taken, in units of its radius: one is no zero.
const REAL_POINTS: [f64; 4] = [3.0, -3.0, 7.0, -7.0];

/// The finite zeros, and one value of the response that fixes the gain.
#[derive(Clone, Debug)]
pub(crate) struct SisoZeros {
    /// Finite zeros; conjugate pairs are exact.
    pub zeros: Vec<c64>,
    /// Real point at which `value` is the response.
    pub point: f64,
    /// Response there, zero only for a system that does not respond at all.
    pub value: f64,
}

/// Finite zeros of a system with one input and one output, in states of like size; `radius` is that of the circle
/// round zero on which its response is of interest.
pub(crate) fn siso_zeros<T: TimeBase>(system: &StateSpace<T>, radius: f64) -> Result<SisoZeros, NumericError> {
    let values = REAL_POINTS.map(|s| (s * radius, system.transfer(c64::new(s * radius, 0.0))[(0, 0)].re));
    let finite = values.into_iter().filter(|(_, value)| value.is_finite());
    let (point, value) = finite.max_by(|x, y| x.1.abs().total_cmp(&y.1.abs())).unwrap_or((radius, 0.0));
    let n = system.order();
    if value == 0.0 || n == 0 {
        return Ok(SisoZeros { zeros: vec![], point, value });
    }
    let shifted = Mat::from_fn(n, n, |i, j| -system.a[(i, j)] + if i == j { point } else { 0.0 });
    let m = solve(&shifted, &Mat::identity(n, n))?;
    let (mb, cm) = (&m * &system.b, &system.c * &m);
    let pencil = Mat::from_fn(n, n, |i, j| -m[(i, j)] + mb[(i, 0)] * cm[(0, j)] / value);
    let mut inverse = eigenvalues(&pencil)?;
    // As many of the smallest w as have no part in the response are zeros at infinity.
    inverse.sort_by(|v, w| v.norm().total_cmp(&w.norm()));
    let part = |far: &[c64]| {
        let factor = |s: c64| far.iter().fold(c64::new(1.0, 0.0), |p, w| p * (1.0 - w * (s - point)));
        let ratio = |s: c64| (factor(s) / factor(c64::new(point, 0.0)) - 1.0).norm();
        on_circle(radius).map(ratio).fold(0.0, f64::max)
    };
    let count = (0..=n).rev().find(|k| part(&inverse[..*k]) <= NEGLIGIBLE_PART).unwrap_or(0);
    Ok(SisoZeros { zeros: inverse[count..].iter().map(|w| w.inv() + point).collect(), point, value })
}

/// Roots without those at zero, as far as these are powers of the variable on the circle of this radius.
pub(crate) fn roots_off_zero(mut roots: Vec<c64>, radius: f64) -> Vec<c64> {
    roots.sort_by(|p, q| p.norm().total_cmp(&q.norm()));
    let part = |near: &[c64]| {
        let factor = |s: c64| near.iter().fold(c64::new(1.0, 0.0), |p, r| p * (1.0 - r / s));
        on_circle(radius).map(|s| (factor(s) - 1.0).norm()).fold(0.0, f64::max)
    };
    let count = (0..=roots.len()).rev().find(|k| part(&roots[..*k]) <= NEGLIGIBLE_PART).unwrap_or(0);
    roots.split_off(count)
}

/// Points of the upper half of a circle, enough of them that few roots do not repeat on all.
fn on_circle(radius: f64) -> impl Iterator<Item = c64> {
    (0..17).map(move |k| c64::from_polar(radius, PI * f64::from(k) / 16.0))
}
