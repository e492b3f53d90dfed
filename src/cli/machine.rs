//! The machine of a command, and on standard error what looks wrong in its files.

use super::Failure;
use crate::input::kind::FileKind;
use crate::input::{self, Measurement, NO_TOOL, Warning, load_rotor};
use crate::rotor::PlanarModes;
use crate::spindle::band::modes_left_out;
use crate::spindle::halved::Meshed;
use crate::spindle::mesh_quality::{CoarseMesh, coarse_mesh};
use crate::spindle::{Machine, RotorOnSupports};

/// Warnings that are held back until it is known whether the loop is stable, because that is said in the first line.
/// They go to standard error when the value is dropped, so that none is lost on the way to an error.
#[derive(Debug, Default)]
pub(super) struct Remarks(pub Vec<Warning>);

impl Drop for Remarks {
    fn drop(&mut self) {
        self.0.iter().for_each(say);
    }
}

/// The machine of a spindle and a tool file.
pub(super) fn load_machine(spindle: &str, tool: &str) -> Result<Machine, Failure> {
    let (machine, _said_on_return) = load_with_remarks(spindle, tool)?;
    Ok(machine)
}

/// The machine of a spindle and a tool file, and what looks wrong in them.
pub(super) fn load_with_remarks(spindle: &str, tool: &str) -> Result<(Machine, Remarks), Failure> {
    let machine = input::load_machine(spindle, tool)?;
    let mut remarks = Remarks::default();
    let files = [(FileKind::Spindle, spindle), (FileKind::Tool, tool)];
    for (kind, file) in files.into_iter().filter(|(_, file)| *file != NO_TOOL) {
        remarks.0.extend(kind.warnings(file)?);
    }
    remarks.0.extend(model_warnings(&machine, spindle, tool)?);
    Ok((machine, remarks))
}

/// A rotor without magnets, with a tool where one is named, and on standard error what looks wrong in its file.
pub(super) fn load_rotor_said(file: &str, tool: Option<&str>) -> Result<RotorOnSupports, Failure> {
    let rotor = load_rotor(file, tool.filter(|name| *name != NO_TOOL))?;
    FileKind::Rotor.warnings(file)?.iter().for_each(say);
    Ok(rotor)
}

/// Spindle and tool of a measurement, which the command line may replace.
#[derive(clap::Args, Debug, Default)]
pub(super) struct MeasuredMachine {
    /// Spindle file or shipped name; default: that of the measurement
    #[arg(long)]
    pub spindle: Option<String>,
    /// Tool file or shipped name; default: that of the measurement
    #[arg(long)]
    pub tool: Option<String>,
}

impl MeasuredMachine {
    pub(super) fn files<'a>(&'a self, measurement: &'a Measurement) -> (&'a str, &'a str) {
        let Self { spindle, tool } = self;
        (spindle.as_ref().unwrap_or(&measurement.spindle), tool.as_ref().unwrap_or(&measurement.tool))
    }

    pub(super) fn load(&self, measurement: &Measurement) -> Result<Machine, Failure> {
        let (spindle, tool) = self.files(measurement);
        load_machine(spindle, tool)
    }

    /// The rotor without magnets, of which the records must not need any.
    pub(super) fn load_rotor(&self, measurement: &Measurement) -> Result<RotorOnSupports, Failure> {
        let (spindle, tool) = self.files(measurement);
        let sweeps = measurement.sweeps.iter().map(|s| &s.record.name);
        let levitated = measurement.hammers.iter().filter(|h| h.controller.is_some()).map(|h| &h.name);
        if let Some(record) = sweeps.chain(levitated).next() {
            return Err(Failure::new(format!("{record}: {spindle} is a rotor without magnets, none levitates it"))
                .with_hint("take the spindle file with its bearings, or hammer tests without a controller"));
        }
        load_rotor_said(spindle, Some(tool))
    }
}

/// Says a warning on standard error.
pub(super) fn say(warning: &Warning) {
    eprintln!("{warning}");
}

/// Relative error of a kept frequency that is said: half the smallest uncertainty that frequencies are usually
/// specified with.
const KEPT_ERROR: f64 = 0.005;
/// The same of a measured one that moduli do not explain: some of what two ways of reading the same peak differ by.
const MEASURED_ERROR: f64 = 5e-4;

/// What the design model does not show of its machine: modes that its elements are too long for, and modes in the band
/// that it does not keep.
pub(super) fn model_warnings(machine: &Machine, spindle: &str, tool: &str) -> Result<Vec<Warning>, Failure> {
    let mut found: Vec<Warning> = mesh_warning(machine, spindle, tool)?.into_iter().collect();
    found.extend(modes_left_out(machine)?.map(|modes| Warning {
        file: spindle.to_owned(),
        message: format!(
            "rotor.flexible_modes: {} leaves out {} of the free shaft below {:.0} Hz, from mode {} with {:.0} Hz on, \
             where a controller still acts; keep {}",
            machine.spindle.flexible_modes,
            if modes.frequency_hz.len() == 1 {
                "a mode".to_owned()
            } else {
                format!("{} modes", modes.frequency_hz.len())
            },
            modes.to_hz,
            modes.first,
            modes.frequency_hz.first().copied().unwrap_or_default(),
            machine.spindle.flexible_modes + modes.frequency_hz.len()
        ),
    }));
    Ok(found)
}

/// What the mesh does not resolve of the modes that the model keeps.
fn mesh_warning(machine: &Machine, spindle: &str, tool: &str) -> Result<Option<Warning>, Failure> {
    let coarse = coarse_mesh(machine, machine.spindle.flexible_modes, KEPT_ERROR)?;
    Ok(coarse.map(|coarse| mesh_words(&coarse, spindle, tool)))
}

/// What the mesh does not resolve of the modes up to a measured frequency, unless it has been said of the kept ones.
pub(super) fn measured_mesh_warning(
    machine: &Machine,
    spindle: &str,
    tool: &str,
    to_hz: f64,
) -> Result<Option<Warning>, Failure> {
    if mesh_warning(machine, spindle, tool)?.is_some() {
        return Ok(None);
    }
    coarse_up_to(machine, [spindle, tool], to_hz)
}

/// What the mesh does not resolve of the modes up to a frequency.
pub(super) fn coarse_up_to(
    meshed: &impl Meshed,
    [spindle, tool]: [&str; 2],
    to_hz: f64,
) -> Result<Option<Warning>, Failure> {
    let frequencies = PlanarModes::new(&meshed.assembled()?)?.flexible_hz();
    let measured = frequencies.iter().filter(|f| **f <= to_hz).count();
    let coarse = coarse_mesh(meshed, measured, MEASURED_ERROR)?;
    Ok(coarse.map(|coarse| mesh_words(&coarse, spindle, tool)))
}

fn mesh_words(coarse: &CoarseMesh, spindle: &str, tool: &str) -> Warning {
    let (file, list) = if coarse.in_tool { (tool, "elements") } else { (spindle, "rotor.elements") };
    Warning {
        file: file.to_owned(),
        message: format!(
            "{list}[{}]: an element of {} m is too long for mode {}, whose frequency is {:.2} % off; split it",
            coarse.element,
            coarse.length_m,
            coarse.mode,
            100.0 * coarse.relative_error
        ),
    }
}
