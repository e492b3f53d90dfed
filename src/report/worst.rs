//! Worst cases as topic of the summary and in words: both bounds per speed, and the least over the speeds.

use super::comparison_figures::NamedWorst;
use crate::controller::verification::growth_words;
use crate::pipeline::comparison::LOW_HZ;
use crate::pipeline::worst::WorstPrediction;
use crate::predict::worst_case::{Extreme, WorstCurve};
use serde_json::{Value, json};

/// `worst_case.<controller>`: a record per speed, and one over all of them.
pub(crate) fn worst_records(worst: &[WorstPrediction]) -> Vec<Value> {
    worst.iter().map(worst_at_speed).chain([worst_over_speed(worst)]).collect()
}

/// What no rotor within the uncertainty falls below at any of the speeds.
fn worst_over_speed(worst: &[WorstPrediction]) -> Value {
    json!({
        "covers": "the speeds computed, gyroscopic moments exact",
        "speeds_rpm": worst.iter().map(|w| w.speed_rpm).collect::<Vec<_>>(),
        "least_stiffness": match least_over_speed(worst) {
            Ok(least) => json!({
                "not_below_n_per_m": least.n_per_m,
                "frequency_hz": least.frequency_hz,
                "speed_rpm": least.speed_rpm,
            }),
            Err(reason) => json!({ "not_below_n_per_m": null, "reason": reason }),
        },
    })
}

/// The smallest stiffness over speeds and uncertainty, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Least {
    /// Not below this, N/m.
    pub n_per_m: f64,
    /// At, Hz.
    pub frequency_hz: f64,
    pub speed_rpm: f64,
}

/// The smallest stiffness over every speed computed and every rotor within the uncertainty.
pub(crate) fn least_over_speed(worst: &[WorstPrediction]) -> Result<Least, String> {
    if let Some(bad) = worst.iter().find(|w| !w.is_stable()) {
        return Err(unstable_within(bad));
    }
    let all = worst.iter().filter_map(|w| {
        let (n_per_m, frequency_hz) = w.least_stiffness()?;
        Some(Least { n_per_m, frequency_hz, speed_rpm: w.speed_rpm })
    });
    all.min_by(|a, b| a.n_per_m.total_cmp(&b.n_per_m)).ok_or_else(|| "no speed was computed".to_owned())
}

fn unstable_within(worst: &WorstPrediction) -> String {
    format!("unstable within the uncertainty: a loop {}", growth_words(worst.corner_growth_rate_per_s, worst.speed_rpm))
}

fn worst_at_speed(worst: &WorstPrediction) -> Value {
    // Stiffness is the inverse of compliance: its lower bound is the inverse of the upper one.
    let bounds = |e: &Extreme| {
        json!({
            "nominal_n_per_m": 1.0 / e.nominal,
            "not_below_n_per_m": 1.0 / e.upper,
            "attained_n_per_m": 1.0 / e.lower,
        })
    };
    let least = |(hz, e): (f64, &Extreme)| {
        json!({
            "frequency_hz": hz,
            "not_below_n_per_m": 1.0 / e.upper,
            "attained_n_per_m": 1.0 / e.lower,
            "attained_with_frequency_factors": e.factors,
        })
    };
    let stiffness = |c: &WorstCurve| {
        json!({
            "minimum": c.peak().map(least),
            "at_10_hz": c.near(LOW_HZ).map(bounds),
            "at_max_speed": c.near(worst.top_speed_hz).map(bounds),
        })
    };
    let peak = |(hz, e): (f64, &Extreme)| {
        let db = |ratio: f64| 20.0 * ratio.log10();
        json!({ "frequency_hz": hz, "not_above_db": db(e.upper), "attained_db": db(e.lower) })
    };
    let [x, y] = worst.worst.compliance.each_ref().map(stiffness);
    let sensitivity = worst.worst.sensitivity.each_ref().map(|c| c.peak().map(peak));
    json!({
        "speed_rpm": worst.speed_rpm,
        "covers": "this speed",
        "reason": (!worst.is_stable()).then(|| unstable_within(worst)),
        "natural_frequency_uncertainty": worst.uncertainty.relative,
        "stable_at_corners": worst.is_stable(),
        "corner_growth_rate_per_s": worst.corner_growth_rate_per_s,
        "stiffness": { "x": x, "y": y },
        "sensitivity": {
            "front_x": sensitivity[0],
            "front_y": sensitivity[1],
            "rear_x": sensitivity[2],
            "rear_y": sensitivity[3],
        },
    })
}

/// What no rotor within the uncertainty falls below, for which speeds.
pub(super) fn worst_sentence(worst: &[NamedWorst]) -> Option<String> {
    let each: Vec<String> = worst
        .iter()
        .map(|(_, name, cases)| {
            let (first, last) = (cases.first()?, cases.last()?);
            let range = match cases.len() {
                1 => format!("{:.0} rpm", first.speed_rpm),
                n => format!("{n} speeds from {:.0} to {:.0} rpm", first.speed_rpm, last.speed_rpm),
            };
            Some(match least_over_speed(cases) {
                Ok(least) => format!("{name} {:.2} at {range}", 1e-6 * least.n_per_m),
                Err(reason) => format!("{name} none at {range} ({reason})"),
            })
        })
        .collect::<Option<_>>()?;
    (!each.is_empty()).then(|| {
        format!(
            "No rotor within the uncertainty of the natural frequencies, gyroscopic moments exact, has less tool \
             stiffness than (N/µm): {}.",
            each.join(", ")
        )
    })
}
