//! Where a delivered loop is unstable, and the mode behind it.

use super::PipelineError;
use super::delivery::Delivery;
use super::loop_stability::{loop_poles, unstable_words};
use super::problems::Problems;
use crate::controller::verification::SpeedCheck;
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// The speed at which a loop grows fastest, of those computed from rest to the overspeed.
#[derive(Clone, Debug, PartialEq)]
pub struct Instability {
    /// Largest growth rate there, 1/s.
    pub growth_rate_per_s: f64,
    /// The speed, rpm.
    pub speed_rpm: f64,
    /// Frequency of the mode that grows, Hz.
    pub frequency_hz: f64,
    /// The flexible mode of the design next to it in frequency; none without one.
    pub mode: Option<GrowingMode>,
}

/// A flexible mode of the free rotor with its gyroscopic split at the top speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrowingMode {
    /// Number from one.
    pub number: usize,
    /// At rest, Hz.
    pub at_rest_hz: f64,
    /// Backward and forward whirl at the top speed, Hz.
    pub at_top_speed_hz: [f64; 2],
    /// Shift of its frequency that the synthesis covered, relative.
    pub covered: f64,
}

impl Instability {
    /// Of a delivery; none where every speed computed is stable.
    ///
    /// # Errors
    /// [`PipelineError`] when the plant or the poles at the worst speed cannot be computed.
    pub(super) fn of(
        machine: &Machine,
        problems: &Problems,
        delivery: &Delivery,
    ) -> Result<Option<Self>, PipelineError> {
        let checks = delivery.verification.speeds.iter().chain(&delivery.overspeed.speeds);
        let growing = checks.filter(|check| check.growth_rate_per_s.is_nan() || check.growth_rate_per_s >= 0.0);
        let worst = growing.max_by(|a, b| a.growth_rate_per_s.total_cmp(&b.growth_rate_per_s));
        let Some(SpeedCheck { speed_rpm, growth_rate_per_s }) = worst.copied() else { return Ok(None) };
        let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
        let poles = loop_poles(&plant, &delivery.controller)?.poles_rad_s;
        let fastest = poles.iter().max_by(|a, b| a.re.total_cmp(&b.re));
        let frequency_hz = fastest.map_or(0.0, |pole| pole.im.abs() / TAU);
        let modes = problems.split.iter().enumerate().map(|(k, split)| GrowingMode {
            number: k + 1,
            at_rest_hz: split.omega_rad_s / TAU,
            at_top_speed_hz: [split.backward_rad_s / TAU, split.forward_rad_s / TAU],
            covered: problems.covered_modes.iter().find(|own| own.number == k).map_or(0.0, |own| own.relative),
        });
        let mode = modes.min_by(|a, b| a.apart_from(frequency_hz).total_cmp(&b.apart_from(frequency_hz)));
        Ok(Some(Self { growth_rate_per_s, speed_rpm, frequency_hz, mode }))
    }

    /// That the loop is unstable, where, and which mode is behind it, in two sentences.
    pub(crate) fn words(&self) -> String {
        let first = unstable_words(self.growth_rate_per_s, self.speed_rpm);
        let frequency = format!("What grows has {:.1} Hz", self.frequency_hz);
        match &self.mode {
            Some(mode) => {
                let [backward, forward] = mode.at_top_speed_hz;
                format!(
                    "{first}. {frequency}; flexible mode {} next to it has {:.1} Hz at rest and splits to {backward:.1} and \
                     {forward:.1} Hz at top speed, and the synthesis covered a shift of {:.1} % of it.",
                    mode.number,
                    mode.at_rest_hz,
                    100.0 * mode.covered
                )
            }
            None => format!("{first}. {frequency}."),
        }
    }
}

impl GrowingMode {
    /// Distance of a frequency from the range between both whirls, in octaves.
    fn apart_from(&self, frequency_hz: f64) -> f64 {
        let [backward, forward] = self.at_top_speed_hz;
        let (low, high) = (backward.min(self.at_rest_hz), forward.max(self.at_rest_hz));
        let nearest = frequency_hz.clamp(low, high);
        (nearest / frequency_hz.max(f64::MIN_POSITIVE)).log2().abs()
    }
}
