//! Designs beside others as topics of the summary: arithmetics, routes, a tightened specification, the limit of the
//! stiffness.

use super::prediction_summary::bearings_db;
use crate::augment::plane::Route;
use crate::controller::stiffness_limit::StiffnessLimit;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::design::Design;
use crate::pipeline::study::{AsWritten, OtherRoute};
use crate::pipeline::tightening::Tightening;
use crate::predict::sensitivity::Zone;
use serde_json::{Value, json};

pub(crate) fn route_word(route: Route) -> &'static str {
    match route {
        Route::Direct => "direct",
        Route::Emulation { .. } => "emulation",
    }
}

/// `design.stiffness_limit`: the limit of the smallest stiffness over all linear controllers, and how much of it the
/// delivered one reaches, N/m.
pub(crate) fn limit_topic(limit: &StiffnessLimit, reached_n_per_m: f64) -> Value {
    json!({
        "minimum_n_per_m": limit.stiffness_n_per_m,
        "with_half_the_taps_n_per_m": limit.with_half_the_taps_n_per_m,
        "extrapolated_n_per_m": limit.extrapolated_n_per_m,
        "taps": limit.taps,
        "lines": limit.lines,
        "share_reached": reached_n_per_m / limit.stiffness_n_per_m,
        "model": "rotor at rest, whole plant with hold and delay at lines of frequency, zone A, limits of gain and \
                  noise current; over the stabilising sampled linear controllers whose Youla parameter has these \
                  taps: more taps can only raise it",
    })
}

/// µ and tool stiffness at rest with the coefficients of every arithmetic; `predictions` in the order of the design's
/// list.
pub(crate) fn arithmetic_topic(design: &Design, predictions: &[Prediction]) -> Vec<Value> {
    let both = design.delivery.arithmetic.iter().zip(predictions);
    both.map(|(a, p)| {
        json!({
            "coefficients": a.name,
            "mu_peak": a.covered,
            "mu_table_as_written": a.specification,
            "minimum_stiffness_n_per_m": p.minimum.0,
            "minimum_stiffness_frequency_hz": p.minimum.1,
            "stiffness_at_10_hz_n_per_m": p.at_10_hz_n_per_m,
        })
    })
    .collect()
}

/// A design beside others: what it was asked, µ, stiffness and sensitivity at rest.
fn variant_topic(name: &str, design: &Design, rest: &Prediction) -> Value {
    let rounded = &design.delivery.rounded;
    let dk = design.dk.as_ref();
    let synthesised = dk.map(|dk| dk.full.synthesis);
    let emulated = dk.and_then(|dk| dk.emulated);
    let [front_db, rear_db] = bearings_db(rest);
    json!({
        "design": name,
        "mu_synthesised": emulated.map(|e| e.mu_continuous).or(synthesised),
        "mu_sampled": synthesised,
        "mu_peak_discrete": rounded.covered.upper,
        "mu_table_as_written": rounded.specification.upper,
        "controller_order": 2 * rounded.order,
        "complementary_sensitivity_limit": design.problems.sensitivity_limit,
        "minimum_n_per_m": rest.minimum.0,
        "minimum_frequency_hz": rest.minimum.1,
        "at_10_hz_n_per_m": rest.at_10_hz_n_per_m,
        "at_max_speed_n_per_m": rest.at_max_speed_n_per_m,
        "static_tool_n_per_m": design.delivery.static_stiffness_n_per_m[0],
        "front_db": front_db,
        "rear_db": rear_db,
        "zone": rest.zone().map(Zone::letter),
        "stable": design.is_stable(),
    })
}

/// Designs by both routes, the direct one first: `design` by `route` with its loop at rest, and the other, or why that
/// does not survive sampling.
pub(crate) fn routes_topic(route: Route, design: &Design, rest: &Prediction, other: &OtherRoute) -> [Value; 2] {
    let own = variant_topic(route_word(route), design, rest);
    let name = route_word(other.route);
    let found = match &other.found {
        Ok(found) => variant_topic(name, &found.0, &found.1),
        Err(failure) => json!({ "design": name, "stable": false, "failure": failure }),
    };
    match route {
        Route::Direct => [own, found],
        Route::Emulation { .. } => [found, own],
    }
}

/// `tightening`: the design with a tightened specification, whose loop at rest is `rest`, beside the one as written.
pub(crate) fn tightening_topic(written: &AsWritten, design: &Design, rest: &Prediction) -> Value {
    let (before, factor) = (&written.rest, written.factor);
    let percent = |now: f64, then: f64| 100.0 * (now / then - 1.0);
    let sentence = format!(
        "The tool's displacement limits divided by {factor:.2} give µ {}; against the design as written the \
         softest point changes by {:+.0} % (now at {:.0} Hz), the stiffness at 10 Hz by {:+.0} %, at the \
         frequency of the top speed by {:+.0} %.",
        design.delivery.rounded.specification.words(),
        percent(rest.minimum.0, before.minimum.0),
        rest.minimum.1,
        percent(rest.at_10_hz_n_per_m, before.at_10_hz_n_per_m),
        percent(rest.at_max_speed_n_per_m, before.at_max_speed_n_per_m),
    );
    json!({
        "sentence": sentence,
        "factor": factor,
        "asked": match written.asked {
            Tightening::Auto => json!("auto"),
            Tightening::By(factor) => json!(factor),
        },
        "designs": [
            variant_topic("as written", &written.design, before),
            variant_topic("tightened", design, rest),
        ],
        "minimum_stiffness_gain": rest.minimum.0 / before.minimum.0,
        "stiffness_at_10_hz_gain": rest.at_10_hz_n_per_m / before.at_10_hz_n_per_m,
        "stiffness_at_max_speed_gain": rest.at_max_speed_n_per_m / before.at_max_speed_n_per_m,
    })
}
