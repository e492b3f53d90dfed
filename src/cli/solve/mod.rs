//! `muspin solve <kind> FILE.json`: a user's own plant in, one JSON object out.
//! A problem without a solution, or one that violates an assumption, is exit 2 with the reason and no JSON.

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

use super::console::{CommandEnd, Console};
use super::{Failure, Outcome};
use crate::input::problem::ProblemFields;
use crate::input::problem_keys::check_keys;
use crate::input::problem_schema::ProblemKind;
pub(crate) use answer::Answer;
use clap::builder::PossibleValue;
use std::path::PathBuf;

/// Arguments of `muspin solve`.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// What to solve
    #[arg(value_enum)]
    kind: ProblemKind,
    /// JSON file with the problem, in `data` or at the top level
    file: PathBuf,
}

impl clap::ValueEnum for ProblemKind {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(self.title()))
    }
}

/// The answer to a problem.
///
/// # Errors
/// [`Failure`] with the reason why there is none.
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

/// Runs the command.
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let answer = answer_problem(&ProblemFields::read(&arguments.file)?, arguments.kind)?;
    for note in answer.notes() {
        eprintln!("note: {note}");
    }
    let text = answer.text();
    console.json(&text, || {
        let mut words = format!("{}: the matrices are in --json", arguments.file.display());
        for remark in answer.remarks() {
            words.push_str(&format!("; {remark}"));
        }
        CommandEnd::done(words).rows(answer.numbers())
    })?;
    Ok(Outcome::Done)
}
