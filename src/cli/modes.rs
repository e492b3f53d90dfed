//! `muspin modes`: natural frequencies of the free-free rotor with its tool over speed, magnets off, as JSON.
//! At rest every mode appears twice, once a plane; at speed as its backward and forward whirl.

use super::console::{CommandEnd, Console};
use super::machine::load_machine;
use super::speeds::SpeedList;
use super::{Failure, Outcome};
use crate::report::summary::json;
use serde::Serialize;
use std::f64::consts::TAU;

/// Highest frequency listed, Hz: beyond the bandwidth of every magnetic bearing.
const TO_HZ: f64 = 10_000.0;

/// Arguments of `muspin modes`.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Spindle file, or the name of a shipped one
    #[arg(long, default_value = "reference")]
    spindle: String,
    /// Tool file, or the name of a shipped one
    #[arg(long, default_value = "paper-tool")]
    tool: String,
    /// Speeds in rpm: a list `0,10000`, a range start:step:end `0:1000:5000`, or both
    #[arg(long, alias = "speed", default_value = "0")]
    speeds: SpeedList,
}

#[derive(Clone, Debug, Serialize)]
struct ModesAnswer {
    spindle: String,
    tool: String,
    mass_kg: f64,
    centre_of_gravity_m: f64,
    polar_inertia_kg_m2: f64,
    diametral_inertia_kg_m2: f64,
    speeds: Vec<SpeedModes>,
}

/// Modes at a speed; whirl is 1 for forward, -1 for backward, 0 for none.
#[derive(Clone, Debug, Serialize)]
struct SpeedModes {
    speed_rpm: f64,
    natural_frequencies_hz: Vec<f64>,
    damped_frequencies_hz: Vec<f64>,
    damping_ratio: Vec<f64>,
    whirl: Vec<i64>,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let machine = load_machine(&arguments.spindle, &arguments.tool)?;
    let rotor = machine.rotor()?;
    let properties = rotor.mass_properties();
    let mut speeds = vec![];
    for rpm in &arguments.speeds.0 {
        let found = machine.whirl(rpm * TAU / 60.0, TO_HZ)?;
        let list = |pick: fn(&crate::rotor::WhirlMode) -> f64| -> Vec<f64> { found.modes.iter().map(pick).collect() };
        speeds.push(SpeedModes {
            speed_rpm: *rpm,
            natural_frequencies_hz: list(|m| m.natural_rad_s / TAU),
            damped_frequencies_hz: list(|m| m.damped_rad_s / TAU),
            damping_ratio: list(|m| m.damping_ratio),
            whirl: found.modes.iter().map(|m| m.whirl as i64).collect(),
        });
    }
    let answer = ModesAnswer {
        spindle: machine.spindle.name.clone(),
        tool: machine.tool.name.clone(),
        mass_kg: properties.mass_kg,
        centre_of_gravity_m: properties.centre_of_gravity_m,
        polar_inertia_kg_m2: properties.polar_inertia_kg_m2,
        diametral_inertia_kg_m2: properties.diametral_inertia_kg_m2,
        speeds,
    };
    console.json(&format!("{:#}\n", json(&answer)), || show_modes(&answer))?;
    Ok(Outcome::Done)
}

/// Modes listed on a terminal: the rigid-body modes and the first bending modes.
const LISTED: usize = 12;

fn show_modes(answer: &ModesAnswer) -> CommandEnd {
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
        rows.push(vec![format!("{:?}", speed.speed_rpm), words.collect::<Vec<_>>().join(" ")]);
    }
    CommandEnd::done(verdict).rows(rows).next("muspin modes --json has all modes below 10 kHz with damping ratios")
}
