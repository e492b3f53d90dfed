//! `muspin check`: reads and validates files, runs nothing. The kind of a file shows in its keys. Every file is read,
//! so that one call tells all that is wrong; what only looks wrong is a warning.

use super::Failure;
use super::console::{CommandEnd, Console};
use super::machine::{MeasuredMachine, model_warnings, say};
use super::reading::ReadingProgress;
use crate::input::file::Watch;
use crate::input::hammer::{HammerKeys, load_hammer, load_mode_shapes};
use crate::input::kind::FileKind;
use crate::input::pid::load_pid;
use crate::input::quote::printable;
use crate::input::sweep::load_sweep;
use crate::input::{
    self, InputError, NO_TOOL, is_rotor, join_machine, load_controller, load_measurement_watched, load_rotor,
    load_spindle, load_tool, load_weights, uff, uff_frf,
};
use crate::spindle::Spindle;
use crate::workflow::plausibility::Records;
use serde_json::json;
use std::path::Path;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Files: spindles, tools, weights, controllers, PIDs, records, universal files, measurement folders
    #[arg(required = true)]
    files: Vec<String>,
    /// Spindle whose materials, regions and sample rate tools and PIDs are checked against; the first spindle among the
    /// files wins
    #[arg(long, default_value = "reference")]
    spindle: String,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let kinds: Vec<Result<FileKind, InputError>> = arguments.files.iter().map(|f| FileKind::of(f)).collect();
    let of_kind = |wanted: FileKind| {
        let pairs = arguments.files.iter().zip(&kinds);
        let mut found = pairs.filter(move |(_, k)| k.as_ref() == Ok(&wanted));
        found.next().map(|(file, _)| file.as_str())
    };
    let with_tool = of_kind(FileKind::Tool).is_some();
    let partner_file = of_kind(FileKind::Spindle).unwrap_or(&arguments.spindle);
    let partner = load_spindle(partner_file);
    let mut failures: Vec<Failure> = vec![];
    let mut lines: Vec<(String, &'static str, &'static str)> = vec![];
    let mut all_plausible = true;
    let reading = ReadingProgress::start(console);
    for (file, kind) in arguments.files.iter().zip(kinds) {
        let checked = kind.map_err(Failure::from).and_then(|kind| {
            let plausible = one(file, kind, with_tool, (partner_file, &partner), &|share| reading.see(share))?;
            kind.warnings(file)?.iter().for_each(say);
            Ok((kind, plausible))
        });
        match checked {
            Ok((kind, plausible)) => {
                let verdict = if plausible { "ok" } else { "implausible" };
                all_plausible &= plausible;
                lines.push((printable(file).into_owned(), kind.name(), verdict));
            }
            Err(failure) => failures.push(failure),
        }
    }
    drop(reading);
    let mut failures = failures.into_iter();
    if let Some(first) = failures.next() {
        return Err(first.with_further(failures));
    }
    let words = if all_plausible {
        match lines.len() {
            1 => "the file is right".to_owned(),
            files => format!("{files} files are right"),
        }
    } else {
        "a record contradicts its machine".to_owned()
    };
    let data = lines.iter().map(|(file, kind, verdict)| format!("{file}: {kind} {verdict}\n")).collect();
    let one = |(file, kind, verdict): &(String, &str, &str)| json!({ "file": file, "kind": kind, "verdict": verdict });
    let value = json!({ "files": lines.iter().map(one).collect::<Vec<_>>() });
    let rows = lines.into_iter().map(|(file, kind, verdict)| vec![file, kind.to_owned(), verdict.to_owned()]);
    Ok(CommandEnd::met(all_plausible, words).data(data, value).rows(rows))
}

type Partner<'a> = (&'a str, &'a Result<Spindle, InputError>);

/// Reads a file; false when it was read and its records are implausible.
fn one(file: &str, kind: FileKind, with_tool: bool, partner: Partner<'_>, watch: Watch<'_>) -> Result<bool, Failure> {
    let path = Path::new(file);
    match kind {
        // Its effects may name regions of the tool: with a tool among the files both are checked together.
        FileKind::Spindle if with_tool => drop(load_spindle(file)?),
        FileKind::Spindle => check_alone(file)?,
        FileKind::Rotor => drop(load_rotor(file, None)?),
        FileKind::Tool => {
            let (name, spindle) = partner;
            let spindle = spindle.clone()?;
            let tool = load_tool(file, &spindle)?;
            let machine = join_machine(file, spindle, tool)?;
            model_warnings(&machine, name, file)?.iter().for_each(say);
        }
        FileKind::Weights => drop(load_weights(file)?),
        FileKind::Controller | FileKind::Mat => drop(load_controller(file)?),
        FileKind::Measurement => return check_measurement(file, watch),
        FileKind::Sweep => drop(load_sweep(path, 0.0, watch)?),
        FileKind::Hammer => drop(load_hammer(path, &HammerKeys::default(), watch)?),
        FileKind::ModeShapes => drop(load_mode_shapes(path, watch)?),
        FileKind::Universal => drop(uff_frf::frfs(file, &uff::load(file)?)?),
        FileKind::Pid => drop(load_pid(file, partner.1.clone()?.electronics.sample_rate_hz)?),
    }
    Ok(true)
}

/// A spindle with the shipped tool. Positions on a longer tool and regions of another tool need that tool among the
/// files.
fn check_alone(file: &str) -> Result<(), Failure> {
    let spindle = load_spindle(file)?;
    let machine = if spindle.output_m.is_some() {
        input::load_machine(file, NO_TOOL)?
    } else {
        join_machine(file, spindle, load_tool("paper-tool", &load_spindle("reference")?)?)
            .map_err(|e| e.with_hint("name the tool as well if the effect sits on it"))?
    };
    model_warnings(&machine, file, "paper-tool")?.iter().for_each(say);
    Ok(())
}

/// A measurement folder, or the list in it; true when every record is plausible.
fn check_measurement(source: &str, watch: Watch<'_>) -> Result<bool, Failure> {
    let path = Path::new(source);
    let is_list = path.file_name().is_some_and(|name| name == "measurement.yaml");
    let folder = match path.parent() {
        Some(parent) if is_list && parent.as_os_str().is_empty() => ".".to_owned(),
        Some(parent) if is_list => parent.display().to_string(),
        _ => source.to_owned(),
    };
    let measurement = load_measurement_watched(&folder, watch)?;
    if is_rotor(&measurement.spindle) {
        MeasuredMachine::default().load_rotor(&measurement)?;
        return Ok(true);
    }
    let machine = measurement.machine(None, None)?;
    let sweeps = measurement.sweeps.iter().map(|s| &s.controller);
    let hammers = measurement.hammers.iter().map(|h| &h.controller);
    for controller in sweeps.chain(hammers).flatten() {
        load_controller(controller)?;
    }
    let records = Records::of(&measurement, Some(&machine), &|| {})?;
    records.lines().for_each(|line| eprintln!("{line}"));
    Ok(records.plausible())
}
