//! Poles of the sampled loops of a machine at some of its speeds: lines are packed round them.

use super::responses::{Plants, RotorRole};
use crate::controller::verification_error::VerificationError;
use crate::linalg::{NumericError, c64};
use crate::lti::{Discrete, StateSpace};
use crate::spindle::Plant;
use rayon::prelude::*;

/// Some plants of a search with their numbers, and what they are when sampled.
pub(crate) struct SampledPlants(Vec<(usize, Plant, StateSpace<Discrete>)>);

impl SampledPlants {
    /// Those that `chosen` takes by their number and role.
    pub(crate) fn of(plants: &Plants, chosen: impl Fn(usize, RotorRole) -> bool) -> Result<Self, VerificationError> {
        let all: Vec<(usize, &Plant)> = plants
            .all()
            .enumerate()
            .filter(|(number, (role, _))| chosen(*number, *role))
            .map(|(number, (_, plant))| (number, plant))
            .collect();
        let found: Result<Vec<_>, VerificationError> =
            all.into_par_iter().map(|(number, plant)| Ok((number, plant.clone(), plant.sample_plant()?))).collect();
        Ok(Self(found?))
    }

    /// Number of each, and the poles of its loop with a law of four axes, in the z plane.
    pub(crate) fn loop_poles(&self, law: &StateSpace<Discrete>) -> Result<Vec<(usize, Vec<c64>)>, NumericError> {
        self.0.par_iter().map(|(number, plant, sampled)| Ok((*number, plant.loop_poles(sampled, law)?))).collect()
    }
}

/// Poles of the z plane in the upper half plane as continuous ones, rad/s.
pub(crate) fn oscillating(poles: Vec<c64>, period_s: f64) -> Vec<c64> {
    let all = Discrete { period_s }.continuous_poles(poles);
    all.into_iter().filter(|p| p.im > 0.0).collect()
}
