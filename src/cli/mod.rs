//! Arguments, commands, progress. Standard output carries data, standard error progress and errors.
//! Exit 0 done; 1 done but a target is missed; 2 error, nothing written.

pub mod failure;
pub mod progress;

mod batch;
mod check;
mod compare;
mod contact;
mod controlled_machine;
mod design;
mod design_arguments;
mod design_progress;
mod design_variants;
mod diagnose;
mod export;
mod frf;
mod identify;
mod machine;
mod modes;
mod output;
mod plausibility;
mod report;
mod run;
mod simulate;
mod solve;
mod stdout;
mod timings;
mod update;

use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
pub use failure::Failure;
use std::process::ExitCode;

/// How a command ended when it ended without an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done, every target met.
    Done,
    /// Done, but a target is missed.
    TargetMissed,
}

#[derive(Parser)]
#[command(
    name = "muspin",
    version,
    about = "From spindle drawing and measured sweeps to a magnetic-bearing controller that firmware can load"
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// The whole pipeline on the reference spindle, or on the given files
    Run(run::Arguments),
    /// Natural frequencies of the free-free rotor with its tool, over speed (JSON)
    Modes(modes::Arguments),
    /// Open-loop frequency responses, or the closed-loop tool compliance (CSV)
    Frf(frf::Arguments),
    /// Measured sweeps to FRFs, resonances and antiresonances (JSON)
    Identify(identify::Arguments),
    /// Move the element moduli until resonances and antiresonances match
    Update(update::Arguments),
    /// D-K iteration, reduction, discretisation, export
    Design(design::Arguments),
    /// Dynamic stiffness of controllers and measurements side by side
    Compare(compare::Arguments),
    /// Time response with force law, limits and clearance
    Simulate(simulate::Arguments),
    /// Firmware tables of a controller
    Export(export::Arguments),
    /// Find the missing effect, name it, add it to the model
    Diagnose(diagnose::Arguments),
    /// A design per tool and a table over all
    Batch(batch::Arguments),
    /// Validate files, run nothing
    Check(check::Arguments),
    /// Rebuild report.html of a results folder
    Report(report::Arguments),
    /// Solve a problem of your own: care, hinfnorm, hinfsyn, mu, musys, dfit, dksyn, reduce, discretise
    Solve(solve::Arguments),
}

/// Runs the program on the process arguments and maps the outcome to the exit code.
pub fn main() -> ExitCode {
    let parsed = Cli::command().try_get_matches().and_then(|matches| {
        let files = files(&matches);
        Ok((Cli::from_arg_matches(&matches)?, files))
    });
    let (cli, files) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    let result = match cli.command {
        None => run::run(&run::Arguments::default()),
        Some(Command::Run(a)) => run::run(&a),
        Some(Command::Modes(a)) => modes::run(&a),
        Some(Command::Frf(a)) => frf::run(&a),
        Some(Command::Identify(a)) => identify::run(&a),
        Some(Command::Update(a)) => update::run(&a),
        Some(Command::Design(a)) => design::run(&a),
        Some(Command::Compare(a)) => compare::run(&a),
        Some(Command::Simulate(a)) => simulate::run(&a),
        Some(Command::Export(a)) => export::run(&a),
        Some(Command::Diagnose(a)) => diagnose::run(&a),
        Some(Command::Batch(a)) => batch::run(&a),
        Some(Command::Check(a)) => check::run(&a),
        Some(Command::Report(a)) => report::run(&a),
        Some(Command::Solve(a)) => solve::run(&a),
    };
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::TargetMissed) => ExitCode::from(1),
        Err(failure) => {
            eprint!("{}", failure.naming(&files));
            ExitCode::from(2)
        }
    }
}

/// Arguments that are input files or folders.
const FILES: [&str; 7] = [
    "spindle",
    "tool",
    "weights",
    "measurement",
    "controller",
    "tools",
    "file",
];

/// The input files that were given on the command line, not those of the defaults.
fn files(matches: &ArgMatches) -> Vec<String> {
    let Some((_, command)) = matches.subcommand() else {
        return vec![];
    };
    let given = |id: &&str| {
        // Only ids that the command has may be asked for.
        command.ids().any(|known| known.as_str() == *id)
            && command.value_source(id) == Some(ValueSource::CommandLine)
    };
    let values = FILES
        .iter()
        .filter(|id| given(id))
        .filter_map(|id| command.try_get_raw(id).ok()?);
    values
        .flatten()
        .map(|v| v.to_string_lossy().into_owned())
        .collect()
}
