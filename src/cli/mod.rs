//! Arguments, commands, progress. A command reads, computes and writes its files; what it returns is said here, once
//! for all of them. Standard output carries data, standard error progress and errors.
//! Exit 0 done; 1 done but a target is missed; 2 error, nothing written.

pub(crate) mod progress;

mod batch;
mod batch_arguments;
mod batch_plan;
mod batch_variants;
mod check;
mod choices;
mod compare;
pub(crate) mod console;
mod controlled_machine;
mod design;
mod design_arguments;
mod design_progress;
mod diagnose;
mod earlier;
mod export;
mod fmu;
mod frf;
mod identify;
mod init;
mod interrupt;
mod machine;
mod modes;
mod pid;
mod reading;
mod rehearse;
mod report;
mod ross;
mod run;
mod schema;
mod shell;
mod simulate;
mod solve;
mod spectra;
mod speeds;
mod start;
mod stdout;
mod timings;
mod update;
mod version;

pub(crate) use crate::workflow::Failure;
use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use console::{CommandEnd, Console, ConsoleArguments};
use interrupt::Writing;
use std::ffi::OsString;
use std::process::ExitCode;

const WAYS_IN: &str = "Three ways in:
  muspin run                the example: from the reference spindle to firmware tables, in results/reference
  muspin init my-spindle    your own drawing: files to fill in that run as they are
  muspin modes --spindle my-spindle/spindle.yaml --tool my-spindle/tool.yaml
                            your own rotor: its natural frequencies; nothing is written";

#[derive(Parser)]
#[command(
    name = "muspin",
    version = version::text(),
    about = "From spindle drawing and measured sweeps to a magnetic-bearing controller that firmware can load",
    after_help = WAYS_IN
)]
struct Cli {
    #[command(flatten)]
    console: ConsoleArguments,
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
    /// Samples of force and response to a frequency response with coherence (CSV); modes of a free decay
    Spectra(spectra::Arguments),
    /// Measured sweeps to FRFs, resonances and antiresonances (JSON)
    Identify(identify::Arguments),
    /// Move the element moduli until resonances and antiresonances match
    Update(update::Arguments),
    /// D-K iteration, reduction, discretisation, export
    Design(design::Arguments),
    /// A PID, tuned or with given numbers: stability over speed, margins, stiffness, controller file
    Pid(pid::Arguments),
    /// Dynamic stiffness of controllers and measurements side by side
    Compare(compare::Arguments),
    /// Time response with force law, limits and clearance
    Simulate(simulate::Arguments),
    /// Firmware tables of a controller
    Export(export::Arguments),
    /// Find the missing effect, name it, add it to the model
    Diagnose(diagnose::Arguments),
    /// A design per tool and a table over all
    Batch(batch_arguments::Arguments),
    /// Validate files, run nothing
    Check(check::Arguments),
    /// Write a commented spindle, tool, weights and measurement that run as they are
    Init(init::Arguments),
    /// Write the files of a worked case: own-rotor, update, compare, diagnose, firmware, solve
    Example(init::ExampleArguments),
    /// A synthetic measurement with sensor noise, from a model
    Rehearse(rehearse::Arguments),
    /// A ROSS rotor file as a spindle file, or the shaft of a spindle as a ROSS rotor file
    Ross(ross::Arguments),
    /// Shell completions, to standard output
    Completions(shell::Completions),
    /// Manual page (roff), to standard output
    Man,
    /// JSON Schema of a kind of file, or the page of all keys
    Schema(schema::Arguments),
    /// Rebuild report.html of a results folder
    Report(report::Arguments),
    /// Solve a problem of your own: norms, Riccati equations, H∞, H2 and μ synthesis, margins, reduction, sampling
    Solve(solve::Arguments),
}

/// Runs the program on the process arguments and maps the outcome to the exit code.
pub fn main() -> ExitCode {
    ExitCode::from(run(std::env::args_os()))
}

/// Runs the program on arguments, its own name first; returns the exit code.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let parsed = Cli::command().try_get_matches_from(arguments).and_then(|matches| {
        let files = files(&matches);
        Ok((Cli::from_arg_matches(&matches)?, files))
    });
    let (cli, files) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => {
            let _ = error.print();
            return if error.use_stderr() { 2 } else { 0 };
        }
    };
    let writing = Writing::default();
    writing.answer_interruptions();
    let console = match Console::open(&cli.console, files, writing) {
        Ok(console) => console,
        Err(failure) => {
            eprint!("{failure}");
            return 2;
        }
    };
    // On a thread of the pool: what runs in parallel is shared out without waking the pool from outside.
    let result = rayon::scope(|_| carry_out(cli.command, &console));
    match result.and_then(|end| console.end(&end)) {
        Ok(met) => u8::from(!met),
        Err(failure) => {
            eprint!("{}", failure.naming(console.given_files()));
            2
        }
    }
}

fn carry_out(command: Option<Command>, console: &Console) -> Result<CommandEnd, Failure> {
    match command {
        None => Ok(shell::help()),
        Some(Command::Run(a)) => run::run(&a, console),
        Some(Command::Modes(a)) => modes::run(&a, console),
        Some(Command::Frf(a)) => frf::run(&a, console),
        Some(Command::Spectra(a)) => spectra::run(&a, console),
        Some(Command::Identify(a)) => identify::run(&a, console),
        Some(Command::Update(a)) => update::run(&a, console),
        Some(Command::Design(a)) => design::run(&a, console),
        Some(Command::Pid(a)) => pid::run(&a, console),
        Some(Command::Compare(a)) => compare::run(&a, console),
        Some(Command::Simulate(a)) => simulate::run(&a, console),
        Some(Command::Export(a)) => export::run(&a, console),
        Some(Command::Diagnose(a)) => diagnose::run(&a, console),
        Some(Command::Batch(a)) => batch::run(&a, console),
        Some(Command::Check(a)) => check::run(&a, console),
        Some(Command::Init(a)) => init::run(&a, console),
        Some(Command::Example(a)) => init::run_example(&a, console),
        Some(Command::Rehearse(a)) => rehearse::run(&a, console),
        Some(Command::Ross(a)) => ross::run(&a, console),
        Some(Command::Completions(a)) => Ok(shell::completions(&a)),
        Some(Command::Man) => shell::manual(),
        Some(Command::Schema(a)) => schema::run(&a),
        Some(Command::Report(a)) => report::run(&a, console),
        Some(Command::Solve(a)) => solve::run(&a),
    }
}

/// Arguments that are input files or folders.
const FILES: [&str; 8] = ["spindle", "tool", "weights", "measurement", "controller", "tools", "file", "time"];

/// The input files that were given on the command line, not those of the defaults.
fn files(matches: &ArgMatches) -> Vec<String> {
    let Some((_, command)) = matches.subcommand() else {
        return vec![];
    };
    let given = |id: &&str| {
        // Only ids that the command has may be asked for.
        command.ids().any(|known| known.as_str() == *id) && command.value_source(id) == Some(ValueSource::CommandLine)
    };
    let values = FILES.iter().filter(|id| given(id)).filter_map(|id| command.try_get_raw(id).ok()?);
    values.flatten().map(|v| v.to_string_lossy().into_owned()).collect()
}
