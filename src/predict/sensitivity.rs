//! Stability margin by ISO 14839-3: peak of the sensitivity of each axis, all loops closed, and its zone.
//! Zones by the peak: A below 3 (9.5 dB), B to 4 (12 dB), C to 5 (14 dB), D above.

use super::closed_loop::{AXES, sensitivity};
use crate::linalg::{Mat, c64};
use crate::lti::{FrequencyGrid, HeldResponse, Response};
use rayon::prelude::*;

/// Zone of ISO 14839-3, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Zone {
    /// Newly commissioned machines.
    A,
    /// Unrestricted long-term operation.
    B,
    /// Limited time.
    C,
    /// Not acceptable.
    D,
}

impl Zone {
    /// Zone of a sensitivity peak (absolute value, not dB).
    pub(crate) fn of_peak(peak: f64) -> Self {
        match peak {
            p if p < 3.0 => Self::A,
            p if p < 4.0 => Self::B,
            p if p < 5.0 => Self::C,
            _ => Self::D,
        }
    }

    /// The letter.
    pub fn letter(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::C => "C",
            Self::D => "D",
        }
    }
}

/// Sensitivity of the four axes over a grid.
#[derive(Clone, Debug)]
pub struct AxisSensitivity {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// |S_jj| per line and axis, absolute.
    pub magnitude: Vec<[f64; AXES]>,
}

impl AxisSensitivity {
    /// Peak of axis `axis`, absolute, and its frequency, Hz.
    pub fn peak(&self, axis: usize) -> (f64, f64) {
        self.magnitude
            .iter()
            .zip(&self.frequency_hz)
            .map(|(s, f)| (s[axis], *f))
            .fold((0.0, 0.0), |best, next| if next.0 > best.0 { next } else { best })
    }

    /// Worst zone over the axes.
    pub fn zone(&self) -> Zone {
        (0..AXES).map(|axis| Zone::of_peak(self.peak(axis).0)).max().unwrap_or(Zone::D)
    }
}

/// |S_jj| of each axis.
pub(super) fn axis_magnitudes(s: &Mat<c64>) -> [f64; AXES] {
    std::array::from_fn(|axis| s[(axis, axis)].norm())
}

/// Sensitivity of each axis over a grid.
pub fn axis_sensitivity(plant: &dyn Response, controller: &dyn HeldResponse, grid: &FrequencyGrid) -> AxisSensitivity {
    let magnitude = grid
        .omega_rad_s()
        .par_iter()
        .map(|w| {
            let s = sensitivity(plant, controller, *w);
            axis_magnitudes(&s)
        })
        .collect();
    AxisSensitivity { frequency_hz: grid.hz(), magnitude }
}
