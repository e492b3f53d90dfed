//! Modes of a free decay. The discrete Fourier transform of N samples of Σ a_k exp(s_k t) without a window is
//! Σ a_k (1 − exp(s_k NT))/(1 − exp((s_k − jω)T)) at its own lines, T the time of a sample: the poles are those of the
//! decay however early it is cut off, and nothing leaks. They are identified as those of a frequency response.

use super::fourier::{fourier, smooth_length};
use super::line_noise::noise_of_lines;
use super::peaks::{Channel, Resonance, resonances};
use crate::linalg::c64;

/// Modes of signals that decay together, from a sample on, ascending; the noise is estimated from line to line. The end
/// of the signals is cut to a length without large prime factors.
pub fn decay_modes(signals: &[&[f64]], sample_rate_hz: f64, from_sample: usize) -> Vec<Resonance> {
    let shortest = signals.iter().map(|s| s.len()).min().unwrap_or(0);
    let samples = smooth_length(shortest.saturating_sub(from_sample));
    // The last tenth below half of the sample rate is left to the filters of the recorder.
    let lines = 1..(9 * samples) / 20;
    let frequency_hz: Vec<f64> = lines.clone().map(|k| k as f64 * sample_rate_hz / samples as f64).collect();
    let channel = |signal: &&[f64]| {
        let own: Vec<c64> = signal[from_sample..from_sample + samples].iter().map(|x| c64::new(*x, 0.0)).collect();
        let value = fourier(&own)[lines.clone()].to_vec();
        let sigma = noise_of_lines(&frequency_hz, &value);
        Channel::new("", value, sigma)
    };
    if frequency_hz.is_empty() {
        return vec![];
    }
    resonances(&frequency_hz, &signals.iter().map(channel).collect::<Vec<Channel>>())
}
