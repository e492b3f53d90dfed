//! `muspin check`: reads and validates files, runs nothing. The kind of a file shows in its keys.

use super::plausibility::Records;
use super::{Failure, Outcome, stdout};
use crate::input::kind::FileKind;
use crate::input::{
    InputError, load_controller, load_measurement, load_spindle, load_tool, load_weights,
};
use crate::spindle::{Machine, Spindle};

/// Arguments of `muspin check`.
#[derive(clap::Args, Debug)]
pub struct Arguments {
    /// Files: spindles, tools, weights, controllers, measurement folders
    #[arg(required = true)]
    files: Vec<String>,
    /// Spindle whose materials and regions tools are checked against; the first spindle among the files wins
    #[arg(long, default_value = "reference")]
    spindle: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let mut partner: Option<Spindle> = None;
    let mut found = vec![];
    for file in &arguments.files {
        let kind = FileKind::of(file)?;
        if kind == FileKind::Spindle {
            partner.get_or_insert(load_spindle(file)?);
        }
        found.push((file, kind));
    }
    let partner = match partner {
        Some(spindle) => spindle,
        None => load_spindle(&arguments.spindle)?,
    };
    let has_tool = found.iter().any(|(_, kind)| *kind == FileKind::Tool);
    let mut implausible: Vec<&String> = vec![];
    for (file, kind) in &found {
        match kind {
            // Its effects may name regions of the tool: with a tool among the files both are checked together below.
            FileKind::Spindle if has_tool => {}
            FileKind::Spindle => check_alone(file)?,
            FileKind::Tool => {
                let tool = load_tool(file, &partner)?;
                Machine::new(partner.clone(), tool).map_err(|e| InputError::rule(file, &e))?;
            }
            FileKind::Weights => {
                load_weights(file)?;
            }
            FileKind::Controller => {
                load_controller(file)?;
            }
            FileKind::Measurement => {
                if !check_measurement(file)? {
                    implausible.push(file);
                }
            }
        }
    }
    stdout::data(|out| {
        for (file, kind) in &found {
            let verdict = if implausible.contains(file) {
                "implausible"
            } else {
                "ok"
            };
            writeln!(out, "{file}: {} {verdict}", kind.name())?;
        }
        Ok(())
    })?;
    Ok(if implausible.is_empty() {
        Outcome::Done
    } else {
        Outcome::TargetMissed
    })
}

/// A spindle with the shipped tool. Positions on a longer tool and regions of another tool need that tool among the files.
fn check_alone(file: &str) -> Result<(), Failure> {
    let tool = load_tool("paper-tool", &load_spindle("reference")?)?;
    Machine::new(load_spindle(file)?, tool).map_err(|e| {
        InputError::rule(file, &e).with_hint("name the tool as well if the effect sits on it")
    })?;
    Ok(())
}

/// True when every record is plausible.
fn check_measurement(folder: &str) -> Result<bool, Failure> {
    let measurement = load_measurement(folder)?;
    let machine = measurement.machine(None, None)?;
    let sweeps = measurement.sweeps.iter().map(|s| &s.controller);
    let hammers = measurement.hammers.iter().map(|h| &h.controller);
    for controller in sweeps.chain(hammers).flatten() {
        load_controller(controller)?;
    }
    let records = Records::of(&measurement, &machine)?;
    records.say();
    Ok(records.plausible())
}
