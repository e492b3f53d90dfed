//! μ of a stable system at a frequency and on a grid: the upper bound with the scaling that proves it.
//!
//! Grid: DC, infinity, a log grid over and beyond the poles, and points packed round every lightly damped pole, where
//! peaks hide between the points of a log grid. The largest value over all frequencies: [`crate::robust::mu::peak`].

use super::vertex_crossing::RealCrossing;
use super::{MuBounds, bounds, upper_bound_for_system};
use crate::augment::Block;
use crate::linalg::{Mat, c64};
use crate::lti::norm::seeds;
use crate::lti::responder::FrequencyResponder;
use crate::lti::response::even_in_logarithm;
use crate::lti::{Continuous, StateSpace};
use crate::robust::structure::{MuError, Scaling, Structure};
use rayon::prelude::*;

/// The upper bound at one frequency.
#[derive(Clone, Debug)]
pub struct MuPoint {
    /// Frequency, rad/s; infinity for s = ∞.
    pub omega_rad_s: f64,
    /// Upper bound of μ there.
    pub upper: f64,
    /// The scaling that proves it.
    pub scaling: Scaling,
}

/// A stable system prepared for μ at many frequencies.
#[derive(Clone, Debug)]
pub struct MuSystem {
    pub(super) system: StateSpace<Continuous>,
    pub(super) structure: Structure,
    blocks: Vec<Block>,
    responder: FrequencyResponder<Continuous>,
    pub(super) poles: Vec<c64>,
    /// Frequencies where the loop with real parameters is real; none without such parameters.
    pub(super) crossings: Vec<RealCrossing>,
}

impl MuSystem {
    /// Checks shapes and stability.
    ///
    /// # Errors
    /// [`MuError::Shape`], [`MuError::Unstable`], or a failed decomposition.
    pub fn new(system: &StateSpace<Continuous>, blocks: &[Block]) -> Result<Self, MuError> {
        let structure = Structure::new(blocks)?;
        let direct = Mat::from_fn(system.outputs(), system.inputs(), |i, j| c64::new(system.d[(i, j)], 0.0));
        structure.check(&direct)?;
        let poles = system.poles()?;
        let growth_rate = poles.iter().map(|p| p.re).fold(f64::NEG_INFINITY, f64::max);
        if growth_rate >= 0.0 {
            return Err(MuError::Unstable { growth_rate });
        }
        let mut prepared = Self {
            responder: FrequencyResponder::new(system),
            system: system.clone(),
            structure,
            blocks: blocks.to_vec(),
            poles,
            crossings: vec![],
        };
        if prepared.structure.has_real() {
            prepared.crossings = prepared.find_real_crossings();
        }
        Ok(prepared)
    }

    /// N(jω); ω may be infinite.
    pub fn response(&self, omega_rad_s: f64) -> Mat<c64> {
        self.responder.at_or_infinity(omega_rad_s)
    }

    /// The upper bound at a frequency.
    ///
    /// # Errors
    /// [`MuError`] when the response is not finite or a decomposition fails.
    pub fn point(&self, omega_rad_s: f64) -> Result<MuPoint, MuError> {
        self.point_of(omega_rad_s, &self.response(omega_rad_s))
    }

    /// The upper bound at a frequency whose response is known.
    pub(super) fn point_of(&self, omega_rad_s: f64, m: &Mat<c64>) -> Result<MuPoint, MuError> {
        if !m.is_all_finite() {
            return Err(MuError::NotFinite { omega_rad_s });
        }
        let (upper, scaling) = upper_bound_for_system(m, &self.structure)?;
        Ok(MuPoint { omega_rad_s, upper, scaling })
    }

    /// Upper bounds on a grid, in its order.
    ///
    /// # Errors
    /// As [`Self::point`].
    pub fn sweep(&self, omega_rad_s: &[f64]) -> Result<Vec<MuPoint>, MuError> {
        omega_rad_s.par_iter().map(|w| self.point(*w)).collect()
    }

    /// DC, infinity, and where to look in between.
    pub fn grid(&self) -> Vec<f64> {
        let mut list = seeds(&self.poles);
        let (lo, hi) = (list.first().copied(), list.last().copied());
        if let (Some(lo), Some(hi)) = (lo, hi) {
            let decades = (hi / lo).log10().max(1.0);
            // Ten points a decade, at most 150: wider spans are empty at their ends.
            let count = (10.0 * decades).min(150.0) as usize;
            list.extend(even_in_logarithm(lo, hi, count + 1));
        }
        for pole in self.poles.iter().filter(|p| p.im > 0.0) {
            let width = pole.re.abs();
            if width < 0.3 * pole.norm() {
                for k in [-8.0, -3.0, -1.0, -0.4, 0.4, 1.0, 3.0, 8.0] {
                    list.push((pole.im + k * width).max(0.0));
                }
            }
        }
        list.extend(self.crossings.iter().map(|crossing| crossing.omega_rad_s));
        list.push(0.0);
        list.push(f64::INFINITY);
        list.retain(|w| *w >= 0.0);
        list.sort_by(f64::total_cmp);
        list.dedup();
        list
    }

    /// Both bounds at a frequency.
    ///
    /// # Errors
    /// As [`Self::point`].
    pub fn bounds(&self, omega_rad_s: f64) -> Result<MuBounds, MuError> {
        bounds(&self.response(omega_rad_s), &self.blocks)
    }
}
