//! `muspin ross`: the rotor of a ROSS file as a spindle file that asks for what ROSS does not say, and the shaft of a
//! spindle with its tool as a file that ROSS loads.

use super::Failure;
use super::console::{CommandEnd, Console};
use super::machine::load_machine;
use crate::controller::Controller;
use crate::export::json::controller_json;
use crate::export::ross::{ross_rotor, shaft_without_effects};
use crate::input::ross::{RossBearing, RossRotor, read_ross};
use crate::input::ross_magnet::pid_controller;
use crate::input::ross_parts::parts;
use crate::input::shipped;
use crate::input::tool_yaml;
use crate::linalg::NumericError;
use crate::report::results::ResultsFolder;
use crate::report::ross_spindle::spindle_draft;
use crate::rotor::{PlanarModes, Rotor};
use crate::spindle::SpindleError;
use serde_json::json;
use std::path::Path;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Rotor file that ROSS has saved (TOML or JSON); without it the shaft of --spindle and --tool is written for ROSS
    file: Option<String>,
    /// Position of the nose face from the left end, m, a node: what lies before it becomes the tool
    #[arg(long, default_value_t = 0.0, requires = "file")]
    nose_face_m: f64,
    /// The nose is at the right end of the ROSS rotor
    #[arg(long, requires = "file")]
    reverse: bool,
    /// Spindle file, or the name of a shipped one
    #[arg(long, default_value = "reference", conflicts_with = "file")]
    spindle: String,
    /// Tool file, or the name of a shipped one
    #[arg(long, default_value = "paper-tool", conflicts_with = "file")]
    tool: String,
    /// Folder for spindle.yaml (and tool.yaml), or for rotor.toml and rotor.json
    #[arg(long, default_value = "results/ross")]
    out: String,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    match &arguments.file {
        Some(file) => import(arguments, file, console),
        None => export(arguments, console),
    }
}

/// Free-free bending modes that are listed, for a comparison with the other program.
const LISTED: usize = 4;

fn import(arguments: &Arguments, file: &str, console: &Console) -> Result<CommandEnd, Failure> {
    let read = read_ross(file, &shipped::text(file, "ROSS", &[])?)?;
    let rotor = if arguments.reverse { read.reverse_ends() } else { read };
    let out = arguments.out.as_str();
    console.claim(out, &["spindle.yaml", "controller.json"], &[])?;
    let nose_m = arguments.nose_face_m;
    let parts = parts(&rotor, nose_m).map_err(|next_m| {
        Failure::new(format!(
            "{file}: --nose-face-m {nose_m}: there is no node with elements behind it; the next one is at {next_m:.6} m"
        ))
        .with_hint("the nose face lies where two elements meet; its distance counts from the left end")
    })?;
    let whole =
        Rotor::new(0.0, rotor.sections.clone(), &rotor.discs).map_err(|e| Failure::new(format!("{file}: {e}")))?;
    let modes = PlanarModes::new(&whole).map_err(|e| Failure::new(format!("{file}: {e}")))?;
    let hz: Vec<f64> = modes.flexible_hz().into_iter().take(LISTED).collect();
    let stem = Path::new(file).file_stem().map(|s| s.to_string_lossy());
    let name = stem.as_deref().unwrap_or("spindle");
    let shaft = (parts.sections.as_slice(), parts.discs.as_slice());
    let draft = spindle_draft(name, shaft.0, shaft.1, &rotor, arguments.nose_face_m);
    let mut folder = ResultsFolder::new();
    folder.add("spindle.yaml", draft.text)?;
    if let Some(tool) = &parts.tool {
        folder.add("tool.yaml", tool_yaml(tool))?;
    }
    let controller = pid_of(&rotor).map_err(|e| Failure::new(format!("{file}: the PID of the magnets: {e}")))?;
    let mut notes = parts.told.clone();
    if let Some(controller) = &controller {
        folder.add("controller.json", controller_json(controller, None))?;
        notes.push(
            "the PID of the magnets is in controller.json, in continuous time, from displacement at the sensors to \
             current, amplifier and sensor gain included"
                .to_owned(),
        );
    }
    console.writing(|| folder.write(Path::new(out)))?;
    for words in &notes {
        eprintln!("note: {words}");
    }
    let answer = json!({
        "folder": out,
        "mass_kg": whole.mass_properties().mass_kg,
        "free_free_bending_hz": hz,
        "to_be_given": draft.to_be_given,
        "notes": notes,
    });
    let listed: Vec<String> = hz.iter().map(|f| format!("{f:.1}")).collect();
    let (elements, open) = (parts.sections.len(), draft.to_be_given.len());
    Ok(CommandEnd::done(format!("{elements} elements written, {open} keys of the spindle are to be given"))
        .answer(&answer)
        .row(["free-free bending modes at rest, Hz".to_owned(), listed.join(" ")])
        .file(format!("{out}/spindle.yaml"))
        .next(format!("muspin check {out}/spindle.yaml")))
}

/// The PID of both magnets as a controller, none where one of them has none.
fn pid_of(rotor: &RossRotor) -> Result<Option<Controller>, NumericError> {
    let Some([front, rear]) = rotor.magnet_pair() else {
        return Ok(None);
    };
    let pid = |bearing: &RossBearing| bearing.magnet.and_then(|m| m.pid);
    match (pid(front), pid(rear)) {
        (Some(front), Some(rear)) => pid_controller("PID of ROSS", [front, rear]).map(Some),
        _ => Ok(None),
    }
}

fn export(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let machine = load_machine(&arguments.spindle, &arguments.tool)?;
    let out = arguments.out.as_str();
    console.claim(out, &["rotor.toml", "rotor.json"], &[])?;
    let (spindle, tool) = (&machine.spindle, &machine.tool);
    let failed = |e: SpindleError| Failure::new(e.to_string());
    let shaft = shaft_without_effects(&machine).map_err(failed)?;
    let Some(shaft) = shaft else {
        let rule = format!(
            "{}: effects: one of them changes the shaft, and a ROSS file has no place for it",
            arguments.spindle
        );
        return Err(Failure::new(rule)
            .with_hint("write what it does into the elements (modulus_scale, discs) and remove it from `effects`"));
    };
    let (sections, discs) = (&shaft.sections, &shaft.discs);
    let value = ross_rotor(shaft.origin_m, sections, discs);
    let toml = toml::to_string(&value).map_err(|e| Failure::new(e.to_string()))?;
    let mut folder = ResultsFolder::new();
    folder.add("rotor.toml", toml)?;
    folder.add("rotor.json", format!("{value:#}\n"))?;
    console.writing(|| folder.write(Path::new(out)))?;
    let answer = json!({ "folder": out, "elements": sections.len(), "discs": discs.len() });
    Ok(CommandEnd::done(format!(
        "{} with {}: {} elements, discs: {}, for ROSS, without bearings",
        spindle.name,
        tool.name,
        sections.len(),
        discs.len()
    ))
    .answer(&answer)
    .file(format!("{out}/rotor.toml"))
    .next(format!("python3 -c 'import ross; print(ross.Rotor.load(\"{out}/rotor.toml\"))'")))
}
