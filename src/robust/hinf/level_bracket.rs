//! The smallest feasible level between an infeasible and a feasible one.

use super::limit::{Limit, Optimum};
use crate::robust::error::{Condition, SynthesisError};

/// What X and Y say of a level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tested {
    pub gamma: f64,
    /// That of [`super::riccati_pair::Pair`]: negative where a condition of X and Y fails.
    pub measure: f64,
    /// The condition that is nearest to failing.
    pub nearest: Limit,
    /// The one that fails.
    pub failed: Option<Condition>,
}

impl Tested {
    /// A lower bound of the level, at which nothing was computed.
    pub(super) fn infeasible(gamma: f64) -> Self {
        Self { gamma, measure: -1.0, nearest: Limit::Coupling, failed: Some(Condition::Unsolved) }
    }

    /// ln γ and the measure: a feasible one counts as positive whatever its rounding, an infeasible one as negative.
    fn point(&self) -> (f64, f64) {
        let signed = match self.failed {
            None => self.measure.clamp(f64::MIN_POSITIVE, 10.0),
            Some(_) => self.measure.min(-f64::MIN_POSITIVE),
        };
        (self.gamma.ln(), signed)
    }
}

pub(super) type Test<'a> = dyn FnMut(f64) -> Result<Tested, SynthesisError> + 'a;

/// A feasible level above `lo`.
pub(super) fn bracket(mut lo: Tested, hint: Option<f64>, test: &mut Test) -> Result<(Tested, Tested), SynthesisError> {
    let lowest = lo.gamma;
    let mut ratio = 1.5f64;
    let mut gamma = match hint {
        Some(g) if g > lowest * 1.0001 && g < 1e3 * lowest => g * 1.001,
        _ => lowest * ratio,
    };
    let mut condition = Condition::Unsolved;
    // 1e12 above a lower bound: a problem that needs more is out of the range of f64.
    while gamma < 1e12 * lo.gamma.max(f64::MIN_POSITIVE) || ratio < 10.0 {
        let found = test(gamma)?;
        let Some(failed) = found.failed else {
            return Ok((lo, found));
        };
        (condition, lo) = (failed, found);
        ratio = (ratio * ratio).min(100.0);
        gamma *= ratio;
        if !gamma.is_finite() || gamma > 1e14 * lowest {
            break;
        }
    }
    Err(SynthesisError::NoLevel { gamma, condition })
}

/// Root of the measure in log γ by inverse quadratic interpolation inside a bracket, bisection where that is not safe
/// (Chandrupatla 1997). Returns the feasible end and the condition that is nearest to failing there.
pub(super) fn narrow(lo: Tested, hi: Tested, tol: f64, test: &mut Test) -> Result<Optimum, SynthesisError> {
    // Bisection alone needs 40 steps from a ratio of 100 to 1e-9.
    const STEPS: usize = 100;
    let (mut new, mut old) = (lo.point(), hi.point());
    let mut best = hi;
    let mut fraction = 0.5;
    for _ in 0..STEPS {
        let found = test((new.0 + fraction * (old.0 - new.0)).exp())?;
        let point = found.point();
        if found.failed.is_none() && found.gamma < best.gamma {
            best = found;
        }
        let third;
        if (point.1 > 0.0) == (new.1 > 0.0) {
            third = new;
        } else {
            third = old;
            old = new;
        }
        new = point;
        let width = (old.0 - new.0).abs();
        if width <= tol {
            break;
        }
        let xi = (new.0 - old.0) / (third.0 - old.0);
        let phi = (new.1 - old.1) / (third.1 - old.1);
        let smooth = phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi;
        fraction = if smooth {
            new.1 / (old.1 - new.1) * third.1 / (old.1 - third.1)
                + (third.0 - new.0) / (old.0 - new.0) * new.1 / (third.1 - new.1) * old.1 / (third.1 - old.1)
        } else {
            0.5
        };
        // Half a tolerance past the root closes the bracket from the other side.
        let margin = 0.5 * tol / width;
        fraction = if fraction.is_finite() { fraction.clamp(margin, 1.0 - margin) } else { 0.5 };
    }
    Ok(Optimum { gamma: best.gamma, limit: best.nearest })
}
