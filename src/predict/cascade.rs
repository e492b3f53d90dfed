//! Spectra of the tool's displacement over speed, as a run-up shows them: the line of the unbalance, and what a force
//! with one density at all frequencies excites in the closed loop.
//!
//! With forces of density S (N/√Hz) in x and y, independent of each other, x has the density S √(|C_xx|² + |C_xy|²); a
//! line has the root of its square integrated over the line, and the line of the speed the rms of the unbalance
//! response besides. Linear loop of the plant that is given; limits of current and voltage are not in it.

use super::closed_loop::compliance;
use super::loop_shape::unbalance_response;
use crate::lti::HeldResponse;
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Density of the force at the tool, N/√Hz: 10 N rms over 10 kHz, a light cut.
pub const FORCE_DENSITY_N: f64 = 0.1;
/// Unbalance at the tool plane, kg m: 1 g mm.
pub const UNBALANCE_KG_M: f64 = 1e-6;
/// Speeds of a run-up, and lines of a spectrum.
const SPEEDS: usize = 24;
const LINES: usize = 200;
/// Pieces of a line in its integral; a mode of 1 % damping at 500 Hz is 10 Hz wide.
const PIECES: usize = 4;

/// Spectra over speed.
#[derive(Clone, Debug)]
pub struct Cascade {
    /// Speeds, rpm.
    pub speed_rpm: Vec<f64>,
    /// Ends of the lines, Hz, one more than there are lines.
    pub edges_hz: Vec<f64>,
    /// Displacement in x at the tool, rms of each line, m, for every speed.
    pub rms_m: Vec<Vec<f64>>,
    /// Part of the unbalance alone, rms, m.
    pub unbalance_rms_m: Vec<f64>,
}

impl Cascade {
    /// Of a controller on the full model at even steps up to a speed, over a range of frequencies.
    ///
    /// # Errors
    /// [`SpindleError`] when a plant cannot be built.
    pub fn new(
        machine: &Machine,
        controller: &dyn HeldResponse,
        top_rpm: f64,
        [from_hz, to_hz]: [f64; 2],
    ) -> Result<Self, SpindleError> {
        let speed_rpm: Vec<f64> = (1..=SPEEDS).map(|k| top_rpm * k as f64 / SPEEDS as f64).collect();
        let edges_hz: Vec<f64> = (0..=LINES).map(|k| from_hz + (to_hz - from_hz) * k as f64 / LINES as f64).collect();
        let unbalance = unbalance_response(machine, controller, &speed_rpm)?;
        let unbalance_rms_m: Vec<f64> = unbalance.iter().map(|at| at[0] * UNBALANCE_KG_M / 2f64.sqrt()).collect();
        let at = |(rpm, once): (&f64, &f64)| {
            let plant = Plant::new(machine, rpm * TAU / 60.0, ModelDetail::Full)?;
            let density = |hz: f64| {
                let c = compliance(&plant, controller, TAU * hz);
                FORCE_DENSITY_N * c[(0, 0)].norm().hypot(c[(0, 1)].norm())
            };
            let mut lines = line_rms(&edges_hz, &density);
            let own = edges_hz.partition_point(|edge| *edge <= rpm / 60.0).wrapping_sub(1);
            if let Some(line) = lines.get_mut(own) {
                *line = line.hypot(*once);
            }
            Ok(lines)
        };
        let rms_m = speed_rpm.par_iter().zip(&unbalance_rms_m).map(at).collect::<Result<_, SpindleError>>()?;
        Ok(Self { speed_rpm, edges_hz, rms_m, unbalance_rms_m })
    }

    /// Speed in rpm, middle in Hz and rms in m of the largest line.
    pub fn largest(&self) -> (f64, f64, f64) {
        let spectra = self.speed_rpm.iter().zip(&self.rms_m);
        let lines = spectra.flat_map(|(rpm, lines)| {
            lines.iter().zip(self.edges_hz.windows(2)).map(|(rms, ends)| (*rpm, 0.5 * (ends[0] + ends[1]), *rms))
        });
        lines.fold((f64::NAN, f64::NAN, 0.0), |best, line| if line.2 > best.2 { line } else { best })
    }
}

/// The rms of each line between `edges_hz` of a signal with this density, by Simpson's rule on its square.
pub fn line_rms(edges_hz: &[f64], density: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let mut last = edges_hz.first().map_or(0.0, |edge| density(*edge).powi(2));
    let line = |ends: &[f64]| {
        let step = (ends[1] - ends[0]) / PIECES as f64;
        let mut sum = last;
        for k in 1..=PIECES {
            last = density(ends[0] + step * k as f64).powi(2);
            sum += last * if k == PIECES { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
        }
        (sum * step / 3.0).sqrt()
    };
    edges_hz.windows(2).map(line).collect()
}
