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

/// Relative standard deviation of 3 dB.
const WORST_DEVIATION: f64 = 0.4125;

/// Relative standard deviation that repeated hammer tests differ by.
const REPEATABILITY: f64 = 0.005;

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
    /// Lines that tell the response, one entry a line: the standard deviation is below 3 dB, by coherence or else from
    /// line to line, and the line is not below [`Self::held_from`].
    pub fn valid_lines(&self) -> Vec<bool> {
        let noise = noise_of_lines(&self.frequency_hz, &self.compliance);
        let deviation = |k: usize| match &self.coherence {
            Some(coherence) => {
                let averages = self.averages.as_ref().and_then(|all| all.get(k)).copied().unwrap_or(1.0);
                ((1.0 - coherence[k]).max(0.0) / (averages * coherence[k])).sqrt()
            }
            None => noise[k] / self.compliance[k].norm(),
        };
        let from = self.held_from();
        (0..self.frequency_hz.len()).map(|k| k >= from && deviation(k) < WORST_DEVIATION).collect()
    }

    /// The line below which the compliance falls more steeply over an octave than that of any held rotor: towards low
    /// frequencies a spring is level and a damper falls by one decade in a decade; more is a free mass, or the drift of
    /// an integrated acceleration.
    fn held_from(&self) -> usize {
        let (f, h) = (&self.frequency_hz, &self.compliance);
        let falls = |k: usize| {
            let octave = f.partition_point(|hz| *hz < 2.0 * f[k]);
            let end = h.get(octave).filter(|_| h[k + 1..=octave].iter().all(|own| own.norm() < h[k].norm()));
            end.is_some_and(|end| end.norm() * f[octave] < h[k].norm() * f[k])
        };
        (0..f.len()).find(|k| !falls(*k)).unwrap_or(0)
    }

    /// The record with the other sign of time.
    #[must_use]
    pub(crate) fn conjugate(&self) -> Self {
        Self { compliance: self.compliance.iter().map(|h| h.conj()).collect(), ..self.clone() }
    }

    /// Resonances of the record.
    pub fn resonances(&self) -> Vec<Resonance> {
        shared_resonances(&[self])
    }

    fn channel(&self) -> Channel {
        // What repeated tests differ by is as smooth as the response itself: lines that are alike share one error.
        let floor = |k: usize| REPEATABILITY * self.lines_alike(k).sqrt() * self.compliance[k].norm();
        let noise = self.noise();
        let sigma = noise.iter().enumerate().map(|(k, noise)| noise.hypot(floor(k))).collect();
        Channel::new("h", self.compliance.clone(), sigma)
    }

    /// Lines over which the compliance changes by its own size, next to a peak those of its half bandwidth; 1 at least.
    fn lines_alike(&self, line: usize) -> f64 {
        let h = &self.compliance;
        let (before, after) = (line.saturating_sub(1), (line + 1).min(h.len() - 1));
        let change = (h[after] - h[before]).norm();
        if change > 0.0 { (h[line].norm() * (after - before) as f64 / change).max(1.0) } else { 1.0 }
    }

    /// Standard deviations of the complex compliance, √E|δH|², one a line, m/N, with `floor` × |H| added in squares.
    pub fn sigmas(&self, floor: f64) -> Vec<f64> {
        let each = self.noise().into_iter().zip(&self.compliance);
        each.map(|(noise, h)| noise.hypot(floor * h.norm())).collect()
    }

    /// Noise of the complex compliance, √E|δH|², one a line, m/N: by coherence and averages where the record has both,
    /// or else from line to line.
    fn noise(&self) -> Vec<f64> {
        let (Some(coherence), Some(averages)) = (&self.coherence, &self.averages) else {
            return noise_of_lines(&self.frequency_hz, &self.compliance);
        };
        let lines = self.compliance.iter().zip(coherence).zip(averages);
        let variance: Vec<f64> = lines.map(|((h, c), n)| h.norm_sqr() * (1.0 - c).max(0.0) / (n * c)).collect();
        let with_neighbours = |(line, own): (usize, &f64)| {
            let (mut sum, mut count) = (0.0, 0.0);
            // A coherence of zero says nothing of its neighbours.
            for variance in variance[neighbours(line, variance.len())].iter().filter(|v| v.is_finite()) {
                sum += variance;
                count += 1.0;
            }
            let mean = if count > 0.0 { sum / count } else { 0.0 };
            own.max(mean).sqrt()
        };
        variance.iter().enumerate().map(with_neighbours).collect()
    }
}

/// Resonances that hammer tests on the same lines share, one channel a test.
pub fn shared_resonances(taps: &[&HammerFrf]) -> Vec<Resonance> {
    let channels: Vec<Channel> = taps.iter().map(|tap| tap.channel()).collect();
    taps.first().map_or(vec![], |tap| resonances(&tap.frequency_hz, &channels))
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
