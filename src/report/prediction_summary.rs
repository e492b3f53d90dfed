//! Stiffness and sensitivity of a loop as JSON.

use super::summary::number;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::loop_stability::unstable_words;
use crate::predict::sensitivity::Zone;
use serde_json::{Value, json};

/// The `stiffness.<controller>` object; null with the reason for an unstable loop.
pub fn stiffness_json(prediction: &Prediction) -> Value {
    let figures = json!({
        "minimum_n_per_m": number(prediction.minimum.0),
        "minimum_frequency_hz": number(prediction.minimum.1),
        "at_10_hz_n_per_m": number(prediction.at_10_hz_n_per_m),
        "at_max_speed_n_per_m": number(prediction.at_max_speed_n_per_m),
    });
    with_reason(figures, prediction)
}

/// Figures of a loop, with the reason when there are none.
fn with_reason(mut figures: Value, prediction: &Prediction) -> Value {
    if let (false, Some(map)) = (prediction.is_stable(), figures.as_object_mut()) {
        let growth = number(prediction.growth_rate_per_s);
        map.insert("growth_rate_per_s".to_owned(), growth);
        let words = unstable_words(prediction.growth_rate_per_s, prediction.speed_rpm);
        map.insert("reason".to_owned(), words.into());
    }
    figures
}

/// The `sensitivity.<controller>` object (ISO 14839-3).
pub fn sensitivity_json(prediction: &Prediction) -> Value {
    let stable = prediction.is_stable();
    let db = |axis: usize| {
        let peak = prediction.sensitivity.peak(axis).0;
        number(if stable {
            20.0 * peak.log10()
        } else {
            f64::NAN
        })
    };
    let figures = json!({
        "front_db": db(0),
        "rear_db": db(2),
        "axes_db": [db(0), db(1), db(2), db(3)],
        "zone": prediction.zone().map(Zone::letter),
    });
    with_reason(figures, prediction)
}
