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
    /// Correlation E[δδ'*]/σσ' of its noise with that of the next channel, one a line; empty: none. What a sensor adds
    /// is in all responses of its row, once the loop has fed it into the currents.
    pub with_next: Vec<c64>,
}

impl Channel {
    /// A channel whose noise is its own.
    pub fn new(name: impl Into<String>, value: Vec<c64>, sigma: Vec<f64>) -> Self {
        Self { name: name.into(), value, sigma, with_next: vec![] }
    }
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
    /// Residue per channel on the frequency axis, in units of the channel times Hz; zero where one tells nothing.
    pub residue: Vec<c64>,
}

impl Resonance {
    /// The pole on the frequency axis, Hz: damped frequency + jζf.
    pub(crate) fn pole_hz(&self) -> c64 {
        let z = self.damping_ratio;
        c64::new(self.frequency_hz * (1.0 - z * z).max(0.0).sqrt(), z * self.frequency_hz)
    }

    /// Amplitude of the mode in every channel, the largest one: residues turned to the phase that they have in common,
    /// arg(Σ r²)/2.
    pub fn shape(&self) -> Vec<f64> {
        let common = 0.5 * self.residue.iter().map(|r| r * r).sum::<c64>().arg();
        let turned = self.residue.iter().map(|r| (r * c64::from_polar(1.0, -common)).re);
        let real: Vec<f64> = turned.collect();
        let largest = real.iter().fold(0.0f64, |most, a| if a.abs() > most.abs() { *a } else { most });
        real.iter().map(|a| if largest == 0.0 { 0.0 } else { a / largest }).collect()
    }
}
