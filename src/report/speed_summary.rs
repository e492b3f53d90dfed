//! Stability and µ over speed as topics of the summary.

use crate::controller::speed_proof::{SpeedInterval, SpeedProof};
use crate::controller::verification::{SpeedCheck, Verification, growth_words};
use crate::pipeline::design::Design;
use crate::pipeline::speed_mu::SpeedMu;
use serde_json::{Value, json};

/// The proof over speed: how far it reaches, and in words.
pub(crate) fn speed_proof_topic(proof: &SpeedProof) -> Value {
    json!({
        "complete": proof.is_complete(),
        "proven_to_rpm": proof.proven_to_rpm(),
        "asked_to_rpm": proof.to_rpm,
        "centres": proof.intervals.len(),
        "narrowest_half_width_rpm": proof.narrowest().map(|i| i.radius_rpm),
        "slowest_growth_rate_per_s": proof.slowest().map(|i| i.growth_rate_per_s),
        "sentence": speed_sentence(proof),
    })
}

fn speed_sentence(proof: &SpeedProof) -> String {
    let (to, centres) = (proof.proven_to_rpm(), proof.intervals.len());
    if proof.is_complete() {
        return format!(
            "Stable at every speed from rest to {to:.0} rpm: computed at {centres} speeds, and proven between them by \
             a small gain from a change of speed back to itself (sampled loop, full finite-element plant, exact \
             delay, rounded coefficients)."
        );
    }
    match proof.slowest() {
        Some(worst) if worst.growth_rate_per_s >= 0.0 => format!(
            "Stability is proven from rest to {to:.0} rpm; the loop {}.",
            growth_words(worst.growth_rate_per_s, worst.centre_rpm)
        ),
        _ => format!(
            "Stability is proven from rest to {to:.0} rpm; beyond, the loop is stable at the speeds computed, with no \
             proof between them."
        ),
    }
}

/// Every centre of the proof.
pub(crate) fn speed_intervals(proof: &SpeedProof) -> Vec<Value> {
    let centre = |i: &SpeedInterval| {
        let (speed_rpm, within_rpm) = (i.centre_rpm, i.radius_rpm);
        json!({ "speed_rpm": speed_rpm, "proven_within_rpm": within_rpm, "growth_rate_per_s": i.growth_rate_per_s })
    };
    proof.intervals.iter().map(centre).collect()
}

/// µ of the specification over speed; an unstable loop has none.
pub(crate) fn speed_mu(design: &Design) -> Vec<Value> {
    let at = |s: &SpeedMu| {
        if !s.mu.is_finite() {
            return json!({ "speed_rpm": s.speed_rpm, "mu": null, "reason": "the loop is unstable at this speed" });
        }
        json!({
            "speed_rpm": s.speed_rpm,
            "mu": s.mu,
            "frequency_hz": s.frequency_hz.abs(),
            "whirl": if s.frequency_hz < 0.0 { "backward" } else { "forward" },
        })
    };
    design.delivery.speed_mu.iter().map(at).collect()
}

/// Conditions of a verification, and the growth of the loop at each speed.
pub(crate) fn verification_topic(verification: &Verification) -> Value {
    let at = |s: &SpeedCheck| json!({ "speed_rpm": s.speed_rpm, "growth_rate_per_s": s.growth_rate_per_s });
    json!({
        "conditions": verification.conditions,
        "speeds": verification.speeds.iter().map(at).collect::<Vec<_>>(),
    })
}
