//! Lines whose signals reach a limit.
//!
//! The fundamental of a sine that is cut off at l lies between l and 4 l/π, however large the sine. Lines in that range
//! below the largest signal of a sweep are left out; where enough of them pile up and the machine explains what is
//! left, they were cut off. A resonance that is lower than in the model passes through the range in a line or two only.

use super::super::data::measurement::Measurement;
use crate::identify::plausibility::Signal;
use crate::identify::plausibility::correction::largest;

/// Least share of the lines that pile up, and least number of them.
const LEAST: (f64, usize) = (0.03, 4);
/// Most of them: what is left has to speak for the machine.
const MOST: f64 = 0.5;
/// Shares of the largest signal that may be the limit: a limit on the fundamental itself, and on the samples.
const SHARES: [f64; 4] = [0.995, 0.95, 0.87, std::f64::consts::FRAC_PI_4];

/// Limits that a sweep's signals allow, ascending; first the signal of which most lines are close to its largest.
pub(crate) fn clippings(measurement: &Measurement, sweep: usize) -> Vec<(Signal, Vec<f64>)> {
    let Some(record) = measurement.sweeps.get(sweep) else {
        return vec![];
    };
    let lines = record.frequency_hz.len();
    let least = ((LEAST.0 * lines as f64) as usize).max(LEAST.1);
    let most = (MOST * lines as f64) as usize;
    let mut all: Vec<(usize, Signal, Vec<f64>)> = vec![];
    for signal in [Signal::Displacement, Signal::Current] {
        let sizes: Vec<f64> = (0..lines).map(|k| largest(record, signal, k)).collect();
        let top = sizes.iter().copied().fold(0.0, f64::max);
        let reached = |limit: f64| sizes.iter().filter(|s| **s >= limit).count();
        let limits = SHARES.into_iter().rev().map(|share| share * top);
        let limits: Vec<f64> = limits
            .filter(|limit| (least..=most).contains(&reached(*limit)))
            .collect();
        all.push((reached(SHARES[0] * top), signal, limits));
    }
    all.sort_by_key(|own| std::cmp::Reverse(own.0));
    all.into_iter()
        .map(|(_, signal, limits)| (signal, limits))
        .collect()
}
