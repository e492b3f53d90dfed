//! Worst cases as JSON and in words: both bounds per speed, and the least over the speeds.

use super::comparison_figures::NamedWorst;
use super::summary::{number, numbers};
use crate::pipeline::comparison::LOW_HZ;
use crate::pipeline::worst::WorstPrediction;
use crate::predict::worst_case::WorstCurve;
use serde_json::{Value, json};

/// Worst cases of one controller: a record per speed, and one over all of them.
pub fn worst_json(worst: &[WorstPrediction]) -> Value {
    let each = worst.iter().map(one_worst_json);
    Value::Array(each.chain([over_speed_json(worst)]).collect())
}

/// What no rotor within the uncertainty falls below at any of the speeds.
fn over_speed_json(worst: &[WorstPrediction]) -> Value {
    let speeds: Vec<f64> = worst.iter().map(|w| w.speed_rpm).collect();
    let least = least_over_speed(worst);
    json!({
        "covers": "the speeds computed, gyroscopic moments exact",
        "speeds_rpm": numbers(&speeds),
        "least_stiffness": match least {
            Ok(Least { n_per_m, frequency_hz, speed_rpm }) => json!({
                "not_below_n_per_m": number(n_per_m),
                "frequency_hz": number(frequency_hz),
                "speed_rpm": number(speed_rpm),
            }),
            Err(reason) => json!({ "not_below_n_per_m": null, "reason": reason }),
        },
    })
}

/// The smallest stiffness over speeds and uncertainty, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Least {
    /// Not below this, N/m.
    pub n_per_m: f64,
    /// At, Hz.
    pub frequency_hz: f64,
    /// At, rpm.
    pub speed_rpm: f64,
}

/// The smallest stiffness over every speed computed and every rotor within the uncertainty.
///
/// # Errors
/// The reason in words when a loop of the set is unstable.
pub fn least_over_speed(worst: &[WorstPrediction]) -> Result<Least, String> {
    if let Some(bad) = worst.iter().find(|w| !w.is_stable()) {
        return Err(unstable_within(bad));
    }
    let all = worst.iter().filter_map(|w| {
        let (n_per_m, frequency_hz) = w.least_stiffness()?;
        Some(Least {
            n_per_m,
            frequency_hz,
            speed_rpm: w.speed_rpm,
        })
    });
    all.min_by(|a, b| a.n_per_m.total_cmp(&b.n_per_m))
        .ok_or_else(|| "no speed was computed".to_owned())
}

fn unstable_within(worst: &WorstPrediction) -> String {
    format!(
        "unstable within the uncertainty: a loop grows by {:.1} 1/s at {:.0} rpm",
        worst.corner_growth_rate_per_s, worst.speed_rpm
    )
}

fn one_worst_json(worst: &WorstPrediction) -> Value {
    // Stiffness is the inverse of compliance: its lower bound is the inverse of the upper one.
    let stiffness = |curve: &WorstCurve| {
        let low = |hz: f64| {
            curve.near(hz).map_or(Value::Null, |e| {
                json!({
                    "nominal_n_per_m": number(1.0 / e.nominal),
                    "not_below_n_per_m": number(1.0 / e.upper),
                    "attained_n_per_m": number(1.0 / e.lower),
                })
            })
        };
        let minimum = curve.peak().map_or(Value::Null, |(hz, e)| {
            json!({
                "frequency_hz": number(hz),
                "not_below_n_per_m": number(1.0 / e.upper),
                "attained_n_per_m": number(1.0 / e.lower),
                "attained_with_frequency_factors": numbers(&e.factors),
            })
        });
        json!({ "minimum": minimum, "at_10_hz": low(LOW_HZ), "at_max_speed": low(worst.top_speed_hz) })
    };
    let sensitivity = |curve: &WorstCurve| {
        curve.peak().map_or(Value::Null, |(hz, e)| {
            json!({
                "frequency_hz": number(hz),
                "not_above_db": number(20.0 * e.upper.log10()),
                "attained_db": number(20.0 * e.lower.log10()),
            })
        })
    };
    let [x, y] = &worst.worst.compliance;
    let [fx, fy, rx, ry] = &worst.worst.sensitivity;
    json!({
        "speed_rpm": number(worst.speed_rpm),
        "covers": "this speed",
        "reason": (!worst.is_stable()).then(|| unstable_within(worst)),
        "natural_frequency_uncertainty": numbers(&worst.uncertainty.relative),
        "stable_at_corners": worst.is_stable(),
        "corner_growth_rate_per_s": number(worst.corner_growth_rate_per_s),
        "stiffness": { "x": stiffness(x), "y": stiffness(y) },
        "sensitivity": {
            "front_x": sensitivity(fx),
            "front_y": sensitivity(fy),
            "rear_x": sensitivity(rx),
            "rear_y": sensitivity(ry),
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
                n => format!(
                    "{n} speeds from {:.0} to {:.0} rpm",
                    first.speed_rpm, last.speed_rpm
                ),
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
