//! Stiffness, sensitivity and damping of a loop as topics of the summary.

use super::summary::finite;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::loop_stability::unstable_words;
use crate::predict::sensitivity::Zone;
use serde::{Deserialize, Serialize};

/// Why an unstable loop has no figures.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Unstable {
    #[serde(skip_serializing_if = "Option::is_none")]
    growth_rate_per_s: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

impl Unstable {
    fn of(prediction: &Prediction) -> Self {
        if prediction.is_stable() {
            return Self::default();
        }
        let (growth, rpm) = (prediction.growth_rate_per_s, prediction.speed_rpm);
        Self { growth_rate_per_s: Some(finite(growth)), reason: Some(unstable_words(growth, rpm)) }
    }
}

/// `stiffness.<controller>`: tool stiffness; null with the reason for an unstable loop.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct StiffnessSummary {
    pub(crate) minimum_n_per_m: Option<f64>,
    pub(crate) minimum_frequency_hz: Option<f64>,
    pub(crate) at_10_hz_n_per_m: Option<f64>,
    pub(crate) at_max_speed_n_per_m: Option<f64>,
    /// Of the slowest pole of the loop.
    pub(crate) slowest_decay_per_s: Option<f64>,
    /// Until a static load that begins or ends has moved the tool to within 2 % of where it stays, by that pole.
    pub(crate) static_load_settling_s: Option<f64>,
    #[serde(flatten)]
    unstable: Unstable,
    #[serde(skip_serializing_if = "Option::is_none")]
    at_top_speed: Option<Box<StiffnessSummary>>,
}

impl StiffnessSummary {
    /// At one speed.
    pub(crate) fn of(prediction: &Prediction) -> Self {
        Self {
            minimum_n_per_m: finite(prediction.minimum.0),
            minimum_frequency_hz: finite(prediction.minimum.1),
            at_10_hz_n_per_m: finite(prediction.at_10_hz_n_per_m),
            at_max_speed_n_per_m: finite(prediction.at_max_speed_n_per_m),
            slowest_decay_per_s: finite(-prediction.growth_rate_per_s).filter(|_| prediction.is_stable()),
            static_load_settling_s: finite(prediction.settling_s()),
            unstable: Unstable::of(prediction),
            at_top_speed: None,
        }
    }

    /// At rest, with the figures at top speed.
    pub(crate) fn of_both([rest, speed]: [&Prediction; 2]) -> Self {
        Self { at_top_speed: Some(Box::new(Self::of(speed))), ..Self::of(rest) }
    }
}

/// `sensitivity.<controller>` (ISO 14839-3); null with the reason for an unstable loop.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct SensitivitySummary {
    pub(crate) front_db: Option<f64>,
    pub(crate) rear_db: Option<f64>,
    axes_db: [Option<f64>; 4],
    pub(crate) zone: Option<String>,
    #[serde(flatten)]
    unstable: Unstable,
    #[serde(skip_serializing_if = "Option::is_none")]
    at_top_speed: Option<Box<SensitivitySummary>>,
}

impl SensitivitySummary {
    /// At one speed.
    pub(crate) fn of(prediction: &Prediction) -> Self {
        let axes_db = std::array::from_fn(|axis| {
            let peak = prediction.sensitivity.peak(axis).0;
            finite(20.0 * peak.log10()).filter(|_| prediction.is_stable())
        });
        Self {
            front_db: axes_db[0],
            rear_db: axes_db[2],
            axes_db,
            zone: prediction.zone().map(Zone::letter).map(str::to_owned),
            unstable: Unstable::of(prediction),
            at_top_speed: None,
        }
    }

    /// At rest, with the figures at top speed.
    pub(crate) fn of_both([rest, speed]: [&Prediction; 2]) -> Self {
        Self { at_top_speed: Some(Box::new(Self::of(speed))), ..Self::of(rest) }
    }
}

/// `damping_ratio.<controller>`: closed-loop damping ratio of each flexible mode, that of the least damped pole among
/// those that show in the mode.
pub(crate) fn damping_ratios(prediction: &Prediction, modes: usize) -> Vec<Option<f64>> {
    let shown = prediction.modes.flexible.iter().take(modes);
    shown.map(|mode| mode.and_then(|m| finite(m.damping_ratio))).collect()
}
