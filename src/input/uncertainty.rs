//! The uncertainty of a weights file besides that of the natural frequencies, to [`Uncertainty`].

use super::curve::CurvesFile;
use super::error::InputError;
use super::error_list::ErrorList;
use super::key::{Key, Range, keys, number, positive};
use crate::augment::hardware::Uncertainty;
use crate::augment::shape::Shape;
use schemars::JsonSchema;
use serde::Deserialize;

const CORNER: [Range; 2] = [[1.0, 2e4], [1e-4, 1e7]];
const ABOVE: &str = "models fail above the band that was measured";

pub(super) const KEYS: &[Key] = keys! {
    number "force_constant" "" [[1e-3, 0.3], [0.0, 1.0]] "force constants are known to some per cent";
    number "negative_stiffness" "" [[1e-3, 0.5], [0.0, 1.0]]
        "negative stiffness grows with the bias and falls with the gap, each known to some per cent";
    positive "delay_s" "s" [[1e-7, 1e-3], [1e-12, 1.0]] "a loop's delay is known to a part of the sample period";
};
pub(super) const ACTUATOR_KEYS: &[Key] = &{
    const SIZE: [Range; 2] = [[1e-3, 10.0], [1e-9, 1e6]];
    const WHY: &str = "amplifiers and magnets are known to some per cent in the band";
    [
        positive("low", "", [[1e-3, 0.9], [1e-9, 1e6]], WHY),
        positive("high", "", SIZE, ABOVE),
        positive("crossover_hz", "Hz", CORNER, ABOVE),
    ]
};
pub(super) const SENSOR_KEYS: &[Key] = &{
    const SIZE: [Range; 2] = [[1e-10, 1e-3], [1e-15, 1.0]];
    const WHY: &str = "an ampere moves a spindle by some micrometres";
    [
        positive("low_m_per_a", "m/A", SIZE, WHY),
        positive("high_m_per_a", "m/A", SIZE, ABOVE),
        positive("crossover_hz", "Hz", CORNER, ABOVE),
    ]
};

/// What actuators, sensors and delay may do otherwise than the model.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct UncertaintyFile {
    /// Relative error of the actuators over frequency (multiplicative, complex).
    actuator: Option<RelativeFile>,
    /// Error of the signals over frequency, per ampere of the bearing's current (additive, complex): dynamics that the
    /// model leaves out.
    sensor: Option<AdditiveFile>,
    /// Relative error of ki (real); 0.05 is five per cent either way.
    force_constant: Option<f64>,
    /// Relative error of ks (real).
    negative_stiffness: Option<f64>,
    /// Error of the loop's delay either way.
    delay_s: Option<f64>,
}

/// A relative error over frequency.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RelativeFile {
    /// At low frequency.
    low: f64,
    /// At high frequency.
    high: f64,
    /// Where it is the geometric mean of both.
    crossover_hz: f64,
}

/// An additive error over frequency.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AdditiveFile {
    /// At low frequency.
    low_m_per_a: f64,
    /// At high frequency.
    high_m_per_a: f64,
    /// Where it is the geometric mean of both.
    crossover_hz: f64,
}

/// Uncertainty with every value checked; what is given as a curve stands in `curves`.
pub(super) fn uncertainty(errors: &mut ErrorList<'_>, read: &UncertaintyFile, curves: &CurvesFile) -> Uncertainty {
    let file = errors.file;
    let relative = [("force_constant", read.force_constant), ("negative_stiffness", read.negative_stiffness)];
    for (key, value) in relative {
        if let Some(value) = value
            && !(0.0..1.0).contains(&value)
        {
            let rule = format!("uncertainty.{key}: {value} must be at least 0 and below 1");
            errors.add_rule(InputError::new(file, rule).with_hint("0.05 means five per cent either way"));
        }
    }
    let actuator = read.actuator.as_ref().map(|a| [a.low, a.high, a.crossover_hz]);
    let sensor = read.sensor.as_ref().map(|s| [s.low_m_per_a, s.high_m_per_a, s.crossover_hz]);
    let shape = |key: &str, levels: Option<[f64; 3]>, curve: Option<Shape>| match (levels, curve) {
        (Some(_), Some(_)) => {
            let rule = format!("uncertainty.{key}: is given by levels and by a curve as well");
            Err(InputError::new(file, rule).with_hint("leave out one of the two"))
        }
        (None, curve) => Ok(curve),
        (Some([low, high, crossover_hz]), None) => Shape::level_change(low, high, crossover_hz)
            .map(Some)
            .map_err(|error| InputError::new(file, format!("uncertainty.{key}: {error}"))),
    };
    let mut take = |key: &str, levels, curve: Result<Option<Shape>, InputError>| {
        let shape = curve.and_then(|curve| shape(key, levels, curve));
        errors.take_rule(shape).flatten()
    };
    Uncertainty {
        actuator: take("actuator", actuator, curves.actuator(file)),
        sensor: take("sensor", sensor, curves.sensor(file)),
        force_constant: read.force_constant.unwrap_or(0.0),
        negative_stiffness: read.negative_stiffness.unwrap_or(0.0),
        delay_s: read.delay_s.unwrap_or(0.0),
        ks_n_per_m: None,
    }
}
