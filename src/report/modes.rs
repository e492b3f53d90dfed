//! Natural frequencies of a rotor with its tool over speed, magnets off.

use super::pictures::Picture;
use super::plot::whirl::whirl_shapes;
use super::tables::Table;
use super::whole::{Report, ReportError};
use crate::rotor::whirl::WhirlSpectrum;
use crate::rotor::{Rotor, WhirlMode};
use crate::spindle::{Machine, RotorOnSupports, SpindleError, WhirlOrbits};
use serde::Serialize;
use std::f64::consts::TAU;

/// Highest frequency listed, Hz: beyond the bandwidth of every magnetic bearing.
pub(crate) const TO_HZ: f64 = 10_000.0;

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
    /// The modes of a machine without its magnets, on the springs of its effects, at speeds in rpm.
    pub(crate) fn of(machine: &Machine, speeds_rpm: &[f64]) -> Result<Self, SpindleError> {
        let supports = machine.supports_without_magnets();
        let names = [&machine.spindle.name, &machine.tool.name].map(String::as_str);
        Self::at_speeds(names, &machine.rotor()?, speeds_rpm, &|speed| machine.whirl_on(&supports, speed, TO_HZ))
    }

    pub(crate) fn of_rotor(rotor: &RotorOnSupports, speeds_rpm: &[f64]) -> Result<Self, SpindleError> {
        let tool = rotor.tool.as_ref().map_or("no tool", |tool| &tool.name);
        Self::at_speeds([&rotor.name, tool], &rotor.rotor()?, speeds_rpm, &|speed| rotor.whirl(speed, TO_HZ))
    }

    fn at_speeds(
        names: [&str; 2],
        rotor: &Rotor,
        speeds_rpm: &[f64],
        whirl: &dyn Fn(f64) -> Result<WhirlSpectrum, SpindleError>,
    ) -> Result<Self, SpindleError> {
        let properties = rotor.mass_properties();
        let at = |rpm: &f64| -> Result<SpeedModes, SpindleError> {
            let found = whirl(rpm * TAU / 60.0)?;
            let list = |pick: fn(&WhirlMode) -> f64| -> Vec<f64> { found.modes.iter().map(pick).collect() };
            Ok(SpeedModes {
                speed_rpm: *rpm,
                natural_frequencies_hz: list(|m| m.natural_rad_s / TAU),
                damped_frequencies_hz: list(|m| m.damped_rad_s / TAU),
                damping_ratio: list(|m| m.damping_ratio),
                whirl: found.modes.iter().map(|m| m.whirl.round() as i64).collect(),
            })
        };
        Ok(Self {
            spindle: names[0].to_owned(),
            tool: names[1].to_owned(),
            mass_kg: properties.mass_kg,
            centre_of_gravity_m: properties.centre_of_gravity_m,
            polar_inertia_kg_m2: properties.polar_inertia_kg_m2,
            diametral_inertia_kg_m2: properties.diametral_inertia_kg_m2,
            speeds: speeds_rpm.iter().map(at).collect::<Result<_, _>>()?,
        })
    }
}

/// The report of the modes: shapes in space at each speed, as pictures and as `whirl_shapes.csv`.
pub(crate) fn modes_report(summary: &ModesSummary, orbits: &[WhirlOrbits]) -> Result<Report, ReportError> {
    let mut report = Report::default();
    for (key, value) in [("run", "modes"), ("spindle", &summary.spindle), ("tool", &summary.tool)] {
        report.summary.set(key, value);
    }
    report.verdict(true, &format!("Modes of {} with {}, magnets off", summary.spindle, summary.tool));
    report.summary.set("model", summary);
    let title = |rpm: f64| format!("Modes of the rotor without its magnets at {rpm:.0} rpm");
    let numbered = orbits.iter().enumerate();
    report
        .figures(numbered.map(|(k, found)| {
            (Picture::WhirlShapes.with_number(k + 1), whirl_shapes(&title(found.speed_rpm), found))
        }))?;
    let columns = ["speed_rpm", "mode", "frequency_hz", "whirl", "position_m", "x_re", "x_im", "y_re", "y_im"];
    let mut table = Table::with_columns(&columns);
    for found in orbits {
        for (k, shape) in found.shapes.iter().enumerate() {
            let (number, hz) = ((k + 1) as f64, shape.mode.damped_rad_s / TAU);
            for (z, [x, y]) in found.position_m.iter().zip(&shape.orbits) {
                table.push_numbers(&[found.speed_rpm, number, hz, shape.mode.whirl, *z, x.re, x.im, y.re, y.im]);
            }
        }
    }
    report.folder.add_table("whirl_shapes.csv", &table)?;
    Ok(report)
}
