//! Problems of a user's own, each answered by one JSON object; a problem without a solution, or one that violates an
//! assumption, by the reason.

mod answer;
mod care;
mod clock;
mod dfit;
mod discretise;
mod diskmargin;
mod dksyn;
mod h2norm;
mod h2syn;
mod hinfnorm;
mod hinfsyn;
mod mixsyn;
mod mu;
mod musys;
mod ncfsyn;
mod reduce;

use super::failure::Failure;
use crate::input::problem::ProblemFields;
use crate::input::problem_keys::check_keys;
use crate::input::problem_schema::ProblemKind;
pub(crate) use answer::Answer;

pub(crate) fn answer_problem(problem: &ProblemFields, kind: ProblemKind) -> Result<Answer, Failure> {
    check_keys(problem, kind)?;
    let answer = match kind {
        ProblemKind::Care => care::solve(problem),
        ProblemKind::Dare => care::solve_sampled(problem),
        ProblemKind::H2norm => h2norm::solve(problem),
        ProblemKind::Hinfnorm => hinfnorm::solve(problem),
        ProblemKind::Hinfsyn => hinfsyn::solve(problem),
        ProblemKind::Augw => mixsyn::augment(problem),
        ProblemKind::Mixsyn => mixsyn::solve(problem),
        ProblemKind::H2syn => h2syn::solve(problem),
        ProblemKind::Lqg => h2syn::solve_lqg(problem),
        ProblemKind::Ncfsyn => ncfsyn::solve(problem),
        ProblemKind::Diskmargin => diskmargin::solve(problem),
        ProblemKind::Mu => mu::solve(problem),
        ProblemKind::Musys => musys::solve(problem),
        ProblemKind::Dfit => dfit::solve(problem),
        ProblemKind::Dksyn => dksyn::solve(problem),
        ProblemKind::Reduce => reduce::solve(problem),
        ProblemKind::Discretise => discretise::solve(problem),
    }?;
    let states = problem.has("A").then(|| problem.square("A")).transpose()?.map_or(0, |a| a.nrows());
    // Where A and B were divided by a descriptor, how well that could be done.
    Ok(match problem.descriptor(states)? {
        Some((_, condition)) => answer.with_number("descriptor_rcond", condition),
        None => answer,
    })
}
