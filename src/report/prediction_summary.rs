//! Stiffness, sensitivity and damping of a loop as topics of the summary.

use crate::pipeline::comparison::Prediction;
use crate::pipeline::loop_stability::unstable_words;
use crate::predict::sensitivity::Zone;
use serde_json::{Value, json};

/// `stiffness.<controller>`: tool stiffness at rest and at top speed; null with the reason for an unstable loop.
pub(crate) fn stiffness_topic(ends: [&Prediction; 2]) -> Value {
    with_top_speed(ends.map(stiffness_at_speed))
}

fn with_top_speed([mut rest, speed]: [Value; 2]) -> Value {
    rest["at_top_speed"] = speed;
    rest
}

fn stiffness_at_speed(prediction: &Prediction) -> Value {
    let figures = json!({
        "minimum_n_per_m": prediction.minimum.0,
        "minimum_frequency_hz": prediction.minimum.1,
        "at_10_hz_n_per_m": prediction.at_10_hz_n_per_m,
        "at_max_speed_n_per_m": prediction.at_max_speed_n_per_m,
        // Of the slowest pole of the loop; then the time until a static load has moved the tool to within 2 % of where
        // it stays, in the linear loop.
        "slowest_decay_per_s": if prediction.is_stable() { -prediction.growth_rate_per_s } else { f64::NAN },
        "static_load_settling_s": prediction.static_load_settling_s,
    });
    with_instability(figures, prediction)
}

/// `sensitivity.<controller>` (ISO 14839-3) at rest and at top speed; null with the reason for an unstable loop.
pub(crate) fn sensitivity_topic(ends: [&Prediction; 2]) -> Value {
    with_top_speed(ends.map(sensitivity_at_speed))
}

/// Largest sensitivity of each axis, dB; not a number for an unstable loop.
pub(crate) fn axes_db(prediction: &Prediction) -> [f64; 4] {
    let db = |axis: usize| 20.0 * prediction.sensitivity.peak(axis).0.log10();
    std::array::from_fn(|axis| if prediction.is_stable() { db(axis) } else { f64::NAN })
}

/// Largest sensitivity of each bearing, dB: of its worse axis.
pub(crate) fn bearings_db(prediction: &Prediction) -> [f64; 2] {
    let [front_x, front_y, rear_x, rear_y] = axes_db(prediction);
    [front_x.max(front_y), rear_x.max(rear_y)]
}

fn sensitivity_at_speed(prediction: &Prediction) -> Value {
    let axes_db = axes_db(prediction);
    let zone = prediction.zone().map(Zone::letter);
    let [front_db, rear_db] = bearings_db(prediction);
    let figures = json!({ "front_db": front_db, "rear_db": rear_db, "axes_db": axes_db, "zone": zone });
    with_instability(figures, prediction)
}

/// Adds why an unstable loop has no figures.
fn with_instability(mut figures: Value, prediction: &Prediction) -> Value {
    if !prediction.is_stable() {
        figures["growth_rate_per_s"] = json!(prediction.growth_rate_per_s);
        figures["reason"] = json!(unstable_words(prediction.growth_rate_per_s, prediction.speed_rpm));
    }
    figures
}

/// `damping_ratio.<controller>`: closed-loop damping ratio of each flexible mode, that of the least damped pole among
/// those that show in the mode.
pub(crate) fn damping_ratios(prediction: &Prediction, modes: usize) -> Vec<Option<f64>> {
    let shown = prediction.modes.flexible.iter().take(modes);
    shown.map(|mode| mode.map(|m| m.damping_ratio)).collect()
}
