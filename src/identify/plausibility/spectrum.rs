//! Responses as logarithms, and the distance between two of them.
//!
//! d(a, b) = min(π, |ln a − ln b|) with the phase difference wrapped to ±π: a reversed sign counts in full and
//! nothing counts more. d is a metric, and a change of unit or sign, an exchange of channels and conjugation of both
//! leave it as it is.

use crate::linalg::c64;
use std::f64::consts::{LN_10, PI, TAU};

/// Largest distance: that of a reversed sign.
pub(crate) const LARGEST: f64 = PI;

/// ln of a value: magnitude and phase, with the standard deviation of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LogValue {
    /// ln |g|.
    pub magnitude: f64,
    /// arg g, rad.
    pub phase: f64,
    /// ln of the standard deviation of g; −∞ for a model.
    pub deviation: f64,
}

impl LogValue {
    /// Of a value with a standard deviation in its unit.
    pub(crate) fn of(value: c64, deviation: f64) -> Self {
        Self { magnitude: value.norm().ln(), phase: value.im.atan2(value.re), deviation: deviation.ln() }
    }

    pub(crate) fn scale_decades(self, decades: i32) -> Self {
        let shift = LN_10 * f64::from(decades);
        Self { magnitude: self.magnitude + shift, deviation: self.deviation + shift, ..self }
    }

    /// Times `factor` of phase `phase`.
    pub(crate) fn times(self, factor: f64, phase: f64) -> Self {
        Self {
            magnitude: self.magnitude + factor.ln(),
            phase: self.phase + phase,
            deviation: self.deviation + factor.ln(),
        }
    }

    /// True where the value is more than twice its standard deviation.
    fn is_seen(&self, deviation: f64) -> bool {
        self.magnitude > deviation + 2f64.ln()
    }

    /// Distance to a model value, in nepers and radians; `None` where noise hides both.
    pub(crate) fn distance(&self, model: &Self) -> Option<f64> {
        if !self.is_seen(self.deviation) && !model.is_seen(self.deviation) {
            return None;
        }
        let magnitude = self.magnitude - model.magnitude;
        if !magnitude.is_finite() {
            return Some(LARGEST);
        }
        Some(magnitude.hypot(wrap_angle(self.phase - model.phase)).min(LARGEST))
    }
}

/// An angle between −π and π.
pub(crate) fn wrap_angle(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// A response over lines: all entries, of which some are compared with the model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spectrum {
    /// Frequency per line, Hz, as the record says.
    pub frequency_hz: Vec<f64>,
    /// Entry [output + outputs · input] of every line.
    pub entries: Vec<Vec<LogValue>>,
}

/// Median of values; `None` without any. The upper one of two.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.into_iter().filter(|v| !v.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}
