//! The machine that a controller is closed with: what the command line says, else the files beside the controller, else
//! those that the controller names, else the shipped reference. Whether it is the machine of the design is said.

use super::Failure;
use super::machine::{Remarks, load_machine, load_with_remarks};
use crate::controller::{Controller, MachineTag};
use crate::input::correction::CORRECTION_FILE;
use crate::input::{Warning, load_tagged_controller, usual_tool, with_correction};
use crate::report::whole::machine_tag;
use crate::spindle::Machine;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

pub(super) struct ControlledMachine {
    pub machine: Machine,
    pub controller: Controller,
    /// What is used, as a tag; paths as they were found.
    pub used: MachineTag,
    /// What the controller was designed for, when its file says so.
    pub designed_for: Option<MachineTag>,
}

/// Spindle and tool of the command line: a path or a shipped name each.
#[derive(clap::Args, Debug, Clone, Default)]
pub(super) struct MachineArguments {
    /// Spindle file, or the name of a shipped one; default: spindle.yaml beside the controller or in the folder above
    /// it, else the reference
    #[arg(long)]
    pub spindle: Option<String>,
    /// Tool file, the name of a shipped one, or `none`; default: tool.yaml beside the controller or in the folder above
    /// it, else none for a spindle with `output_m` and the paper's for others
    #[arg(long)]
    pub tool: Option<String>,
    /// Law that a diagnosis recovered, correction.csv of its results, which the model then has beside its effects;
    /// default: correction.csv beside the controller or in the folder above it, else none
    #[arg(long)]
    pub correction: Option<String>,
}

/// Name of the shipped spindle.
pub(super) const SPINDLE: &str = "reference";

impl MachineArguments {
    /// Reads the controller and its machine. The remarks say what looks wrong in the files, and when the machine is not
    /// that of the design; drop them when the stability of the loop has been said.
    pub(super) fn with_controller(&self, file: &str) -> Result<(ControlledMachine, Remarks), Failure> {
        let loaded = load_tagged_controller(file)?;
        let tag = loaded.machine;
        let named = tag.as_ref();
        let found = |given: &Option<String>, usual: &str, named: Option<&str>| {
            given.clone().or_else(|| beside(file, usual, named))
        };
        let spindle = found(&self.spindle, "spindle.yaml", named.map(|t| t.spindle.as_str()));
        let spindle = spindle.unwrap_or_else(|| SPINDLE.to_owned());
        let tool = match found(&self.tool, "tool.yaml", named.map(|t| t.tool.as_str())) {
            Some(tool) => tool,
            None => usual_tool(&spindle)?.to_owned(),
        };
        let (machine, mut remarks) = load_with_remarks(&spindle, &tool)?;
        let correction = found(&self.correction, CORRECTION_FILE, None);
        let machine = correct(machine, correction.as_deref())?;
        let found = ControlledMachine {
            used: machine_tag(&machine, &spindle, &tool),
            controller: loaded.controller,
            designed_for: tag,
            machine,
        };
        let other = other_machine(file, found.designed_for.as_ref(), &found.used);
        remarks.0.extend(other);
        Ok((found, remarks))
    }

    /// The machine without a controller.
    pub(super) fn alone(&self) -> Result<Machine, Failure> {
        let spindle = self.spindle.as_deref().unwrap_or(SPINDLE);
        let machine = load_machine(spindle, self.tool.as_deref().map_or_else(|| usual_tool(spindle), Ok)?)?;
        correct(machine, self.correction.as_deref())
    }
}

impl ControlledMachine {
    /// Files and hash of the machine that is used.
    pub(super) fn used_machine(&self) -> Value {
        json!({
            "spindle": self.used.spindle,
            "tool": self.used.tool,
            "hash": self.used.hash,
            // Absent where the controller names no machine.
            "is_that_of_the_design": self.designed_for.as_ref().map(|tag| tag.hash == self.used.hash),
        })
    }
}

/// The machine with the law of a file.
fn correct(machine: Machine, file: Option<&str>) -> Result<Machine, Failure> {
    Ok(match file {
        Some(file) => with_correction(machine, file)?,
        None => machine,
    })
}

/// What to say of a controller whose tag names another machine than the one that is used.
pub(super) fn other_machine(file: &str, tag: Option<&MachineTag>, used: &MachineTag) -> Option<Warning> {
    tag.filter(|tag| tag.hash != used.hash).map(|_| Warning {
        file: file.to_owned(),
        message: format!(
            "the controller was designed for another machine than {} with {}: the hash in it differs",
            used.spindle, used.tool
        ),
    })
}

/// `usual` beside the controller file or in the folder above it, else the path that the file names.
fn beside(controller: &str, usual: &str, named: Option<&str>) -> Option<String> {
    let folder = Path::new(controller).parent().unwrap_or(Path::new(""));
    let above = if folder.as_os_str().is_empty() { PathBuf::from("..") } else { folder.join("..") };
    [Some(folder.join(usual)), Some(above.join(usual)), named.map(|n| folder.join(n))]
        .into_iter()
        .flatten()
        .find(|path| path.is_file())
        .map(|path| path.display().to_string())
}
