//! `muspin check`: reads and validates files, runs nothing. The kind of a file shows in its keys.

use super::{Failure, Outcome, stdout};
use crate::input::{InputError, load_controller, load_spindle, load_tool, load_weights, shipped};
use crate::spindle::{Machine, Spindle};
use std::path::Path;

/// Arguments of `muspin check`.
#[derive(clap::Args, Debug)]
pub struct Arguments {
    /// Files: spindles, tools, weights, controllers, measurement folders
    #[arg(required = true)]
    files: Vec<String>,
    /// Spindle whose materials and regions the tools are checked against
    #[arg(long, default_value = "reference")]
    spindle: String,
}

/// What a file is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Spindle,
    Tool,
    Weights,
    Controller,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Spindle => "spindle",
            Self::Tool => "tool",
            Self::Weights => "weights",
            Self::Controller => "controller",
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let mut partner: Option<Spindle> = None;
    let mut found = vec![];
    for file in &arguments.files {
        let kind = kind(file)?;
        // The first spindle among the files lends its materials to the tools that follow.
        if kind == Kind::Spindle {
            let spindle = load_spindle(file)?;
            partner.get_or_insert(spindle);
        }
        found.push((file, kind));
    }
    let partner = match partner {
        Some(spindle) => spindle,
        None => load_spindle(&arguments.spindle)?,
    };
    for (file, kind) in &found {
        match kind {
            // A spindle's effects may name regions of its tool: checked below, when a tool is given.
            Kind::Spindle => {}
            Kind::Tool => {
                let tool = load_tool(file, &partner)?;
                Machine::new(partner.clone(), tool).map_err(|e| InputError::rule(file, &e))?;
            }
            Kind::Weights => {
                load_weights(file)?;
            }
            Kind::Controller => {
                load_controller(file)?;
            }
        }
    }
    stdout::data(|out| {
        for (file, kind) in &found {
            writeln!(out, "{file}: {} ok", kind.name())?;
        }
        Ok(())
    })?;
    Ok(Outcome::Done)
}

fn kind(file: &str) -> Result<Kind, Failure> {
    let listed = |list: &[shipped::Shipped]| {
        !Path::new(file).is_file() && list.iter().any(|s| s.name == file)
    };
    if listed(shipped::SPINDLES) {
        return Ok(Kind::Spindle);
    }
    if listed(shipped::TOOLS) {
        return Ok(Kind::Tool);
    }
    if listed(shipped::WEIGHTS) {
        return Ok(Kind::Weights);
    }
    let text = shipped::text(file, "input", &[])?;
    if text.trim_start().starts_with('{') && file.to_lowercase().ends_with(".json") {
        return Ok(Kind::Controller);
    }
    let has = |key: &str| {
        let start = format!("{key}:");
        text.lines().any(|line| line.starts_with(&start))
    };
    if has("rotor") || has("bearings") {
        Ok(Kind::Spindle)
    } else if has("tool_plane_m") || has("elements") {
        Ok(Kind::Tool)
    } else if has("mode_uncertainty") || has("front") {
        Ok(Kind::Weights)
    } else {
        Err(Failure::new(format!("{file}: is not a file that muspin knows")).with_hint(
            "a spindle has `rotor:`, a tool `tool_plane_m:`, weights `mode_uncertainty:`, a controller is JSON",
        ))
    }
}
