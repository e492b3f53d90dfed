//! Noise of an FRF without repeats, from its lines: what a cubic through the four neighbours of a line does not follow.
//!
//! The median over some lines leaves out the sharp peaks, which no cubic follows either. The noise is either as large
//! on all lines or in proportion to the response; the likelihood of the roughness tells which.

use crate::linalg::c64;

/// Lines on either side over which the median is taken.
const MEDIAN_LINES: usize = 12;
/// The median of |n|² of circular noise is ln 2 times its mean.
const MEDIAN_TO_MEAN: f64 = std::f64::consts::LN_2;
/// Largest |n|²/σ² that counts: the peaks say nothing of the noise. Noise exceeds it at one line of four hundred.
const MOST_SQUARED: f64 = 6.0;

/// Standard deviation of the complex values, √E|n|², one a line; zero for less than five lines.
pub(super) fn noise_of_lines(frequency_hz: &[f64], value: &[c64]) -> Vec<f64> {
    let lines = value.len();
    if lines < 5 {
        return vec![0.0; lines];
    }
    let rough: Vec<f64> = (0..lines).map(|k| roughness(frequency_hz, value, k.clamp(2, lines - 3))).collect();
    let least = value.iter().map(|v| v.norm()).fold(0.0, f64::max) * f64::EPSILON;
    let size: Vec<f64> = value.iter().map(|v| v.norm().max(least)).collect();
    let shapes = [vec![1.0; lines], size];
    let noises = shapes.map(|shape| {
        let relative: Vec<f64> = rough.iter().zip(&shape).map(|(r, s)| if *r > 0.0 { r / s } else { 0.0 }).collect();
        (0..lines).map(|k| shape[k] * local_median(&relative, k) / MEDIAN_TO_MEAN.sqrt()).collect::<Vec<f64>>()
    });
    let cost = |noise: &[f64]| {
        let each = noise.iter().zip(&rough).filter(|(s, _)| **s > 0.0);
        each.map(|(s, r)| s.ln() + (r / s).powi(2).min(MOST_SQUARED)).sum::<f64>()
    };
    let [even, proportional] = noises;
    if cost(&proportional) < cost(&even) { proportional } else { even }
}

/// Deviation of a line from the cubic through its neighbours, in units in which white noise keeps its size.
fn roughness(frequency_hz: &[f64], value: &[c64], k: usize) -> f64 {
    let around = [k - 2, k - 1, k + 1, k + 2];
    let at = |i: usize| frequency_hz[i] - frequency_hz[k];
    let weight = |i: usize| {
        let others = around.iter().filter(|j| **j != i);
        others.map(|j| -at(*j) / (at(i) - at(*j))).product::<f64>()
    };
    let cubic: c64 = around.iter().map(|i| value[*i] * weight(*i)).sum();
    let squares: f64 = around.iter().map(|i| weight(*i).powi(2)).sum();
    (value[k] - cubic).norm() / (1.0 + squares).sqrt()
}

fn local_median(values: &[f64], k: usize) -> f64 {
    let end = (k + MEDIAN_LINES + 1).min(values.len());
    let mut some = values[k.saturating_sub(MEDIAN_LINES)..end].to_vec();
    some.sort_by(f64::total_cmp);
    some[some.len() / 2]
}
