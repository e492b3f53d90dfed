//! What the polish did as a topic of the summary: figures before and after, limits, rounds.

use crate::controller::polish::PolishRound;
use crate::pipeline::judged::Judged;
use crate::pipeline::polish_outcome::{PolishAttempt, PolishOutcome};
use crate::predict::sensitivity::Zone;
use serde_json::{Value, json};

pub(crate) fn polish_topic(polish: &PolishOutcome) -> Value {
    let limits = &polish.limits;
    let attempts = polish.attempts.iter().enumerate();
    json!({
        "delivered": polish.delivered.is_some(),
        "sentence": polish.sentence,
        "dk": polish.dk.as_ref().map(judged_topic),
        "limits": {
            "sensitivity_db": 20.0 * limits.sensitivity.log10(),
            "high_frequency_from_hz": limits.high_frequency_hz,
            "high_frequency_gain_a_per_m": limits.high_frequency_gain_a_per_m,
            "noise_current_a": limits.noise_current_a,
            "mu": limits.mu,
            "mu_of": polish.held_to.words(),
        },
        "attempts": attempts.map(|(k, a)| attempt_topic(a, polish.delivered == Some(k))).collect::<Vec<_>>(),
    })
}

fn attempt_topic(attempt: &PolishAttempt, delivered: bool) -> Value {
    let certified = attempt.certificates.iter().map(|(mu, hz)| json!({ "mu": mu, "frequency_hz": hz }));
    json!({
        "start": attempt.start,
        "delivered": delivered,
        "objections": attempt.objections,
        "failure": attempt.failure,
        "polished": attempt.judged.as_ref().map(judged_topic),
        "rounds": attempt.rounds.iter().map(round_topic).collect::<Vec<_>>(),
        "certificates": certified.collect::<Vec<_>>(),
    })
}

/// A round with the largest ratio of each quantity to its limit.
fn round_topic(round: &PolishRound) -> Value {
    let [sensitivity, high_frequency_gain, noise_current, mu, weak_magnets, tool_stiffness] = round.over_limit;
    json!({
        "steps": round.steps,
        "lines": round.lines,
        "stiffness_of_the_loss_n_per_m": round.stiffness_n_per_m,
        "over_limit": {
            "sensitivity": sensitivity,
            "high_frequency_gain": high_frequency_gain,
            "noise_current": noise_current,
            "mu": mu,
            "weak_magnets": weak_magnets,
            "tool_stiffness": tool_stiffness,
        },
    })
}

/// Figures of a controller as the polish judges it.
fn judged_topic(judged: &Judged) -> Value {
    let [zone, zone_at_top_speed] = judged.zones.map(|zone| zone.map(Zone::letter));
    json!({
        "controller_order": judged.order,
        "largest_mu": judged.mu,
        "mu_table_as_written": judged.mu_at_rest[0],
        "mu_with_gyroscopic_cover": judged.mu_at_rest[1],
        "minimum_n_per_m": judged.stiffness_n_per_m[0],
        "minimum_at_top_speed_n_per_m": judged.stiffness_n_per_m[1],
        "zone": zone,
        "zone_at_top_speed": zone_at_top_speed,
    })
}
