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

use super::console::{Console, Shown};
use super::{Failure, Outcome};
use crate::input::problem::Problem;
use answer::Answer;
use std::path::PathBuf;

/// Arguments of `muspin solve`.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// What to solve
    #[arg(value_enum)]
    kind: Kind,
    /// JSON file with the problem, in `data` or at the top level
    file: PathBuf,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Kind {
    /// Stabilising solution of A'X + XA − XGX + Q = 0
    Care,
    /// L∞ norm of a stable system
    Hinfnorm,
    /// H∞ controller with optimal γ
    Hinfsyn,
    /// Structured singular value of a complex matrix
    Mu,
    /// Peak of μ over all frequencies of a stable system
    Musys,
    /// Stable minimum-phase fit of magnitudes
    Dfit,
    /// D-K iteration
    Dksyn,
    /// Model reduction
    Reduce,
    /// Discretisation by hold and by Tustin's rule
    Discretise,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let problem = Problem::read(&arguments.file)?;
    let answer: Answer = match arguments.kind {
        Kind::Care => care::solve(&problem),
        Kind::Hinfnorm => hinfnorm::solve(&problem),
        Kind::Hinfsyn => hinfsyn::solve(&problem),
        Kind::Mu => mu::solve(&problem),
        Kind::Musys => musys::solve(&problem),
        Kind::Dfit => dfit::solve(&problem),
        Kind::Dksyn => dksyn::solve(&problem),
        Kind::Reduce => reduce::solve(&problem),
        Kind::Discretise => discretise::solve(&problem),
    }?;
    let text = answer.text();
    console.json(&text, || {
        let words = format!("{}: the matrices are in --json", arguments.file.display());
        Shown::done(words).rows(answer.numbers())
    })?;
    Ok(Outcome::Done)
}
