//! Poles of the sampled loops of a machine at some of its speeds: lines are packed round them.

use super::responses::{Plants, Role};
use crate::controller::verification_error::VerificationError;
use crate::linalg::{NumericError, c64};
use crate::lti::{Discrete, StateSpace};
use crate::spindle::Plant;
use rayon::prelude::*;

/// The first plant of some roles, with what it is when sampled.
pub(crate) struct SampledPlants(Vec<(Role, Plant, StateSpace<Discrete>)>);

impl SampledPlants {
    /// Those of the roles that `plants` has.
    ///
    /// # Errors
    /// [`VerificationError`] when a plant cannot be sampled.
    pub(crate) fn of(plants: &Plants, roles: &[Role]) -> Result<Self, VerificationError> {
        let found: Result<Vec<_>, VerificationError> = roles
            .par_iter()
            .filter_map(|role| Some((*role, plants.of(*role).next()?)))
            .map(|(role, plant)| Ok((role, plant.clone(), plant.sampled()?)))
            .collect();
        Ok(Self(found?))
    }

    /// Role of each, and the poles of its loop with a law of four axes, in the z plane.
    ///
    /// # Errors
    /// As [`Plant::loop_poles`].
    pub(crate) fn loop_poles(
        &self,
        law: &StateSpace<Discrete>,
    ) -> Result<Vec<(Role, Vec<c64>)>, NumericError> {
        self.0
            .par_iter()
            .map(|(role, plant, sampled)| Ok((*role, plant.loop_poles(sampled, law)?)))
            .collect()
    }
}

/// Poles of the z plane in the upper half plane as continuous ones, rad/s.
pub(crate) fn oscillating(poles: Vec<c64>, period_s: f64) -> Vec<c64> {
    let all = Discrete { period_s }.continuous_poles(poles);
    all.into_iter().filter(|p| p.im > 0.0).collect()
}
