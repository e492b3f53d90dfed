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
    /// Bounds at that frequency: the lower bound and its perturbation.
    pub bounds: MuBounds,
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
        // A flat loop needs many scalings for a close certificate: a wider one is tried before giving up, and where
        // that ends early as well the crossings are lost to rounding in the given coordinates.
        let mut slack = slack;
        let mut form = LevelForm::own(&self.system);
        let mut balanced = false;
        let (end, scalings) = loop {
            match certificate::certify(self, best.clone(), &points, slack, &form) {
                Err(MuError::NotCovered { .. }) if slack < 4e-4 => slack = 8e-4,
                Err(MuError::NotCovered { .. }) if !balanced => {
                    form = LevelForm::balanced(&self.system, best.upper)?;
                    balanced = true;
                }
                other => break other?,
            }
        };
        let bounds = self.bounds(end.omega_rad_s)?;
        Ok(MuPeak {
            upper: end.upper * (1.0 + slack),
            attained: end.upper,
            omega_rad_s: end.omega_rad_s,
            bounds,
            scalings,
        })
    }
}
