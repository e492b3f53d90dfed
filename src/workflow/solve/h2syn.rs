//! `muspin solve h2syn`: a generalized plant → the controller with the smallest H2 norm; `lqg`: a plant with the
//! weights of its states and controls and the covariances of its noises.

use super::answer::system;
use super::care::read_cost;
use super::clock::{Clock, sampled_system};
use super::{Answer, Failure, ProblemFields};
use crate::linalg::Mat;
use crate::lti::connect::block2;
use crate::lti::energy_norm::{h2_norm, h2_norm_discrete};
use crate::lti::{Continuous, StateSpace, TimeBase};
use crate::robust::h2::{H2Error, H2Solution, pose_lqg, synthesise_h2};

/// Solves the problem of an `h2syn` file.
pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let plant = problem.generalized_plant()?;
    let (controls, measurements) = (plant.controls, plant.measurements);
    let clock = Clock::of(problem)?;
    Ok(synthesise(plant.system, [controls, measurements], clock)?)
}

/// Solves the problem of an `lqg` file.
pub(super) fn solve_lqg(problem: &ProblemFields) -> Result<Answer, Failure> {
    let plant = problem.system()?;
    let (n, m, p) = (plant.order(), plant.inputs(), plant.outputs());
    let [q, r, s] = read_cost(problem, n, m)?;
    let (w, v) = (problem.matrix_of("W", n, n)?, problem.matrix_of("V", p, p)?);
    let cross = if problem.has("WV") { problem.matrix_of("WV", n, p)? } else { Mat::zeros(n, p) };
    for (field, matrix) in [("Q", &q), ("R", &r), ("W", &w), ("V", &v)] {
        let skew = (matrix - matrix.transpose()).norm_max();
        if skew > 1e-10 * matrix.norm_max() {
            return Err(problem.failure(field, "is not symmetric").into());
        }
    }
    let both = |a: &Mat<f64>, b: &Mat<f64>, c: &Mat<f64>| block2(a, b, &b.transpose().to_owned(), c);
    let posed = pose_lqg(&plant, &both(&q, &s, &r), &both(&w, &cross, &v))?;
    Ok(synthesise(posed, [m, p], Clock::of(problem)?)?)
}

fn synthesise(plant: StateSpace<Continuous>, sizes: [usize; 2], clock: Clock) -> Result<Answer, H2Error> {
    let [controls, measurements] = sizes;
    Ok(match clock.0 {
        None => {
            let found = synthesise_h2(&plant, controls, measurements, |s| Ok(h2_norm(s)?.norm))?;
            stated(&found, system(&found.controller), clock)
        }
        Some(time) => {
            let norm = |s: &StateSpace<_>| Ok(h2_norm_discrete(s)?.norm);
            let found = synthesise_h2(&plant.with_time(time), controls, measurements, norm)?;
            stated(&found, sampled_system(&found.controller), clock)
        }
    })
}

fn stated<T: TimeBase>(found: &H2Solution<T>, controller: Answer, clock: Clock) -> Answer {
    let answer = Answer::new()
        .with_number("norm", found.norm)
        .with_number("norm_opt", found.optimum)
        .with("controller", controller)
        .with_matrix("F", &found.control_gain)
        .with_matrix("L", &found.filter_gain)
        .with_number("x_residual", found.residuals[0])
        .with_number("y_residual", found.residuals[1]);
    clock.with_stability(answer, found.growth_rate)
}

impl From<H2Error> for Failure {
    fn from(error: H2Error) -> Self {
        let hint = match &error {
            H2Error::Riccati { .. } => {
                "every unstable mode is driven by u and seen by y; every control needs a direct path into z (D12, R) \
                 and every measurement a noise of its own (D21, V)"
            }
            H2Error::Feedthrough { .. } => "give the errors or the disturbances a roll-off, or sample the plant",
            H2Error::Indefinite { .. } => "a cost is a sum of squares, and so is a covariance: check the cross term",
            _ => "check the scaling of states and channels",
        };
        Self::new(format!("H2 synthesis: {error}")).with_hint(hint)
    }
}
