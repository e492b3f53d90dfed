//! Natural frequencies of the free-free rotor with its tool over speed, magnets off.

use crate::rotor::WhirlMode;
use crate::spindle::{Machine, SpindleError};
use serde::Serialize;
use std::f64::consts::TAU;

/// Highest frequency listed, Hz: beyond the bandwidth of every magnetic bearing.
const TO_HZ: f64 = 10_000.0;

/// Inertia of the rotor and its modes over speed.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ModesSummary {
    pub(crate) spindle: String,
    pub(crate) tool: String,
    pub(crate) mass_kg: f64,
    pub(crate) centre_of_gravity_m: f64,
    pub(crate) polar_inertia_kg_m2: f64,
    pub(crate) diametral_inertia_kg_m2: f64,
    pub(crate) speeds: Vec<SpeedModes>,
}

/// Modes at a speed; whirl is 1 for forward, -1 for backward, 0 for none.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SpeedModes {
    pub(crate) speed_rpm: f64,
    pub(crate) natural_frequencies_hz: Vec<f64>,
    pub(crate) damped_frequencies_hz: Vec<f64>,
    pub(crate) damping_ratio: Vec<f64>,
    pub(crate) whirl: Vec<i64>,
}

impl ModesSummary {
    /// The modes of a machine at speeds in rpm.
    ///
    /// # Errors
    /// [`SpindleError`] when the rotor cannot be assembled or an eigenvalue iteration fails.
    pub(crate) fn of(machine: &Machine, speeds_rpm: &[f64]) -> Result<Self, SpindleError> {
        let properties = machine.rotor()?.mass_properties();
        let at = |rpm: &f64| -> Result<SpeedModes, SpindleError> {
            let found = machine.whirl(rpm * TAU / 60.0, TO_HZ)?;
            let list = |pick: fn(&WhirlMode) -> f64| -> Vec<f64> { found.modes.iter().map(pick).collect() };
            Ok(SpeedModes {
                speed_rpm: *rpm,
                natural_frequencies_hz: list(|m| m.natural_rad_s / TAU),
                damped_frequencies_hz: list(|m| m.damped_rad_s / TAU),
                damping_ratio: list(|m| m.damping_ratio),
                whirl: found.modes.iter().map(|m| m.whirl as i64).collect(),
            })
        };
        Ok(Self {
            spindle: machine.spindle.name.clone(),
            tool: machine.tool.name.clone(),
            mass_kg: properties.mass_kg,
            centre_of_gravity_m: properties.centre_of_gravity_m,
            polar_inertia_kg_m2: properties.polar_inertia_kg_m2,
            diametral_inertia_kg_m2: properties.diametral_inertia_kg_m2,
            speeds: speeds_rpm.iter().map(at).collect::<Result<_, _>>()?,
        })
    }
}
