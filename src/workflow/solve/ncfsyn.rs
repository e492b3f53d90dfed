//! `muspin solve ncfsyn`: loop shaping by normalised coprime factors. G with W1 before and W2 behind it → the margin
//! of the shaped plant W2 G W1 and the controller K = W1 K∞ W2, u = K y.

use super::clock::Clock;
use super::{Answer, Failure, ProblemFields};
use crate::lti::connect::series;
use crate::lti::{Continuous, StateSpace};
use crate::robust::coprime::shape_loop;

pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let clock = Clock::of(problem)?;
    let weight = |field: &str| -> Result<Option<StateSpace<Continuous>>, Failure> {
        if !problem.has(field) {
            return Ok(None);
        }
        Ok(Some(clock.in_plane(problem.system_in(field)?)?))
    };
    let (before, behind) = (weight("W1")?, weight("W2")?);
    let chain = |first: Option<&StateSpace<_>>, middle: StateSpace<_>, last: Option<&StateSpace<_>>| {
        let middle = first.map_or_else(|| Ok(middle.clone()), |w| series(w, &middle))?;
        last.map_or_else(|| Ok(middle.clone()), |w| series(&middle, w))
    };
    let misfit = |error| problem.failure("G, W1, W2", error);
    let shaped = chain(before.as_ref(), clock.in_plane(problem.system_in("G")?)?, behind.as_ref()).map_err(misfit)?;
    let level = if problem.has("gamma") { Some(problem.number("gamma")?) } else { None };
    let found = shape_loop(&shaped, level)?;
    let whole = chain(behind.as_ref(), found.controller.clone(), before.as_ref()).map_err(misfit)?;
    let answer = Answer::new()
        .with_number("margin", found.gamma_opt.recip())
        .with_number("gamma_opt", found.gamma_opt)
        .with_number("gamma", found.gamma)
        .with_number("closed_loop_norm", found.closed_loop_norm)
        .with_number("peak_freq_rad_s", clock.true_frequency(found.closed_loop_peak_rad_s))
        .with("controller", clock.answer(&whole)?)
        .with("shaped_controller", clock.answer(&found.controller)?)
        .with_number("x_residual", found.residuals[0])
        .with_number("z_residual", found.residuals[1]);
    Ok(match clock.0 {
        // The growth rate of the w plane is no distance from the unit circle.
        Some(_) => answer,
        None => clock.with_stability(answer, found.growth_rate),
    })
}
