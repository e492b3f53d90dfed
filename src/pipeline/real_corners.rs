//! μ of a problem with its real parameters at the ends of their ranges.
//!
//! Certificates take k_i and k_s as complex numbers. The largest μ over the corners of their box, each a problem with
//! fewer blocks, shows how conservative that is.

use super::PipelineError;
use crate::augment::GeneralizedPlant;
use crate::linalg::Mat;
use crate::lti::connect::lower_lft;
use crate::lti::{Continuous, StateSpace};
use crate::robust::mu::system::MuSystem;
use crate::robust::structure::MuError;
use rayon::prelude::*;

const STAGE: &str = "corners of the real parameters";

/// Largest μ found over the corners of the channels `real`, everything else uncertain as before; infinite when the loop
/// of a corner is unstable, none without such channels.
///
/// # Errors
/// [`PipelineError`] when a loop cannot be closed or a bound fails.
pub fn largest_at_corners(
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
    real: &[usize],
) -> Result<Option<f64>, PipelineError> {
    if real.is_empty() {
        return Ok(None);
    }
    let closed = lower_lft(&plant.system, controller).map_err(PipelineError::numeric(STAGE))?;
    // The channels are one by one and come before the performance block: row and column have one number.
    let last = |count: usize| -> Vec<usize> {
        let others = (0..count).filter(|k| !real.contains(k));
        others.chain(real.iter().copied()).collect()
    };
    let ordered = closed.select(&last(closed.outputs()), &last(closed.inputs()));
    let kept: Vec<_> = (0..plant.blocks.len()).filter(|k| !real.contains(k)).map(|k| plant.blocks[k]).collect();
    let found: Result<Vec<f64>, PipelineError> = (0..1usize << real.len())
        .into_par_iter()
        .map(|corner| {
            let n = real.len();
            let errors = Mat::from_fn(n, n, |i, j| match (i == j, (corner >> i) & 1) {
                (true, 0) => 1.0,
                (true, _) => -1.0,
                _ => 0.0,
            });
            let errors = StateSpace::gain(errors, Continuous);
            let there = lower_lft(&ordered, &errors).map_err(PipelineError::numeric(STAGE))?;
            match MuSystem::new(&there, &kept) {
                Ok(system) => {
                    let (top, _) = system.largest().map_err(PipelineError::mu(STAGE))?;
                    Ok(top.upper)
                }
                Err(MuError::Unstable { .. }) => Ok(f64::INFINITY),
                Err(error) => Err(PipelineError::mu(STAGE)(error)),
            }
        })
        .collect();
    Ok(Some(found?.into_iter().fold(0.0, f64::max)))
}
