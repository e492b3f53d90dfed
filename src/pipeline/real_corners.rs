//! μ of a problem with its real parameters at the ends of their ranges.
//!
//! Certificates take k_i and k_s as complex numbers. What that costs shows beside the largest μ over the corners of
//! their box, each a problem with fewer blocks.

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
pub(super) fn largest_at_corners(
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
    let kept: Vec<_> = (0..plant.blocks.len())
        .filter(|k| !real.contains(k))
        .map(|k| plant.blocks[k])
        .collect();
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

#[cfg(test)]
mod tests {
    use super::largest_at_corners;
    use crate::augment::{Block, GeneralizedPlant};
    use crate::linalg::Mat;
    use crate::lti::{Continuous, StateSpace};

    /// Two real parameters round M = (a 0 1; 0 b 1; 1 1 0) without a controller: the performance is the sum of
    /// δ₁/(1 − a δ₁) and δ₂/(1 − b δ₂).
    fn problem(a: f64, b: f64) -> (GeneralizedPlant, StateSpace<Continuous>) {
        let rows = [
            [a, 0.0, 1.0, 0.0],
            [0.0, b, 1.0, 0.0],
            [1.0, 1.0, 0.0, 0.0],
            [0.0; 4],
        ];
        let plant = GeneralizedPlant {
            system: StateSpace::gain(Mat::from_fn(4, 4, |i, j| rows[i][j]), Continuous),
            controls: 1,
            measurements: 1,
            blocks: vec![
                Block::ComplexScalar { n: 1 },
                Block::ComplexScalar { n: 1 },
                Block::ComplexFull { rows: 1, cols: 1 },
            ],
        };
        (plant, StateSpace::gain(Mat::zeros(1, 1), Continuous))
    }

    #[test]
    fn the_worst_corner_of_a_problem_in_closed_form_is_found() {
        for (a, b) in [(0.5, 0.2), (-0.5, 0.2), (0.0, 0.0), (-0.7, -0.6)] {
            let (plant, law) = problem(a, b);
            let found = largest_at_corners(&plant, &law, &[0, 1])
                .expect("loops of two states")
                .expect("two unknown corners");
            let of = |d: f64, m: f64| d / (1.0 - m * d);
            let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
            let own = corners.map(|(d, e)| (of(d, a) + of(e, b)).abs());
            let expected = own.into_iter().fold(0.0, f64::max);
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        }
        let (plant, law) = problem(0.5, 0.2);
        assert_eq!(
            largest_at_corners(&plant, &law, &[]).expect("no corner to search"),
            None
        );
    }
}
