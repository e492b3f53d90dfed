//! `muspin solve <kind> FILE.json`: a user's own plant in, one JSON object out.
//! A problem without a solution, or one that violates an assumption, is exit 2 with the reason and no JSON.

use super::Failure;
use super::console::CommandEnd;
use crate::input::problem::ProblemFields;
use crate::input::problem_schema::ProblemKind;
use crate::workflow::solve::answer_problem;
use clap::builder::PossibleValue;
use std::path::PathBuf;

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

pub(super) fn run(arguments: &Arguments) -> Result<CommandEnd, Failure> {
    let answer = answer_problem(&ProblemFields::read(&arguments.file)?, arguments.kind)?;
    for note in answer.notes() {
        eprintln!("note: {note}");
    }
    let mut words = format!("{}: the matrices are in --json", arguments.file.display());
    for remark in answer.remarks() {
        words.push_str(&format!("; {remark}"));
    }
    Ok(CommandEnd::done(words).json(answer.text()).rows(answer.numbers()))
}
