//! `muspin init DIR`: a commented spindle, tool, weights and measurement that run as they are. `muspin example NAME`:
//! the files of a worked case, with the guide that goes through it.

use super::Failure;
use super::console::{CommandEnd, Console};
use super::start::{DIAGNOSE_LIST, PID, Truth, UPDATE_LIST, add_machine, add_measurement};
use crate::report::manifest::Manifest;
use crate::report::results::ResultsFolder;
use clap::ValueEnum;
use serde_json::json;
use std::path::Path;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Folder for the files; nothing that exists is replaced
    folder: String,
}

#[derive(clap::Args, Debug)]
pub(super) struct ExampleArguments {
    /// Which case
    #[arg(value_enum)]
    name: Example,
    /// Folder for the files [default: the name of the example]
    folder: Option<String>,
}

/// Worked cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Example {
    /// A machine of your own: check, modes, updating, design
    OwnRotor,
    /// A model that has the measured frequencies
    Update,
    /// Controllers side by side, with a given PID
    Compare,
    /// What is missing in the model
    Diagnose,
    /// A controller in the firmware
    Firmware,
    /// A plant of your own in the solvers
    Solve,
}

impl Example {
    fn guide(self) -> &'static str {
        match self {
            Self::OwnRotor => include_str!("../guide/start.md"),
            Self::Update => include_str!("../guide/updating.md"),
            Self::Compare => include_str!("../guide/comparison.md"),
            Self::Diagnose => include_str!("../guide/diagnosis.md"),
            Self::Firmware => include_str!("../guide/firmware.md"),
            Self::Solve => include_str!("../guide/solvers.md"),
        }
    }

    /// Everything besides the guide.
    fn stage(self, folder: &mut ResultsFolder) -> Result<(), Failure> {
        if self != Self::Solve {
            add_machine(folder)?;
        }
        match self {
            Self::OwnRotor | Self::Update => {
                add_measurement(folder, UPDATE_LIST, Truth::OtherModuli)?;
            }
            Self::Diagnose => add_measurement(folder, DIAGNOSE_LIST, Truth::EddyCurrents)?,
            Self::Compare => folder.add("pid.json", PID)?,
            Self::Firmware => {
                folder.add("pid.json", PID)?;
                folder.add("main.c", include_str!("examples/main.c"))?;
            }
            Self::Solve => {
                for (name, text) in PROBLEMS {
                    folder.add(name, text)?;
                }
            }
        }
        Ok(())
    }
}

/// Shipped examples: name and text.
macro_rules! examples {
    ($($name:literal)*) => { [$(($name, include_str!(concat!("examples/", $name)))),*] };
}

const PROBLEMS: [(&str, &str); 12] = examples! {
    "hinfsyn.json" "mu.json" "hinfnorm.json" "care.json" "dare.json" "h2norm.json"
    "h2syn.json" "lqg.json" "ncfsyn.json" "diskmargin.json" "augw.json" "mixsyn.json"
};

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    write(Example::OwnRotor, &arguments.folder, console)
}

pub(super) fn run_example(arguments: &ExampleArguments, console: &Console) -> Result<CommandEnd, Failure> {
    let name = arguments.name.to_possible_value().map(|value| value.get_name().to_owned());
    write(arguments.name, arguments.folder.as_ref().or(name.as_ref()).map_or("", String::as_str), console)
}

/// An example stands beside nothing else of muspin: its files would replace those of the same name.
fn refuse_other_files(target: &str) -> Result<(), Failure> {
    let written = Manifest::read(Path::new(target)).map_err(|error| Failure::new(format!("{target}: {error}")))?;
    match written.paths().next() {
        None => Ok(()),
        Some(first) => {
            Err(Failure::new(format!("{target}: muspin has written files there already, {first} and others"))
                .with_hint("choose another folder; nothing was replaced"))
        }
    }
}

fn write(example: Example, target: &str, console: &Console) -> Result<CommandEnd, Failure> {
    console.claim(target, &["README.md"], &[])?;
    refuse_other_files(target)?;
    let mut folder = ResultsFolder::new();
    folder.add("README.md", example.guide())?;
    example.stage(&mut folder)?;
    console.writing(|| folder.write(Path::new(target)))?;
    let answer = json!({
        "folder": target,
        "files": folder.files().map(|(path, _)| path).collect::<Vec<_>>(),
    });
    Ok(CommandEnd::done("files that run as they are; change them to yours")
        .answer(&answer)
        .file(target)
        .next(format!("cd {target}"))
        .next("README.md has the commands in their order"))
}
