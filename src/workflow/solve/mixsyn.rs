//! `muspin solve augw` and `mixsyn`: a plant G with weights W1, W2, W3 → the generalized plant, or its H∞ controller.

use super::answer::system;
use super::clock::{Clock, sampled_system};
use super::{Answer, Failure, ProblemFields, hinfsyn};
use crate::augment::GeneralizedPlant;
use crate::augment::mixed_sensitivity::{SensitivityWeights, augment_with_weights};

/// Answers with the generalized plant, in the form that `solve hinfsyn` and `dksyn` read.
pub(super) fn augment(problem: &ProblemFields) -> Result<Answer, Failure> {
    let plant = read(problem)?;
    let answer = match problem.sample_time()? {
        None => system(&plant.system),
        Some(time) => sampled_system(&plant.system.clone().with_time(time)),
    };
    let (m1, p1) = (plant.disturbances(), plant.errors());
    let sizes = [("m1", m1), ("m2", plant.controls), ("p1", p1), ("p2", plant.measurements)];
    Ok(sizes.into_iter().fold(answer, |answer, (name, size)| answer.with(name, size)))
}

/// Solves the problem of a `mixsyn` file.
pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let level = if problem.has("gamma") { Some(problem.number("gamma")?) } else { None };
    hinfsyn::synthesise(read(problem)?, Clock::of(problem)?, level)
}

fn read(problem: &ProblemFields) -> Result<GeneralizedPlant, Failure> {
    let weight = |field: &str| problem.has(field).then(|| problem.system_in(field)).transpose();
    let weights = SensitivityWeights { error: weight("W1")?, control: weight("W2")?, output: weight("W3")? };
    let plant = problem.system_in("G")?;
    augment_with_weights(&plant, &weights).map_err(|error| problem.failure("G, W1, W2, W3", error).into())
}
