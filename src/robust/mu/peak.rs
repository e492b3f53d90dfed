//! The largest μ of a stable system over all frequencies.
//!
//! What the search (`search`) finds is attained; that nothing larger exists is proved by `certificate`.

use super::MuBounds;
use super::certificate;
use super::level_form::LevelForm;
use super::search;
use super::system::{MuPoint, MuSystem};
use crate::robust::structure::MuError;

/// The largest value over all frequencies with its certificate.
#[derive(Clone, Debug)]
pub struct MuPeak {
    /// No frequency has a larger μ (certified by frozen scalings that cover the axis).
    pub upper: f64,
    /// Largest upper bound attained at a frequency.
    pub attained: f64,
    /// Its frequency, rad/s; infinity for s = ∞.
    pub omega_rad_s: f64,
    /// Bounds at that frequency; with real parameters the lower bound and its perturbation may be those of another one.
    pub bounds: MuBounds,
    /// Frequency of the lower bound, rad/s.
    pub lower_omega_rad_s: f64,
    /// Frozen scalings used by the certificate.
    pub scalings: usize,
}

/// Ratio between a certificate and the largest attained value: a third of what a peak may be off by.
pub const CERTIFICATE_SLACK: f64 = 3e-4;

impl MuSystem {
    /// The largest upper bound on the grid and between its points, as far as a search sees it, with the optimum at
    /// every point of the grid.
    ///
    /// # Errors
    /// As [`Self::point`].
    pub fn search(&self) -> Result<(MuPoint, Vec<MuPoint>), MuError> {
        let found = search::search(self, 1)?;
        Ok((found.best, found.points))
    }

    /// As [`Self::search`], by branch and bound: where the scaling of a neighbour proves that a point is below the
    /// largest its bound is that of this scaling.
    ///
    /// # Errors
    /// As [`Self::point`].
    pub fn largest(&self) -> Result<(MuPoint, Vec<MuPoint>), MuError> {
        let found = search::search(self, search::STRIDE)?;
        Ok((found.best, found.points))
    }

    /// The certified peak over all frequencies; `slack` is the ratio allowed between certificate and attained value.
    ///
    /// # Errors
    /// [`MuError::NotCovered`] when the certificate does not come to its end, else as [`Self::point`].
    pub fn peak(&self, slack: f64) -> Result<MuPeak, MuError> {
        let found = search::search(self, search::STRIDE)?;
        let (best, points) = (found.best, found.optimised);
        // A flat loop needs many scalings for a close certificate: a wider one is tried before giving up. Where
        // that ends early as well, rounding in the given coordinates may have lost crossings: others are tried.
        let mut slack = slack;
        let mut form = LevelForm::from_system(&self.system);
        let mut balanced = false;
        let (end, scalings) = loop {
            match certificate::certify(self, best.clone(), &points, slack, &form) {
                Err(MuError::NotCovered { .. }) if slack < 4e-4 => slack = 8e-4,
                Err(MuError::NotCovered { .. }) if !balanced => {
                    form = LevelForm::from_balanced(&self.system, best.upper)?;
                    balanced = true;
                }
                other => break other?,
            }
        };
        let mut bounds = self.bounds(end.omega_rad_s)?;
        let lower_omega_rad_s = self.raise_lower(&mut bounds, end.omega_rad_s)?;
        Ok(MuPeak {
            upper: end.upper * (1.0 + slack),
            attained: end.upper,
            omega_rad_s: end.omega_rad_s,
            bounds,
            lower_omega_rad_s,
            scalings,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::augment::Block;
    use crate::linalg::{Mat, NumericError, c64, max_singular_value_complex};
    use crate::lti::connect::{add, append};
    use crate::lti::{Continuous, Response, StateSpace};
    use crate::robust::mu::level_form::CUT;
    use crate::robust::structure::{Scaling, Structure};
    use certificate::certify;

    const BLOCKS: [Block; 2] = [Block::ComplexScalar { n: 1 }; 2];

    /// g₁ = (1 + s/10)/(1 + s/11) and g₂ = 1/g₁ · 1/(1 + s/1e5) on the other diagonal, a path of 2e-10 beside them:
    /// μ² = |g₁g₂| ≤ 1, attained at rest up to 1e-10. The scaling of rest holds up to a few rad/s only.
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

    /// What the cut of a form may change, by how far it lowers a level without scaling.
    fn error(form: &LevelForm) -> f64 {
        let structure = Structure::new(&BLOCKS).expect("two blocks");
        1.0 - form.level(&Scaling::identity(&structure), 1.0)
    }

    #[test]
    fn the_balanced_form_proves_the_peak_of_the_closed_form() -> Result<(), NumericError> {
        let system = flat()?;
        let form = LevelForm::from_balanced(&system, 1.0)?;
        // The small state is cut, and the difference is what the form says at most.
        assert_eq!((form.system.order(), system.order()), (3, 4));
        let error = error(&form);
        assert!(error > 0.0 && error <= CUT);
        for omega in [0.0, 5.0, 50.0, 1e3, 1e6] {
            let difference = system.at(omega) - form.system.at(omega);
            // Rounding of responses of size one.
            let size = max_singular_value_complex(&difference);
            assert!(size <= error + 1e-14, "{omega}: {size:e}");
        }
        let mu = MuSystem::new(&system, &BLOCKS).expect("stable");
        let (best, points) = mu.largest().expect("finite");
        let slack = CERTIFICATE_SLACK;
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
        let form = LevelForm::from_balanced(&flat()?, 1.0)?;
        let structure = Structure::new(&BLOCKS).expect("two blocks");
        let mut scaling = Scaling::diagonal(&structure, &[8.0, 1.0]);
        // ‖D‖‖D⁻¹‖ = 8.
        let expected = 1.0 - 8.0 * error(&form);
        assert!((form.level(&scaling, 1.0) - expected).abs() < 1e-14);
        scaling.skew[(0, 0)] = c64::new(0.1, 0.0);
        assert!(form.level(&scaling, 1.0) < expected);
        assert_eq!(LevelForm::from_system(&flat()?).level(&scaling, 1.0), 1.0);
        Ok(())
    }
}
