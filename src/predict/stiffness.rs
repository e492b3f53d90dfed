//! Dynamic stiffness at the tool, F_t/x_t: the inverse of the closed-loop compliance at the tool plane.

use super::closed_loop::{AXES, compliance, compliance_and_sensitivity};
use super::sensitivity::{AxisSensitivity, axis_magnitudes};
use crate::linalg::c64;
use crate::lti::{FrequencyGrid, HeldResponse, Response};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Dynamic stiffness of one axis over a grid.
#[derive(Clone, Debug)]
pub struct DynamicStiffness {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// |F_t/x_t|, N/m.
    pub magnitude_n_per_m: Vec<f64>,
    /// arg F_t/x_t, rad.
    pub phase_rad: Vec<f64>,
}

impl DynamicStiffness {
    fn of(grid: &FrequencyGrid, values: &[c64]) -> Self {
        Self {
            frequency_hz: grid.hz(),
            magnitude_n_per_m: values.iter().map(|k| k.norm()).collect(),
            phase_rad: values.iter().map(|k| k.arg()).collect(),
        }
    }

    /// Smallest stiffness and its frequency, (N/m, Hz); `None` on an empty grid.
    pub fn minimum(&self) -> Option<(f64, f64)> {
        self.magnitude_n_per_m.iter().zip(&self.frequency_hz).map(|(k, f)| (*k, *f)).min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// Dynamic stiffness at the tool along `axis` (0 x, 1 y) over a grid.
pub fn dynamic_stiffness(
    plant: &dyn Response,
    controller: &dyn HeldResponse,
    axis: usize,
    grid: &FrequencyGrid,
) -> DynamicStiffness {
    let values: Vec<c64> =
        grid.omega_rad_s().par_iter().map(|w| compliance(plant, controller, *w)[(axis, axis)].inv()).collect();
    DynamicStiffness::of(grid, &values)
}

/// Dynamic stiffness at the tool of both axes on the lines within `band_hz`, and sensitivity of the four axes on all,
/// from one response a line.
pub(crate) fn stiffness_and_sensitivity(
    plant: &dyn Response,
    controller: &dyn HeldResponse,
    grid: &FrequencyGrid,
    band_hz: (f64, f64),
) -> ([DynamicStiffness; 2], AxisSensitivity) {
    let lines: Vec<([c64; 2], [f64; AXES])> = grid
        .omega_rad_s()
        .par_iter()
        .map(|w| {
            let (compliance, s) = compliance_and_sensitivity(plant, controller, *w);
            ([0, 1].map(|axis| compliance[(axis, axis)].inv()), axis_magnitudes(&s))
        })
        .collect();
    let band = band_hz.0 * TAU..=band_hz.1 * TAU;
    let counts: Vec<bool> = grid.omega_rad_s().iter().map(|w| band.contains(w)).collect();
    let within = FrequencyGrid::from_rad_s(grid.omega_rad_s().iter().copied().filter(|w| band.contains(w)));
    let stiffness = [0, 1].map(|axis| {
        let own = lines.iter().zip(&counts).filter(|(_, counts)| **counts).map(|(line, _)| line.0[axis]);
        DynamicStiffness::of(&within, &own.collect::<Vec<c64>>())
    });
    let sensitivity = AxisSensitivity { frequency_hz: grid.hz(), magnitude: lines.iter().map(|line| line.1).collect() };
    (stiffness, sensitivity)
}

/// A stiffness in N/µm, that of a slender rotor in N/mm.
pub(crate) fn stiffness_words(n_per_m: f64) -> String {
    // Two decimals of N/µm show three digits from here on.
    if n_per_m.abs() < 1e5 { format!("{:.2} N/mm", 1e-3 * n_per_m) } else { format!("{:.2} N/µm", 1e-6 * n_per_m) }
}

/// Dynamic stiffness magnitude at one frequency, N/m.
pub(crate) fn stiffness_at(plant: &dyn Response, controller: &dyn HeldResponse, axis: usize, frequency_hz: f64) -> f64 {
    compliance(plant, controller, TAU * frequency_hz)[(axis, axis)].inv().norm()
}
