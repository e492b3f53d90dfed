//! A measured FRF of one input and one output with what is known about its noise: hammer tests at the tool.
//!
//! From coherence γ² and n averages the complex standard deviation is |H| √((1 − γ²)/(n γ²)), half its square for the
//! real and half for the imaginary part (Bendat and Piersol, Random Data, sec. 9.2).

use super::frf::AXES;
use super::peaks::{Channel, Resonance, resonances};
use crate::linalg::c64;
use crate::lti::HeldResponse;
use crate::lti::held::closed_response;
use crate::spindle::Plant;

/// An FRF of a hammer test.
#[derive(Clone, Debug, PartialEq)]
pub struct HammerFrf {
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Lines, Hz, ascending.
    pub frequency_hz: Vec<f64>,
    /// Compliance, m/N.
    pub compliance: Vec<c64>,
    /// Coherence per line; `None` when the file has none.
    pub coherence: Option<Vec<f64>>,
    /// Averages per line; `None` when the file does not say.
    pub averages: Option<Vec<f64>>,
}

impl HammerFrf {
    /// Resonances that a local fit resolves: those with a damping ratio of two percent at most.
    pub(crate) fn lightly_damped(&self) -> Vec<Resonance> {
        let lines = 0..self.frequency_hz.len();
        // A floor of half a percent: what repeated hammer tests differ by.
        let channel = Channel {
            name: "tool".to_owned(),
            value: self.compliance.clone(),
            sigma: lines.map(|k| self.sigma(k, 0.005)).collect(),
        };
        resonances(&self.frequency_hz, &[channel])
    }

    /// Standard deviation of the complex compliance at a line, √E|δH|², m/N, with `floor` × |H| added in squares.
    pub fn sigma(&self, line: usize, floor: f64) -> f64 {
        let size = self.compliance.get(line).map_or(0.0, |h| h.norm());
        let noise = match (&self.coherence, &self.averages) {
            (Some(c), Some(n)) => {
                let (c, n) = (
                    c.get(line).copied().unwrap_or(1.0),
                    n.get(line).copied().unwrap_or(1.0),
                );
                size * ((1.0 - c).max(0.0) / (n * c)).sqrt()
            }
            _ => 0.0,
        };
        noise.hypot(floor * size)
    }
}

/// Compliance at the tool plane of the levitated spindle, m/N, with the hold of a sampled controller. `axis` 0 is x, 1
/// is y.
pub(crate) fn closed_loop_compliance(
    plant: &Plant,
    controller: &dyn HeldResponse,
    omega_rad_s: f64,
    axis: usize,
) -> c64 {
    let axis = axis.min(1);
    closed_response(plant, controller, AXES, omega_rad_s)[(axis, axis)]
}
