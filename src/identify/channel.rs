//! A measured FRF with its noise, and a resonance that several of them share.

use crate::linalg::c64;

/// An FRF to look at.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name for messages.
    pub name: String,
    /// Values, one a line; known electronics divided out as far as they are known.
    pub value: Vec<c64>,
    /// Standard deviation of the complex values.
    pub sigma: Vec<f64>,
}

/// An identified resonance.
#[derive(Clone, Debug, PartialEq)]
pub struct Resonance {
    /// Undamped natural frequency, Hz.
    pub frequency_hz: f64,
    /// Standard deviation, Hz.
    pub standard_deviation_hz: f64,
    /// Damping ratio; its standard deviation is the relative one of the frequency.
    pub damping_ratio: f64,
    /// Real part of the residue over its standard deviation per channel: sign and visibility.
    pub residue_over_sd: Vec<f64>,
}

impl Resonance {
    /// The pole on the frequency axis, Hz: damped frequency + jζf.
    pub(crate) fn pole_hz(&self) -> c64 {
        let z = self.damping_ratio;
        c64::new(self.frequency_hz * (1.0 - z * z).max(0.0).sqrt(), z * self.frequency_hz)
    }
}
