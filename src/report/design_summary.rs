//! What a design proves and what it was compared with, as JSON: speeds, stability of the controller, arithmetics,
//! variants.

use super::prediction_summary::{sensitivity_json, stiffness_json};
use super::summary::number;
use crate::augment::plane::Route;
use crate::controller::speed_proof::SpeedProof;
use crate::controller::stiffness_limit::StiffnessLimit;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::design::Design;
use crate::pipeline::emulation::Emulated;
use crate::pipeline::judged::Judged;
use crate::pipeline::polishing::{PolishAttempt, PolishOutcome};
use crate::pipeline::specification_scale::SpecificationScale;
use crate::pipeline::stable::OwnStability;
use crate::predict::sensitivity::Zone;
use serde_json::{Value, json};

/// The proof over speed: how far it reaches, and in words.
pub fn speed_proof_json(proof: &SpeedProof) -> Value {
    json!({
        "complete": proof.is_complete(),
        "proven_to_rpm": number(proof.proven_to_rpm()),
        "asked_to_rpm": number(proof.to_rpm),
        "centres": proof.intervals.len(),
        "narrowest_half_width_rpm": proof.narrowest().map(|i| number(i.radius_rpm)),
        "slowest_growth_rate_per_s": proof.slowest().map(|i| number(i.growth_rate_per_s)),
        "sentence": speed_sentence(proof),
    })
}

/// The proof in a sentence.
pub fn speed_sentence(proof: &SpeedProof) -> String {
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
            "Stability is proven from rest to {to:.0} rpm; at {:.0} rpm the loop grows by {:.1} 1/s.",
            worst.centre_rpm, worst.growth_rate_per_s
        ),
        _ => format!(
            "Stability is proven from rest to {to:.0} rpm; beyond, the loop is stable at the speeds computed, with no \
             proof between them."
        ),
    }
}

/// Every centre of the proof.
pub fn speed_intervals_json(proof: &SpeedProof) -> Value {
    let rows = proof.intervals.iter().map(|i| {
        json!({
            "speed_rpm": number(i.centre_rpm),
            "proven_within_rpm": number(i.radius_rpm),
            "growth_rate_per_s": number(i.growth_rate_per_s),
        })
    });
    Value::Array(rows.collect())
}

/// The model that every μ of a design is of, what is proven of it, and the syntheses that it asked for.
pub fn mu_model_json(design: &Design) -> Value {
    let problems = &design.problems;
    let rounds = design.rounds.iter().map(|r| {
        json!({
            "synthesis_modes": r.synthesis_modes,
            "gamma_target": number(r.gamma_target),
            "mu_synthesis_model": number(r.synthesis),
            "mu_whole_machine": number(r.whole_machine),
            "frequency_hz": number(r.frequency_hz),
        })
    });
    json!({
        "sentence": format!(
            "µ is of the whole machine: {} flexible modes below half the sample rate and the static flexibility of \
             the others, sampled with hold and exact delay, weights of true frequency, loads and modal forces not \
             held. The upper bound is certified over all frequencies for the rational realisation of this model, and \
             is not below any line of the exact frequency responses at rest; over speed it is the largest of the \
             exact responses on a grid.",
            problems.machine_modes
        ),
        "covered": format!(
            "mu_peak, mu_peak_reduced and mu_peak_discrete are of {} with the gyroscopic split of {} modes covered; \
             table_as_written, mu_over_speed and largest_mu are of the specification as written.",
            problems.widening.words(),
            problems.cover.modes
        ),
        "machine_modes": problems.machine_modes,
        "synthesis_modes": problems.synthesis_modes,
        "synthesis_weights_excess": number(problems.fit_errors.synthesis),
        "inverse_hold_fit_error": number(problems.fit_errors.hold),
        "rounds": Value::Array(rounds.collect()),
    })
}

/// μ of the specification over speed; an unstable loop has none.
pub fn speed_mu_json(design: &Design) -> Value {
    let rows = design.delivery.speed_mu.iter().map(|s| {
        if !s.mu.is_finite() {
            return json!({
                "speed_rpm": number(s.speed_rpm),
                "mu": null,
                "reason": "the loop is unstable at this speed",
            });
        }
        json!({
            "speed_rpm": number(s.speed_rpm),
            "mu": number(s.mu),
            "frequency_hz": number(s.frequency_hz.abs()),
            "whirl": if s.frequency_hz < 0.0 { "backward" } else { "forward" },
        })
    });
    Value::Array(rows.collect())
}

/// What was tried for the sake of a stable controller.
pub fn alternatives_json(own: &OwnStability) -> Value {
    let rows = own.alternatives.iter().enumerate().map(|(k, a)| {
        json!({
            "lever": a.lever,
            "growth_rate_per_s": number(a.growth_rate_per_s),
            "mu": number(a.mu),
            "delivered": own.chosen == Some(k),
        })
    });
    Value::Array(rows.collect())
}

/// What sampling did to an emulated design.
pub fn emulation_json(emulated: &Emulated) -> Value {
    json!({
        "prewarp_hz": number(emulated.prewarp_hz),
        "mu_continuous": number(emulated.mu_continuous),
        "mu_sampled": number(emulated.mu_sampled),
    })
}

/// At how many times its limits a missed specification is met.
pub fn scale_json(scale: &SpecificationScale) -> Value {
    json!({
        "sentence": scale.sentence(),
        "factor": number(scale.factor),
        "binds": scale.binds,
        "key": scale.key,
        "speed_rpm": number(scale.speed_rpm),
        "frequency_hz": number(scale.frequency_hz),
    })
}

