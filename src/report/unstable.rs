//! A design whose loop is unstable at some speed: why, as the topic `instability` of the summary. Figures of a stable
//! loop are left out of its report.

use super::summary::finite;
use super::whole::Report;
use crate::pid::surviving::SurvivingLaw;
use crate::pipeline::design::Design;
use crate::pipeline::instability::{GrowingMode, Instability};
use serde::Serialize;

#[derive(Clone, Debug, Serialize)]
pub(crate) struct InstabilitySummary {
    sentence: String,
    growth_rate_per_s: Option<f64>,
    speed_rpm: Option<f64>,
    frequency_hz: Option<f64>,
    proven_to_rpm: Option<f64>,
    mode: ModeSummary,
    search: Option<SearchSummary>,
}

/// The motion of the free rotor behind what grows: `flexible` with its split, `nutation` or `rigid body`.
#[derive(Clone, Debug, Default, Serialize)]
struct ModeSummary {
    kind: &'static str,
    number: Option<usize>,
    at_rest_hz: Option<f64>,
    backward_at_speed_hz: Option<f64>,
    forward_at_speed_hz: Option<f64>,
    shift_covered: Option<f64>,
}

/// What was searched for a stable law, and how far that came.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SearchSummary {
    sentence: String,
    evaluations: usize,
    growth_rate_per_s: Option<f64>,
    speed_rpm: Option<f64>,
    frequency_hz: Option<f64>,
}

/// States in verdict, sentences and summary that a design is unstable; true where it is.
pub(crate) fn add_instability(report: &mut Report, design: &Design) -> bool {
    let (Some(found), Some(words)) = (&design.instability, design.instability_words()) else {
        return false;
    };
    report.verdict(false, &found.first_words());
    report.summary.set("plain_words", &words);
    let polish = design.polish.as_ref();
    let search = polish.and_then(|polish| polish.surviving.as_ref()).map(SearchSummary::from);
    let own = InstabilitySummary::of(found, &words, design.delivery.speed_proof.proven_to_rpm());
    report.summary.set("instability", InstabilitySummary { search, ..own });
    true
}

impl From<&SurvivingLaw> for SearchSummary {
    fn from(search: &SurvivingLaw) -> Self {
        Self {
            sentence: search.words(),
            evaluations: search.evaluations,
            growth_rate_per_s: finite(search.worst.rate_per_s),
            speed_rpm: finite(search.worst.speed_rpm),
            frequency_hz: finite(search.worst.frequency_hz),
        }
    }
}

impl InstabilitySummary {
    pub(crate) fn of(found: &Instability, words: &str, proven_to_rpm: f64) -> Self {
        Self {
            sentence: words.to_owned(),
            growth_rate_per_s: finite(found.growth_rate_per_s),
            speed_rpm: finite(found.speed_rpm),
            frequency_hz: finite(found.frequency_hz),
            proven_to_rpm: finite(proven_to_rpm),
            mode: ModeSummary::from(found.mode),
            search: None,
        }
    }
}

impl From<GrowingMode> for ModeSummary {
    fn from(mode: GrowingMode) -> Self {
        match mode {
            GrowingMode::Flexible(own) => {
                let [backward_at_speed_hz, forward_at_speed_hz] = own.at_speed_hz.map(finite);
                Self {
                    kind: "flexible",
                    number: Some(own.number),
                    at_rest_hz: finite(own.at_rest_hz),
                    backward_at_speed_hz,
                    forward_at_speed_hz,
                    shift_covered: finite(own.covered),
                }
            }
            GrowingMode::Nutation { free_hz } => {
                Self { kind: "nutation", forward_at_speed_hz: finite(free_hz), ..Self::default() }
            }
            GrowingMode::RigidBody => Self { kind: "rigid body", ..Self::default() },
        }
    }
}
