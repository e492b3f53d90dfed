//! The level at which ρ(XY) = γ², by the derivative of ρ(XY) by γ.
//!
//! γ²/ρ(XY) − 1 grows with ln γ, nearly linearly, and its derivative costs a Lyapunov equation a side
//! ([`super::couplings`]). ln γ as a cubic of it through the last two levels and their derivatives needs two or three
//! pairs of Riccati equations, and neither brackets nor the peaks of the sides. Where X and Y exist and are positive at
//! a root, it is the optimum, for both fall with γ. The conditions are therefore tested at a root that lies below
//! the last level, too: another eigenvalue, or X or Y, may pass infinity on the way.

use super::couplings::{Binding, Couplings};
use super::riccati_pair::solve_pair;
use super::side::RiccatiSide;
use crate::linalg::riccati::RiccatiEffort;
use crate::robust::error::SynthesisError;
use std::cell::Cell;

/// What a root is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asked {
    /// The level: the last pair may lie off it.
    Level,
    /// The level and derivatives at it: the last pair lies within the root of the tolerance.
    Slopes,
}

/// Pairs of Riccati equations at most: three are usual; a problem that needs more has no root to be found this way.
const PAIRS: usize = 8;
/// Share of the tolerance that the error estimated may be: estimates are orders of magnitude.
pub(super) const SHARE: f64 = 0.1;
/// Largest step in ln γ.
const LONGEST: f64 = 0.5;

/// ln γ of the root to a tolerance, from the level `start`, and the couplings at the last level looked at; `None` where
/// a level looked at has no X or Y, or an indefinite one. Adds to the number of `pairs` solved.
pub(super) fn coupling_root(
    control: &RiccatiSide,
    filter: &RiccatiSide,
    start: f64,
    tolerance: f64,
    asked: Asked,
    pairs: &Cell<usize>,
) -> Result<Option<(f64, Couplings)>, SynthesisError> {
    let least = control.level_at_infinity().max(filter.level_at_infinity());
    let mut ln = start.ln();
    let mut last: Option<CouplingLevel> = None;
    // A root at which the conditions are yet to be tested.
    let mut estimated: Option<(f64, Couplings)> = None;
    for _ in 0..PAIRS {
        let gamma = ln.exp();
        if !(gamma.is_finite() && gamma > least) {
            return Ok(None);
        }
        pairs.set(pairs.get() + 1);
        let found = solve_pair(control, filter, gamma, RiccatiEffort::Fast)?;
        let Some(found) = found.filter(|found| found.coupling.is_definite()) else {
            return Ok(None);
        };
        if let Some(estimated) = estimated.take()
            && found.coupling.ratio < gamma * gamma
        {
            return Ok(Some(estimated));
        }
        let couplings = Couplings::new(control, filter, &found, gamma)?;
        let Some(binding) = couplings.binding() else {
            return Ok(None);
        };
        let point = CouplingLevel { ln, binding };
        let (root, error) = point.root(last.as_ref());
        let ends = match asked {
            Asked::Level => error <= SHARE * tolerance,
            Asked::Slopes => point.error(last.as_ref()) <= SHARE * tolerance,
        };
        if ends && root >= ln - tolerance {
            return Ok(Some((root, couplings)));
        }
        last = Some(point);
        if ends {
            ln = root + SHARE * tolerance;
            estimated = Some((root, couplings));
        } else {
            ln += (root - ln).clamp(-LONGEST, LONGEST);
        }
    }
    Ok(None)
}

/// A level with the eigenvalue of XY that binds.
struct CouplingLevel {
    ln: f64,
    binding: Binding,
}

impl CouplingLevel {
    /// Newton's step.
    fn step(&self) -> f64 {
        -self.binding.measure / self.binding.slope
    }

    /// What Newton's step misses, in order of magnitude: its square over the scale on which the measure bends. Two
    /// eigenvalues that repel one another bend within their distance, and one that passes infinity, where the measure
    /// is −1, within the distance of that: near the level of a side the measure is steep and bends at once. Another
    /// point shows how far it has bent.
    fn error(&self, other: Option<&Self>) -> f64 {
        let own = &self.binding;
        let bent = other.map_or(f64::INFINITY, |other| {
            let least = own.slope.min(other.binding.slope);
            (self.ln - other.ln).abs() * least / (own.slope - other.binding.slope).abs()
        });
        let step = self.step().abs();
        let scale = own.apart.min((1.0 + own.measure) / own.slope).min(bent);
        step * (step / scale).min(1.0).max(step)
    }

    /// ln γ where the measure is zero, by the inverse cubic through this point and another one, and an estimate of its
    /// error: that of the cubic is of the order of the squares of both steps. Newton's step alone where another
    /// eigenvalue may have bound at the other point.
    fn root(&self, other: Option<&Self>) -> (f64, f64) {
        let step = self.step();
        let newton = (self.ln + step, self.error(other));
        let one = |other: &&Self| {
            other.binding.measure != self.binding.measure
                && other.step().abs() < other.binding.apart
                && step.abs() < self.binding.apart
        };
        let Some(other) = other.filter(one) else {
            return newton;
        };
        // Divided differences of ln γ over the measure, each point twice.
        let (own, far) = (&self.binding, &other.binding);
        let across = far.measure - own.measure;
        let chord = (other.ln - self.ln) / across;
        let bend = (chord - 1.0 / own.slope) / across;
        let twist = (1.0 / far.slope - 2.0 * chord + 1.0 / own.slope) / (across * across);
        let beyond = own.measure * own.measure * (bend - twist * far.measure);
        // What Newton's step misses, in terms of the step, is the scale on which the measure bends.
        let scale = beyond.abs() * other.step() / (step * step);
        let error = (beyond * scale * scale).abs().max((step * other.step()).powi(2));
        if error < newton.1 { (newton.0 + beyond, error) } else { newton }
    }
}