/// The limit of the smallest stiffness over all linear controllers, and how much of it the delivered one reaches.
pub fn limit_json(limit: &StiffnessLimit, reached_n_per_m: f64) -> Value {
    json!({
        "minimum_n_per_m": number(limit.stiffness_n_per_m),
        "with_half_the_taps_n_per_m": number(limit.with_half_the_taps_n_per_m),
        "taps": limit.taps,
        "lines": limit.lines,
        "share_reached": number(reached_n_per_m / limit.stiffness_n_per_m),
        "model": "rotor at rest, whole plant with hold and delay at lines of frequency, zone A, limits of gain and \
         noise current; over the stabilising sampled linear controllers whose Youla parameter has these taps: more \
                  taps can only raise it",
    })
}

/// What the polish did: figures before and after, limits, rounds.
pub fn polish_json(polish: &PolishOutcome) -> Value {
    let limits = &polish.limits;
    let attempts = polish.attempts.iter().enumerate();
    json!({
        "delivered": polish.delivered.is_some(),
        "sentence": polish.sentence,
        "dk": judged_json(&polish.dk),
        "limits": {
            "sensitivity_db": number(20.0 * limits.sensitivity.log10()),
            "high_frequency_from_hz": number(limits.high_frequency_hz),
            "high_frequency_gain_a_per_m": number(limits.high_frequency_gain_a_per_m),
            "noise_current_a": number(limits.noise_current_a),
            "mu": number(limits.mu),
            "mu_of": polish.held_to.words(),
        },
        "attempts": attempts
            .map(|(k, attempt)| attempt_json(attempt, polish.delivered == Some(k)))
            .collect::<Vec<_>>(),
    })
}

fn attempt_json(attempt: &PolishAttempt, delivered: bool) -> Value {
    let rounds = attempt.rounds.iter().map(|r| {
        json!({
            "steps": r.steps,
            "lines": r.lines,
            "stiffness_of_the_loss_n_per_m": number(r.stiffness_n_per_m),
            "over_limit": {
                "sensitivity": number(r.over_limit[0]),
                "high_frequency_gain": number(r.over_limit[1]),
                "noise_current": number(r.over_limit[2]),
                "mu": number(r.over_limit[3]),
                "weak_magnets": number(r.over_limit[4]),
            },
        })
    });
    let certificates = attempt.certificates.iter().map(|(mu, hz)| {
        json!({
            "mu": number(*mu),
            "frequency_hz": number(*hz),
        })
    });
    json!({
        "start": attempt.start,
        "delivered": delivered,
        "objections": attempt.objections,
        "failure": attempt.failure,
        "polished": attempt.judged.as_ref().map(judged_json),
        "rounds": Value::Array(rounds.collect()),
        "certificates": Value::Array(certificates.collect()),
    })
}

fn judged_json(judged: &Judged) -> Value {
    json!({
        "controller_order": judged.order,
        "largest_mu": number(judged.mu),
        "mu_table_as_written": number(judged.mu_at_rest[0]),
        "mu_with_gyroscopic_cover": number(judged.mu_at_rest[1]),
        "minimum_n_per_m": number(judged.stiffness_n_per_m[0]),
        "minimum_at_top_speed_n_per_m": number(judged.stiffness_n_per_m[1]),
        "zone": judged.zones[0].map(Zone::letter),
        "zone_at_top_speed": judged.zones[1].map(Zone::letter),
    })
}

/// The route in a word.
pub fn route_word(route: Route) -> &'static str {
    match route {
        Route::Direct => "direct",
        Route::Emulation { .. } => "emulation",
    }
}

/// μ and tool stiffness at rest with the coefficients of each arithmetic; `predictions` in the order of the design's
/// list.
pub fn arithmetic_json(design: &Design, predictions: &[Prediction]) -> Value {
    let rows = design
        .delivery
        .arithmetic
        .iter()
        .zip(predictions)
        .map(|(a, p)| {
            json!({
                "coefficients": a.name,
                "mu_peak": number(a.covered),
                "mu_table_as_written": number(a.specification),
                "minimum_stiffness_n_per_m": number(p.minimum.0),
                "minimum_stiffness_frequency_hz": number(p.minimum.1),
                "stiffness_at_10_hz_n_per_m": number(p.at_10_hz_n_per_m),
            })
        });
    Value::Array(rows.collect())
}

/// A design beside others: what it was asked, μ, stiffness and sensitivity at rest.
pub fn variant_json(name: &str, design: &Design, rest: &Prediction) -> Value {
    let (stiffness, sensitivity) = (stiffness_json(rest), sensitivity_json(rest));
    json!({
        "design": name,
        "mu_synthesised": number(design.emulated.map_or(design.full.synthesis, |e| e.mu_continuous)),
        "mu_sampled": number(design.full.synthesis),
        "mu_peak_discrete": number(design.delivery.rounded.covered.upper),
        "mu_table_as_written": number(design.delivery.rounded.specification.upper),
        "controller_order": 2 * design.delivery.rounded.order,
        "complementary_sensitivity_limit": design.problems.sensitivity_limit.map(number),
        "minimum_n_per_m": stiffness["minimum_n_per_m"],
        "minimum_frequency_hz": stiffness["minimum_frequency_hz"],
        "at_10_hz_n_per_m": stiffness["at_10_hz_n_per_m"],
        "at_max_speed_n_per_m": stiffness["at_max_speed_n_per_m"],
        "static_tool_n_per_m": number(design.delivery.static_stiffness_n_per_m[0]),
        "front_db": sensitivity["front_db"],
        "rear_db": sensitivity["rear_db"],
        "zone": sensitivity["zone"],
        "stable": design.is_stable(),
    })
}
