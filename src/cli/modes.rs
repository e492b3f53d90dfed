//! `muspin modes`: natural frequencies of a rotor with its tool over speed, magnets off, as JSON: free-free but for the
//! springs among its effects, or on the supports of a rotor file.
//! At rest every mode appears twice, once a plane; at speed as its backward and forward whirl.

use super::Failure;
use super::choices::PictureArguments;
use super::console::{CommandEnd, Console, REPORT};
use super::controlled_machine::SPINDLE;
use super::machine::{load_machine, load_rotor_said};
use super::speeds::SpeedList;
use crate::input::{is_rotor, usual_tool};
use crate::report::modes::{ModesSummary, TO_HZ, modes_report};
use crate::report::summary::json;
use crate::spindle::WhirlOrbits;
use crate::spindle::effects::EffectKind;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Spindle or rotor file, or the name of a shipped spindle
    #[arg(long, default_value = SPINDLE)]
    spindle: String,
    /// Tool file, the name of a shipped one, or `none`; default: none for a spindle with `output_m` and in a rotor
    /// without magnets, else the paper's
    #[arg(long)]
    tool: Option<String>,
    /// Speeds in rpm: a list `0,10000`, a range start:step:end `0:1000:5000`, or both
    #[arg(long, alias = "speed", default_value = "0")]
    speeds: SpeedList,
    /// Folder for the mode shapes in space at each speed, as pictures and as a table, and a report
    #[arg(long)]
    out: Option<String>,
    #[command(flatten)]
    pictures: PictureArguments,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let out = arguments.pictures.folder(&arguments.out)?;
    let (spindle, tool, speeds) = (&arguments.spindle, arguments.tool.as_deref(), &arguments.speeds.0);
    if let Some(out) = out {
        console.claim(out, &REPORT, &[])?;
    }
    // Only pictures need the shapes.
    let drawn = if out.is_some() { speeds.as_slice() } else { &[] };
    let (answer, orbits) = if is_rotor(spindle) {
        let rotor = load_rotor_said(spindle, tool)?;
        let orbits = drawn.iter().map(|rpm| WhirlOrbits::of_rotor(&rotor, *rpm, TO_HZ));
        (ModesSummary::of_rotor(&rotor, speeds)?, orbits.collect::<Result<Vec<_>, _>>()?)
    } else {
        let machine = load_machine(spindle, tool.map_or_else(|| usual_tool(spindle), Ok)?)?;
        for effect in machine.spindle.effects.iter().filter(|e| NOT_IN_MODES.contains(&e.kind)) {
            eprintln!("note: {spindle}: the effect {} is not in these modes", effect.kind.name());
        }
        let supports = machine.supports_without_magnets();
        let orbits = drawn.iter().map(|rpm| WhirlOrbits::of(&machine, &supports, *rpm, TO_HZ));
        (ModesSummary::of(&machine, speeds)?, orbits.collect::<Result<Vec<_>, _>>()?)
    };
    let shown = show_modes(&answer).answer(&json(&answer));
    let Some(out) = out else {
        return Ok(shown);
    };
    let mut report = modes_report(&answer, &orbits)?;
    console.writing(|| report.write(out, &arguments.pictures.formats))?;
    Ok(shown.file(format!("{out}/report.html")))
}

/// Effects on shaft and ground that modes without magnets leave out.
const NOT_IN_MODES: [EffectKind; 3] =
    [EffectKind::TiltingStiffness, EffectKind::InternalDamping, EffectKind::HousingMode];

/// Modes listed on a terminal: the rigid-body modes and the first bending modes.
const LISTED: usize = 12;

fn show_modes(answer: &ModesSummary) -> CommandEnd {
    let verdict = format!(
        "{} with {}: {:.3} kg, centre of gravity {:.1} mm from the nose face",
        answer.spindle,
        answer.tool,
        answer.mass_kg,
        1e3 * answer.centre_of_gravity_m
    );
    let mut rows = vec![vec!["speed, rpm".to_owned(), "natural frequencies, Hz (- backward, + forward)".to_owned()]];
    for speed in &answer.speeds {
        let pairs = speed.natural_frequencies_hz.iter().zip(&speed.whirl);
        let words = pairs.take(LISTED).map(|(f, whirl)| {
            let sign = match whirl {
                1 => "+",
                -1 => "-",
                _ => "",
            };
            format!("{f:.1}{sign}")
        });
        let words = words.collect::<Vec<_>>().join(" ");
        let words = if words.is_empty() { format!("none below {:.0} kHz", 1e-3 * TO_HZ) } else { words };
        rows.push(vec![format!("{:?}", speed.speed_rpm), words]);
    }
    CommandEnd::done(verdict).rows(rows).next("muspin modes --json has all modes below 10 kHz with damping ratios")
}
