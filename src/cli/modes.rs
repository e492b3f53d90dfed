//! `muspin modes`: natural frequencies of the free-free rotor with its tool over speed, magnets off, as JSON.
//! At rest every mode appears twice, once a plane; at speed as its backward and forward whirl.

use super::machine::load_machine;
use super::{Failure, Outcome, stdout};
use crate::rotor::Damping;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Highest frequency listed, Hz: beyond the bandwidth of every magnetic bearing.
const TO_HZ: f64 = 10_000.0;

/// Arguments of `muspin modes`.
#[derive(clap::Args, Debug)]
pub struct Arguments {
    /// Spindle file, or the name of a shipped one
    #[arg(long, default_value = "reference")]
    spindle: String,
    /// Tool file, or the name of a shipped one
    #[arg(long, default_value = "paper-tool")]
    tool: String,
    /// Speeds in rpm, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0")]
    speeds: Vec<f64>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let machine = load_machine(&arguments.spindle, &arguments.tool)?;
    for rpm in &arguments.speeds {
        if !(rpm.is_finite() && *rpm >= 0.0) {
            return Err(
                Failure::new(format!("--speeds: {rpm} must be zero or a positive number"))
                    .with_hint("speeds are in rpm, for example --speeds 0,10000,50000"),
            );
        }
    }
    let rotor = machine.rotor()?;
    let ratios = (0..rotor.dofs())
        .map(|k| machine.damping_ratio(k))
        .collect();
    let damping = Damping::Modal(ratios);
    let factor = machine.effective().gyroscopic_factor;
    let properties = rotor.mass_properties();
    let mut speeds: Vec<Value> = vec![];
    for rpm in &arguments.speeds {
        let speed = rpm * TAU / 60.0 * factor;
        let found = rotor.whirl(speed, &damping, &[], TO_HZ)?;
        let list = |pick: fn(&crate::rotor::WhirlMode) -> f64| -> Vec<f64> {
            found.modes.iter().map(pick).collect()
        };
        speeds.push(json!({
            "speed_rpm": rpm,
            "natural_frequencies_hz": list(|m| m.natural_rad_s / TAU),
            "damped_frequencies_hz": list(|m| m.damped_rad_s / TAU),
            "damping_ratio": list(|m| m.damping_ratio),
            "whirl": found.modes.iter().map(|m| m.whirl as i64).collect::<Vec<_>>(),
        }));
    }
    let answer = json!({
        "spindle": machine.spindle.name,
        "tool": machine.tool.name,
        "mass_kg": properties.mass_kg,
        "centre_of_gravity_m": properties.centre_of_gravity_m,
        "polar_inertia_kg_m2": properties.polar_inertia_kg_m2,
        "diametral_inertia_kg_m2": properties.diametral_inertia_kg_m2,
        "speeds": speeds,
    });
    stdout::data(|out| writeln!(out, "{answer:#}"))?;
    Ok(Outcome::Done)
}
