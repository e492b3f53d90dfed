//! A measured FRF of one input and one output with what is known about its noise: hammer tests at the tool.
//!
//! From coherence γ² and n averages the complex standard deviation is |H| √((1 − γ²)/(n γ²)), half its square for the
//! real and half for the imaginary part (Bendat and Piersol, Random Data, sec. 9.2). Where noise dominates, a line may
//! measure next to nothing by chance, and that formula would believe it; noise is smooth over frequency, so that no
//! line is believed to be better than its neighbours are in the mean.

use super::frf::{AXES, neighbours};
use super::line_noise::noise_of_lines;
use super::peaks::{Antiresonance, Channel, Resonance, antiresonances, resonances};
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
    /// Resonances with a damping ratio of two percent at most.
    pub(crate) fn lightly_damped(&self) -> Vec<Resonance> {
        let mut found = self.resonances();
        found.retain(|r| r.damping_ratio < 0.02);
        found
    }

    /// Resonances of the record.
    pub fn resonances(&self) -> Vec<Resonance> {
        resonances(&self.frequency_hz, &[self.channel()])
    }

    fn channel(&self) -> Channel {
        let lines = 0..self.frequency_hz.len();
        let noise = noise_of_lines(&self.frequency_hz, &self.compliance);
        // A floor of half a percent: what repeated hammer tests differ by.
        let sigma = |k: usize| self.sigma(k, 0.005);
        Channel {
            name: "h".to_owned(),
            value: self.compliance.clone(),
            sigma: match self.coherence {
                Some(_) => lines.map(sigma).collect(),
                None => lines.map(|k| sigma(k).hypot(noise[k])).collect(),
            },
        }
    }

    /// Standard deviation of the complex compliance at a line, √E|δH|², m/N, with `floor` × |H| added in squares.
    pub fn sigma(&self, line: usize, floor: f64) -> f64 {
        let size = self.compliance.get(line).map_or(0.0, |h| h.norm());
        let around = neighbours(line, self.compliance.len());
        let (mut sum, mut count) = (0.0, 0.0);
        // A coherence of zero says nothing of its neighbours.
        for variance in around.map(|k| self.variance(k)).filter(|v| v.is_finite()) {
            sum += variance;
            count += 1.0;
        }
        let mean = if count > 0.0 { sum / count } else { 0.0 };
        let noise = self.variance(line).max(mean).sqrt();
        noise.hypot(floor * size)
    }

    /// Variance of the complex compliance at a line by its own coherence, m²/N².
    fn variance(&self, line: usize) -> f64 {
        let (Some(h), Some(c), Some(n)) = (self.compliance.get(line), self.coherence.as_ref(), self.averages.as_ref())
        else {
            return 0.0;
        };
        let (c, n) = (c.get(line).copied().unwrap_or(1.0), n.get(line).copied().unwrap_or(1.0));
        h.norm_sqr() * (1.0 - c).max(0.0) / (n * c)
    }
}

/// Resonances that hammer tests on the same lines share, and the antiresonances of each from a frequency on.
pub(crate) fn identify_taps(taps: &[&HammerFrf], from_hz: f64) -> (Vec<Resonance>, Vec<Vec<Antiresonance>>) {
    let channels: Vec<Channel> = taps.iter().map(|tap| tap.channel()).collect();
    let Some(lines) = taps.first().map(|tap| &tap.frequency_hz) else {
        return (vec![], vec![]);
    };
    let poles = resonances(lines, &channels);
    let zeros = channels.iter().enumerate().map(|(k, own)| antiresonances(lines, own, k, &poles, from_hz)).collect();
    (poles, zeros)
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
