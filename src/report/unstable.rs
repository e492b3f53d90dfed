//! A design whose loop is unstable at some speed: why, as the topic `instability` of the summary. Figures of a stable
//! loop are left out of its report.

use super::whole::Report;
use crate::pid::surviving::SurvivingLaw;
use crate::pipeline::design::Design;
use crate::pipeline::instability::{GrowingMode, Instability};
use serde_json::{Value, json};

/// States in verdict, sentences and summary that a design is unstable; true where it is.
pub(crate) fn add_instability(report: &mut Report, design: &Design) -> bool {
    let (Some(found), Some(words)) = (&design.instability, design.instability_words()) else {
        return false;
    };
    report.verdict(false, &found.first_words());
    report.summary.set("plain_words", &words);
    let polish = design.polish.as_ref();
    let search = polish.and_then(|polish| polish.surviving.as_ref()).map(search_topic);
    let proven_to_rpm = design.delivery.speed_proof.proven_to_rpm();
    report.summary.set("instability", instability_topic(found, &words, proven_to_rpm, search));
    true
}

/// What was searched for a stable law, and how far that came.
pub(crate) fn search_topic(search: &SurvivingLaw) -> Value {
    json!({
        "sentence": search.words(),
        "evaluations": search.evaluations,
        "growth_rate_per_s": search.worst.rate_per_s,
        "speed_rpm": search.worst.speed_rpm,
        "frequency_hz": search.worst.frequency_hz,
    })
}

/// What grows, and the `search` for a law that is stable.
pub(crate) fn instability_topic(found: &Instability, words: &str, proven_to_rpm: f64, search: Option<Value>) -> Value {
    json!({
        "sentence": words,
        "growth_rate_per_s": found.growth_rate_per_s,
        "speed_rpm": found.speed_rpm,
        "frequency_hz": found.frequency_hz,
        "proven_to_rpm": proven_to_rpm,
        "mode": mode_topic(found.mode),
        "search": search,
    })
}

/// The motion of the free rotor behind what grows.
fn mode_topic(mode: GrowingMode) -> Value {
    let (kind, bending, forward_hz) = match mode {
        GrowingMode::Flexible(own) => ("flexible", Some(own), Some(own.at_speed_hz[1])),
        GrowingMode::Nutation { free_hz } => ("nutation", None, Some(free_hz)),
        GrowingMode::RigidBody => ("rigid body", None, None),
    };
    json!({
        "kind": kind,
        "number": bending.map(|own| own.number),
        "at_rest_hz": bending.map(|own| own.at_rest_hz),
        "backward_at_speed_hz": bending.map(|own| own.at_speed_hz[0]),
        "forward_at_speed_hz": forward_hz,
        "shift_covered": bending.map(|own| own.covered),
    })
}
