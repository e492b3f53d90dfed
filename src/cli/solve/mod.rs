//! `muspin solve <kind> FILE.json`: a user's own plant in, one JSON object out.
//! A problem without a solution, or one that violates an assumption, is exit 2 with the reason and no JSON.

mod answer;
mod care;
mod dfit;
mod discretise;
mod dksyn;
mod hinfnorm;
mod hinfsyn;
mod mu;
mod musys;
mod reduce;

use super::console::{CommandEnd, Console};
use super::{Failure, Outcome};
use crate::input::problem::ProblemFields;
use crate::input::problem_keys::check_keys;
use crate::input::problem_schema::ProblemKind;
use answer::Answer;
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

/// Runs the command.
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let problem = ProblemFields::read(&arguments.file)?;
    check_keys(&problem, arguments.kind)?;
    let answer: Answer = match arguments.kind {
        ProblemKind::Care => care::solve(&problem),
        ProblemKind::Hinfnorm => hinfnorm::solve(&problem),
        ProblemKind::Hinfsyn => hinfsyn::solve(&problem),
        ProblemKind::Mu => mu::solve(&problem),
        ProblemKind::Musys => musys::solve(&problem),
        ProblemKind::Dfit => dfit::solve(&problem),
        ProblemKind::Dksyn => dksyn::solve(&problem),
        ProblemKind::Reduce => reduce::solve(&problem),
        ProblemKind::Discretise => discretise::solve(&problem),
    }?;
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
