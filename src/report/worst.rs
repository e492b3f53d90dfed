//! Worst cases as topic of the summary and in words: both bounds per speed, and the least over the speeds.

use super::comparison_figures::NamedWorst;
use super::summary::{finite, finite_all};
use crate::controller::verification::growth_words;
use crate::pipeline::comparison::LOW_HZ;
use crate::pipeline::worst::WorstPrediction;
use crate::predict::worst_case::WorstCurve;
use serde::Serialize;

/// A record of `worst_case.<controller>`.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum WorstSummary {
    Speed(Box<WorstAtSpeed>),
    /// Over every speed.
    Over(WorstOverSpeed),
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct WorstAtSpeed {
    speed_rpm: Option<f64>,
    covers: &'static str,
    reason: Option<String>,
    natural_frequency_uncertainty: Vec<Option<f64>>,
    stable_at_corners: bool,
    corner_growth_rate_per_s: Option<f64>,
    stiffness: WorstStiffness,
    sensitivity: WorstSensitivity,
}

#[derive(Clone, Debug, Serialize)]
struct WorstStiffness {
    x: AxisStiffness,
    y: AxisStiffness,
}

#[derive(Clone, Debug, Serialize)]
struct AxisStiffness {
    minimum: Option<LeastOfCurve>,
    at_10_hz: Option<StiffnessBounds>,
    at_max_speed: Option<StiffnessBounds>,
}

#[derive(Clone, Debug, Serialize)]
struct LeastOfCurve {
    frequency_hz: Option<f64>,
    not_below_n_per_m: Option<f64>,
    attained_n_per_m: Option<f64>,
    attained_with_frequency_factors: Vec<Option<f64>>,
}

#[derive(Clone, Debug, Serialize)]
struct StiffnessBounds {
    nominal_n_per_m: Option<f64>,
    not_below_n_per_m: Option<f64>,
    attained_n_per_m: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
struct WorstSensitivity {
    front_x: Option<SensitivityBounds>,
    front_y: Option<SensitivityBounds>,
    rear_x: Option<SensitivityBounds>,
    rear_y: Option<SensitivityBounds>,
}

#[derive(Clone, Debug, Serialize)]
struct SensitivityBounds {
    frequency_hz: Option<f64>,
    not_above_db: Option<f64>,
    attained_db: Option<f64>,
}

/// What no rotor within the uncertainty falls below at any of the speeds.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct WorstOverSpeed {
    covers: &'static str,
    speeds_rpm: Vec<Option<f64>>,
    least_stiffness: LeastSummary,
}

#[derive(Clone, Debug, Default, Serialize)]
struct LeastSummary {
    not_below_n_per_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency_hz: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    speed_rpm: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

/// Worst cases of one controller: a record per speed, and one over all of them.
pub(crate) fn worst_records(worst: &[WorstPrediction]) -> Vec<WorstSummary> {
    let each = worst.iter().map(WorstAtSpeed::from);
    let each = each.map(|w| WorstSummary::Speed(Box::new(w)));
    let over = WorstSummary::Over(WorstOverSpeed::of(worst));
    each.chain([over]).collect()
}

impl WorstOverSpeed {
    fn of(worst: &[WorstPrediction]) -> Self {
        let speeds: Vec<f64> = worst.iter().map(|w| w.speed_rpm).collect();
        Self {
            covers: "the speeds computed, gyroscopic moments exact",
            speeds_rpm: finite_all(&speeds),
            least_stiffness: match least_over_speed(worst) {
                Ok(least) => LeastSummary {
                    not_below_n_per_m: finite(least.n_per_m),
                    frequency_hz: Some(finite(least.frequency_hz)),
                    speed_rpm: Some(finite(least.speed_rpm)),
                    reason: None,
                },
                Err(reason) => LeastSummary { reason: Some(reason), ..LeastSummary::default() },
            },
        }
    }
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

impl From<&WorstPrediction> for WorstAtSpeed {
    fn from(worst: &WorstPrediction) -> Self {
        let axes = &worst.worst.compliance;
        let [x, y] = axes.each_ref().map(|c| AxisStiffness {
            minimum: LeastOfCurve::of(c),
            at_10_hz: StiffnessBounds::near(c, LOW_HZ),
            at_max_speed: StiffnessBounds::near(c, worst.top_speed_hz),
        });
        let axes = worst.worst.sensitivity.each_ref();
        let [front_x, front_y, rear_x, rear_y] = axes.map(SensitivityBounds::of);
        Self {
            speed_rpm: finite(worst.speed_rpm),
            covers: "this speed",
            reason: (!worst.is_stable()).then(|| unstable_within(worst)),
            natural_frequency_uncertainty: finite_all(&worst.uncertainty.relative),
            stable_at_corners: worst.is_stable(),
            corner_growth_rate_per_s: finite(worst.corner_growth_rate_per_s),
            stiffness: WorstStiffness { x, y },
            sensitivity: WorstSensitivity { front_x, front_y, rear_x, rear_y },
        }
    }
}

// Stiffness is the inverse of compliance: its lower bound is the inverse of the upper one.
impl StiffnessBounds {
    fn near(curve: &WorstCurve, hz: f64) -> Option<Self> {
        let e = curve.near(hz)?;
        Some(Self {
            nominal_n_per_m: finite(1.0 / e.nominal),
            not_below_n_per_m: finite(1.0 / e.upper),
            attained_n_per_m: finite(1.0 / e.lower),
        })
    }
}

impl LeastOfCurve {
    fn of(curve: &WorstCurve) -> Option<Self> {
        let (hz, e) = curve.peak()?;
        Some(Self {
            frequency_hz: finite(hz),
            not_below_n_per_m: finite(1.0 / e.upper),
            attained_n_per_m: finite(1.0 / e.lower),
            attained_with_frequency_factors: finite_all(&e.factors),
        })
    }
}

impl SensitivityBounds {
    fn of(curve: &WorstCurve) -> Option<Self> {
        let (hz, e) = curve.peak()?;
        Some(Self {
            frequency_hz: finite(hz),
            not_above_db: finite(20.0 * e.upper.log10()),
            attained_db: finite(20.0 * e.lower.log10()),
        })
    }
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
