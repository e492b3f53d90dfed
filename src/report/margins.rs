//! Margins of a loop as a topic of the summary and as rows for a terminal.

use crate::export::json::AXIS_NAMES;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::loop_curves::{LoopMargins, StableLoop};
use crate::predict::disc_margins::DiscMargins;
use crate::robust::disc_margin::DiscMargin;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// `margins.<controller>`: discs at rest and at top speed, the shift of the natural frequencies, in every combination
/// that a PID is certified with, that the loop bears.
pub(crate) fn margin_topic(margins: &LoopMargins) -> Value {
    let mut discs = vec![];
    for (at, found) in ["rest", "top speed"].into_iter().zip(&margins.discs) {
        let Some(found) = found else { continue };
        let alone = AXIS_NAMES.into_iter().zip(&found.channels);
        let together = [("all at once, S + T", &found.together), ("all at once, S", &found.together_by_sensitivity)];
        discs.extend(alone.chain(together).map(|(channel, disc)| disc_topic(at, channel, disc)));
    }
    json!({ "discs": discs, "modes_may_shift_percent": 100.0 * margins.mode_shift })
}

/// Gain and phase within which one channel may change, the others as they are, or all at once, each for itself.
fn disc_topic(at: &str, channel: &str, disc: &DiscMargin) -> Value {
    let (least, most) = disc.gain_margin();
    json!({
        "at": at,
        "channel": channel,
        "smallest_gain_factor": least,
        "largest_gain_factor": most,
        "phase_margin_deg": disc.phase_margin_rad().to_degrees(),
        "at_hz": disc.omega_rad_s / TAU,
    })
}

/// The same with the largest change of one channel at rest by gain alone or by phase alone, the others as they are.
pub(crate) fn stable_margin_topic(stable: &StableLoop) -> Value {
    let mut topic = margin_topic(&stable.margins);
    let channels = AXIS_NAMES.into_iter().enumerate().map(|(k, channel)| {
        let own = stable.gain.margin(k);
        json!({
            "channel": channel,
            "smallest_gain_factor": own.smallest_gain_factor,
            "largest_gain_factor": own.largest_gain_factor,
            "phase_margin_deg": own.phase_deg,
            "at_hz": own.phase_hz,
            "highest_crossover_hz": own.crossover_hz,
        })
    });
    topic["channels"] = json!(channels.collect::<Vec<_>>());
    topic
}

/// What the gains may change by at rest and at top speed, one channel alone and all at once, and how long a static
/// load moves the tool, as rows of a terminal.
pub(crate) fn loop_rows(ends: [&Prediction; 2], stable: Option<&StableLoop>) -> Vec<Vec<String>> {
    let row = |name: &str, cells: [String; 2]| {
        vec![format!("{name}, at rest and at top speed"), cells.join(", "), String::new()]
    };
    let gains = |pick: fn(&DiscMargins) -> &DiscMargin, stable: &StableLoop| {
        stable.margins.discs.each_ref().map(|found| match found {
            Some(found) => {
                let (least, most) = pick(found).gain_margin();
                format!("{least:.2} … {most:.2}")
            }
            None => "-".to_owned(),
        })
    };
    let mut rows = vec![];
    if let Some(stable) = stable {
        rows.push(row("gain of one channel (disc)", gains(DiscMargins::worst_channel, stable)));
        rows.push(row("gains of all channels at once (disc)", gains(|found| &found.together, stable)));
        let shift = format!("{:.1}", 100.0 * stable.margins.mode_shift);
        rows.push(vec!["shift of the natural frequencies that it bears, %".to_owned(), shift, String::new()]);
    }
    let settling = ends.map(|end| match 1e3 * end.static_load_settling_s {
        ms if ms.is_finite() => format!("{ms:.0}"),
        _ => "-".to_owned(),
    });
    rows.push(row("settling after a static load, ms", settling));
    rows
}
