//! The state-space form of a system of which the level test takes eigenvalues.
//!
//! The test squares the entries of its data. Where a controller has nearly cancelled poles, or an H∞ level is close to
//! the optimum, the given coordinates lose the eigenvalues of low frequencies to rounding. Balanced coordinates keep
//! them; what balancing cuts off changes the response by at most twice the sum of the cut Hankel values (Enns 1984),
//! and the level is lowered by that.

use crate::linalg::hermitian::inverse_complex;
use crate::linalg::{NumericError, max_singular_value, max_singular_value_complex};
use crate::lti::balance::Balancing;
use crate::lti::{Continuous, StateSpace};
use crate::robust::structure::Scaling;

/// What the cut may change, relative to the largest μ: far below the slack of a certificate, far above rounding.
pub(super) const CUT: f64 = 1e-8;

/// A system, or one near it.
pub(super) struct LevelForm {
    pub system: StateSpace<Continuous>,
    /// H∞ norm of the difference to the system that it stands for, at most.
    error: f64,
    /// H∞ norm of the system, at most; of no use where `error` is zero.
    size: f64,
}

impl LevelForm {
    /// The system in its own coordinates.
    pub(super) fn from_system(system: &StateSpace<Continuous>) -> Self {
        Self { system: system.clone(), error: 0.0, size: f64::INFINITY }
    }

    /// The balanced system without the states that change less than [`CUT`] of `peak`.
    pub(super) fn from_balanced(system: &StateSpace<Continuous>, peak: f64) -> Result<Self, NumericError> {
        let balancing = Balancing::new(system)?;
        let (mut order, mut error) = (balancing.hankel.len(), 0.0);
        while order > 0 && error + 2.0 * balancing.hankel[order - 1] <= CUT * peak {
            order -= 1;
            error += 2.0 * balancing.hankel[order];
        }
        let size = max_singular_value(&system.d) + 2.0 * balancing.hankel.iter().sum::<f64>();
        Ok(Self { system: balancing.truncate_states(order)?, error, size })
    }

    /// The level below which this form must be for the system that it stands for to be below `level`, with a scaling.
    pub(super) fn level(&self, scaling: &Scaling, level: f64) -> f64 {
        if self.error == 0.0 {
            return level;
        }
        let spread =
            max_singular_value_complex(&scaling.left) * max_singular_value_complex(&inverse_complex(&scaling.right));
        let (error, skew) = (self.error * spread, max_singular_value_complex(&scaling.skew));
        if skew == 0.0 {
            return level - error;
        }
        // λmax(MᴴM + j(GM − MᴴGᴴ)) moves by at most this where M moves by the error.
        let moved = error * (2.0 * self.size * spread + 2.0 * skew + error);
        (level * level - moved).max(0.0).sqrt()
    }
}
