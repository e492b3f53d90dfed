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
const CUT: f64 = 1e-8;

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
    pub(super) fn own(system: &StateSpace<Continuous>) -> Self {
        Self {
            system: system.clone(),
            error: 0.0,
            size: f64::INFINITY,
        }
    }

    /// The balanced system without the states that change less than [`CUT`] of `peak`.
    ///
    /// # Errors
    /// [`NumericError`] when a gramian fails.
    pub(super) fn balanced(
        system: &StateSpace<Continuous>,
        peak: f64,
    ) -> Result<Self, NumericError> {
        let balancing = Balancing::new(system)?;
        let (mut order, mut error) = (balancing.hankel.len(), 0.0);
        while order > 0 && error + 2.0 * balancing.hankel[order - 1] <= CUT * peak {
            order -= 1;
            error += 2.0 * balancing.hankel[order];
        }
        let size = max_singular_value(&system.d) + 2.0 * balancing.hankel.iter().sum::<f64>();
        Ok(Self {
            system: balancing.truncated(order)?,
            error,
            size,
        })
    }

    /// The level below which this form must be for the system that it stands for to be below `level`, with a scaling.
    pub(super) fn level(&self, scaling: &Scaling, level: f64) -> f64 {
        if self.error == 0.0 {
            return level;
        }
        let spread = max_singular_value_complex(&scaling.left)
            * max_singular_value_complex(&inverse_complex(&scaling.right));
        let (error, skew) = (
            self.error * spread,
            max_singular_value_complex(&scaling.skew),
        );
        if skew == 0.0 {
            return level - error;
        }
        // λmax(MᴴM + j(GM − MᴴGᴴ)) moves by at most this where M moves by the error.
        let moved = error * (2.0 * self.size * spread + 2.0 * skew + error);
        (level * level - moved).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::augment::Block;
    use crate::linalg::Mat;
    use crate::lti::Response;
    use crate::lti::connect::{add, append};
    use crate::robust::mu::certificate::certify;
    use crate::robust::mu::system::MuSystem;
    use crate::robust::structure::Structure;

    const BLOCKS: [Block; 2] = [Block::ComplexScalar { n: 1 }; 2];

    /// g₁ = (1 + s/10)/(1 + s/11) and g₂ = 1/g₁ · 1/(1 + s/1e5) on the other diagonal, and a path of 2e-10 beside them: μ² = |g₁g₂| ≤ 1, attained at rest up to 1e-10. The scaling of rest holds up to a few rad/s only.
    fn flat() -> Result<StateSpace<Continuous>, NumericError> {
        let first = StateSpace {
            a: Mat::from_fn(1, 1, |_, _| -11.0),
            b: Mat::from_fn(1, 1, |_, _| 1.0),
            c: Mat::from_fn(1, 1, |_, _| -1.1),
            d: Mat::from_fn(1, 1, |_, _| 1.1),
            time: Continuous,
        };
        // 1/g₁, then the low pass.
        let second = StateSpace {
            a: Mat::from_fn(2, 2, |i, j| [[-10.0, 0.0], [1e5, -1e5]][i][j]),
            b: Mat::from_fn(2, 1, |i, _| [1.0, 1e5][i] * 10.0 / 11.0),
            c: Mat::from_fn(1, 2, |_, j| [0.0, 1.0][j]),
            d: Mat::zeros(1, 1),
            time: Continuous,
        };
        let small = StateSpace {
            a: Mat::from_fn(1, 1, |_, _| -50.0),
            b: Mat::from_fn(1, 2, |_, j| [1.0, 0.0][j]),
            c: Mat::from_fn(2, 1, |i, _| [1e-8, 0.0][i]),
            d: Mat::zeros(2, 2),
            time: Continuous,
        };
        add(&append(&first, &second).select(&[1, 0], &[0, 1]), &small)
    }

    #[test]
    fn the_balanced_form_proves_the_peak_of_the_closed_form() -> Result<(), NumericError> {
        let system = flat()?;
        let form = LevelForm::balanced(&system, 1.0)?;
        // The small state is cut, and the difference is what the form says at most.
        assert_eq!((form.system.order(), system.order()), (3, 4));
        assert!(form.error > 0.0 && form.error <= CUT);
        for omega in [0.0, 5.0, 50.0, 1e3, 1e6] {
            let difference = system.at(omega) - form.system.at(omega);
            // Rounding of responses of size one.
            let size = max_singular_value_complex(&difference);
            assert!(size <= form.error + 1e-14, "{omega}: {size:e}");
        }
        let mu = MuSystem::new(&system, &BLOCKS).expect("stable");
        let (best, points) = mu.largest().expect("finite");
        let slack = 3e-4;
        let (end, scalings) = certify(&mu, best.clone(), &points, slack, &form).expect("covered");
        assert!((end.upper - 1.0).abs() < 1e-7, "{}", end.upper);
        assert!(scalings > 100, "{scalings}");
        // A level below the peak is not proved: what is attained elsewhere takes its place.
        let mut low = best;
        low.upper = 0.9;
        let (end, _) = certify(&mu, low, &points, slack, &form).expect("covered");
        assert!(end.upper * (1.0 + slack) >= 1.0, "{}", end.upper);
        Ok(())
    }

    #[test]
    fn the_level_is_lowered_by_what_the_cut_may_change() -> Result<(), NumericError> {
        let form = LevelForm::balanced(&flat()?, 1.0)?;
        let structure = Structure::new(&BLOCKS).expect("two blocks");
        let mut scaling = Scaling::diagonal(&structure, &[8.0, 1.0]);
        // ‖D‖‖D⁻¹‖ = 8.
        let expected = 1.0 - 8.0 * form.error;
        assert!((form.level(&scaling, 1.0) - expected).abs() < 1e-15);
        scaling.skew[(0, 0)] = crate::linalg::c64::new(0.1, 0.0);
        assert!(form.level(&scaling, 1.0) < expected);
        assert_eq!(LevelForm::own(&flat()?).level(&scaling, 1.0), 1.0);
        Ok(())
    }
}
