//! Drift of the poles over the repeats of a sweep, as a rotor that warms shows it: every resonance is fitted to each
//! repeat alone, and one relative change per repeat is fitted to all of them.

use super::IdentifyError;
use super::free_free::{Identification, channels_of};
use super::frf::{MeasuredFrf, SweepRecord, open_loop_columns};
use super::local::STEPS;
use super::peaks::Channel;
use super::selection::Survey;
use crate::spindle::Machine;
use ndarray::s;

/// Common relative change of the resonances from the first repeat to the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleDrift {
    /// Relative change of frequency.
    pub relative_change: f64,
    /// Its standard deviation.
    pub standard_deviation: f64,
}

impl PoleDrift {
    /// Whether the change exceeds what noise makes: three standard deviations.
    pub fn is_seen(&self) -> bool {
        self.relative_change.abs() > 3.0 * self.standard_deviation
    }
}

/// Drift of the resonances of `found` over the repeats of `record`, from which `frf` comes; none for a single repeat.
///
/// # Errors
/// As [`open_loop_columns`], for one repeat.
pub fn pole_drift(
    record: &SweepRecord,
    frf: &MeasuredFrf,
    machine: &Machine,
    found: &Identification,
) -> Result<Option<PoleDrift>, IdentifyError> {
    let repeats = record.repeats();
    let poles = found.measured_poles_hz();
    if repeats < 2 {
        return Ok(None);
    }
    let pooled = channels_of(frf, machine);
    // Sums of weighted regression with a mean of its own for every mode: readings (repeat, relative frequency, weight).
    let mut readings: Vec<Vec<(f64, f64, f64)>> = vec![vec![]; poles.len()];
    for repeat in 0..repeats {
        let one = SweepRecord {
            current: record.current.slice(s![.., .., repeat..=repeat, ..]).to_owned(),
            signal: record.signal.slice(s![.., .., repeat..=repeat, ..]).to_owned(),
            ..record.clone()
        };
        let channels = channels_of(&open_loop_columns(&one)?.0, machine);
        let noisy = |(one, all): (&Channel, &Channel)| Channel {
            sigma: all.sigma.iter().map(|s| s * (repeats as f64).sqrt()).collect(),
            ..one.clone()
        };
        let channels: Vec<Channel> = channels.iter().zip(&pooled).map(noisy).collect();
        let told = channels.iter().filter(|c| c.sigma.iter().all(|s| *s > 0.0)).collect();
        let survey = Survey::of(&frf.frequency_hz, told);
        for (k, pole) in poles.iter().enumerate() {
            if let Some(mode) = survey.mode_of(&poles, k, STEPS) {
                let relative = mode.pole_hz.re / pole.re - 1.0;
                readings[k].push((repeat as f64, relative, (pole.re / mode.sd_hz).powi(2)));
            }
        }
    }
    let (mut curvature, mut gradient) = (0.0, 0.0);
    for mode in &readings {
        let weight: f64 = mode.iter().map(|(_, _, w)| w).sum();
        let mean = mode.iter().map(|(p, _, w)| p * w).sum::<f64>() / weight;
        curvature += mode.iter().map(|(p, _, w)| w * (p - mean).powi(2)).sum::<f64>();
        gradient += mode.iter().map(|(p, y, w)| w * (p - mean) * y).sum::<f64>();
    }
    let span = (repeats - 1) as f64;
    let drift = PoleDrift { relative_change: span * gradient / curvature, standard_deviation: span / curvature.sqrt() };
    Ok((drift.relative_change.is_finite() && drift.standard_deviation.is_finite()).then_some(drift))
}
