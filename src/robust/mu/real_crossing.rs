//! Lower bound of μ over frequency with real parameters. A real Δ makes the loop singular only at frequencies where an
//! eigenvalue of ΔM(jω) is real: with one parameter these are single points, which a grid of frequencies misses. From
//! the peak of the upper bound an eigenvalue is followed along the axis until it crosses the real line.

use super::MuBounds;
use super::lower::{WorstCase, singular, unrestored};
use super::system::MuSystem;
use crate::linalg::{Mat, c64, eigenvalues_complex};
use crate::robust::structure::MuError;

/// Share of the upper bound from which a lower bound is left as it is.
const CLOSE: f64 = 0.99;
/// The search goes this far from the peak, relative to its frequency: other peaks have grid points of their own.
const REACH: f64 = 0.5;
/// Smallest relative step: the width of a peak of damping 1e-9.
const FIRST_STEP: f64 = 1e-9;
/// Ratio of two steps: a branch turns by a few degrees between them on the flank of a resonance.
const STEP_RATIO: f64 = 1.25;
/// Bisections down to neighbouring numbers.
const HALVINGS: usize = 80;

impl MuSystem {
    /// Raises the lower bound of `bounds`, which belong to `omega`, where real parameters leave it below the upper one.
    /// The frequency of the lower bound, rad/s.
    ///
    /// # Errors
    /// As [`MuSystem::point`].
    pub(super) fn raise_lower(&self, bounds: &mut MuBounds, omega: f64) -> Result<f64, MuError> {
        let mut place = omega;
        if !self.structure.has_real() {
            return Ok(place);
        }
        let mut take = |found: WorstCase, at: f64, bounds: &mut MuBounds| {
            if found.value > bounds.lower {
                (bounds.lower, bounds.delta, place) = (found.value, found.delta, at);
            }
        };
        // The response is real at both ends of the axis.
        for end in [0.0, f64::INFINITY] {
            if bounds.lower < CLOSE * bounds.upper {
                let own = self.bounds(end)?;
                take(WorstCase { value: own.lower, delta: own.delta, singularity: f64::NAN }, end, bounds);
            }
        }
        if !(omega > 0.0 && omega.is_finite()) {
            return Ok(place);
        }
        for (delta, lambda) in unrestored(&self.response(omega), &self.structure, &bounds.scaling) {
            if bounds.lower >= CLOSE * bounds.upper {
                break;
            }
            for side in [-1.0, 1.0] {
                let Some((at, found)) = self.crossing(&delta, (omega, lambda), side) else {
                    continue;
                };
                take(found, at, bounds);
                // Other blocks have room to gain where the loop can be singular at all.
                if bounds.lower < CLOSE * bounds.upper && self.structure.spans.len() > 1 {
                    let own = self.bounds(at)?;
                    take(WorstCase { value: own.lower, delta: own.delta, singularity: f64::NAN }, at, bounds);
                }
            }
        }
        Ok(place)
    }

    /// The first frequency on one side at which the eigenvalue of ΔM(jω) that starts as `from` is real and positive,
    /// and the perturbation there.
    fn crossing(&self, delta: &Mat<c64>, from: (f64, c64), side: f64) -> Option<(f64, WorstCase)> {
        let (start, mut near) = from;
        let follow = |omega: f64, near: c64| {
            let all = eigenvalues_complex(&(delta * self.response(omega))).ok()?;
            all.into_iter().min_by(|x, y| (x - near).norm().total_cmp(&(y - near).norm()))
        };
        let (mut omega, mut step) = (start, FIRST_STEP);
        let (mut lo, mut hi) = loop {
            let next = start * (1.0 + side * step);
            let value = follow(next, near)?;
            if value.im * near.im <= 0.0 && value.re > 0.0 {
                break ((omega, near), (next, value));
            }
            (omega, near) = (next, value);
            step *= STEP_RATIO;
            if step > REACH {
                return None;
            }
        };
        for _ in 0..HALVINGS {
            let mid = 0.5 * (lo.0 + hi.0);
            if mid == lo.0 || mid == hi.0 {
                break;
            }
            let value = follow(mid, if lo.1.im.abs() < hi.1.im.abs() { lo.1 } else { hi.1 })?;
            let end = if value.im * lo.1.im > 0.0 { &mut lo } else { &mut hi };
            *end = (mid, value);
        }
        let (at, lambda) = if lo.1.im.abs() < hi.1.im.abs() { lo } else { hi };
        let found = singular(&self.response(at), &self.structure, delta, lambda)?;
        Some((at, found))
    }
}
