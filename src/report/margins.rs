//! Margins of a loop as a topic of the summary and as rows for a terminal.

use super::summary::finite;
use crate::export::json::AXIS_NAMES;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::loop_curves::{LoopMargins, StableLoop};
use crate::predict::disc_margins::DiscMargins;
use crate::robust::disc_margin::DiscMargin;
use serde::Serialize;
use std::f64::consts::TAU;

/// `margins.<controller>`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MarginSummary {
    discs: Vec<DiscSummary>,
    /// Shift of the natural frequencies, in every combination that a PID is certified with, that the loop bears.
    modes_may_shift_percent: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    channels: Vec<ChannelSummary>,
}

/// Gain and phase within which one channel may change, the others as they are, or all at once, each for itself.
#[derive(Clone, Debug, Serialize)]
struct DiscSummary {
    at: &'static str,
    channel: &'static str,
    smallest_gain_factor: Option<f64>,
    largest_gain_factor: Option<f64>,
    phase_margin_deg: Option<f64>,
    at_hz: Option<f64>,
}

/// Largest change of one channel at rest by gain alone or by phase alone, the others as they are.
#[derive(Clone, Debug, Serialize)]
struct ChannelSummary {
    channel: &'static str,
    smallest_gain_factor: Option<f64>,
    largest_gain_factor: Option<f64>,
    phase_margin_deg: Option<f64>,
    at_hz: Option<f64>,
    highest_crossover_hz: Option<f64>,
}

impl MarginSummary {
    /// Of the discs at rest and at top speed.
    pub(crate) fn of(margins: &LoopMargins) -> Self {
        let mut discs = vec![];
        for (at, found) in ["rest", "top speed"].into_iter().zip(&margins.discs) {
            let Some(found) = found else { continue };
            let alone = AXIS_NAMES.into_iter().zip(&found.channels);
            let together =
                [("all at once, S + T", &found.together), ("all at once, S", &found.together_by_sensitivity)];
            discs.extend(alone.chain(together).map(|(channel, disc)| DiscSummary::of(at, channel, disc)));
        }
        Self { discs, modes_may_shift_percent: finite(100.0 * margins.mode_shift), channels: vec![] }
    }
}

impl DiscSummary {
    fn of(at: &'static str, channel: &'static str, disc: &DiscMargin) -> Self {
        let (least, most) = disc.gain_margin();
        Self {
            at,
            channel,
            smallest_gain_factor: finite(least),
            largest_gain_factor: finite(most),
            phase_margin_deg: finite(disc.phase_margin_rad().to_degrees()),
            at_hz: finite(disc.omega_rad_s / TAU),
        }
    }
}

impl From<&StableLoop> for MarginSummary {
    fn from(stable: &StableLoop) -> Self {
        let channels = AXIS_NAMES.into_iter().enumerate().map(|(k, channel)| {
            let own = stable.gain.margin(k);
            ChannelSummary {
                channel,
                smallest_gain_factor: finite(own.smallest_gain_factor),
                largest_gain_factor: finite(own.largest_gain_factor),
                phase_margin_deg: finite(own.phase_deg),
                at_hz: finite(own.phase_hz),
                highest_crossover_hz: finite(own.crossover_hz),
            }
        });
        Self { channels: channels.collect(), ..Self::of(&stable.margins) }
    }
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
    let settling = ends.map(|end| match 1e3 * end.settling_s() {
        ms if ms.is_finite() => format!("{ms:.0}"),
        _ => "-".to_owned(),
    });
    rows.push(row("settling after a static load, ms", settling));
    rows
}
