//! Designs beside others as topics of the summary: arithmetics, routes, a tightened specification, the limit of the
//! stiffness.

use super::prediction_summary::{SensitivitySummary, StiffnessSummary};
use super::summary::finite;
use crate::augment::plane::Route;
use crate::controller::stiffness_limit::StiffnessLimit;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::design::Design;
use crate::pipeline::study::{AsWritten, OtherRoute};
use crate::pipeline::tightening::Tightening;
use serde::{Serialize, Serializer};

pub(crate) fn route_word(route: Route) -> &'static str {
    match route {
        Route::Direct => "direct",
        Route::Emulation { .. } => "emulation",
    }
}

/// `design.stiffness_limit`: the limit of the smallest stiffness over all linear controllers, and how much of it the
/// delivered one reaches.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LimitSummary {
    minimum_n_per_m: Option<f64>,
    with_half_the_taps_n_per_m: Option<f64>,
    taps: usize,
    lines: usize,
    share_reached: Option<f64>,
    model: &'static str,
}

impl LimitSummary {
    /// With the stiffness that the delivered controller reaches, N/m.
    pub(crate) fn of(limit: &StiffnessLimit, reached_n_per_m: f64) -> Self {
        Self {
            minimum_n_per_m: finite(limit.stiffness_n_per_m),
            with_half_the_taps_n_per_m: finite(limit.with_half_the_taps_n_per_m),
            taps: limit.taps,
            lines: limit.lines,
            share_reached: finite(reached_n_per_m / limit.stiffness_n_per_m),
            model: "rotor at rest, whole plant with hold and delay at lines of frequency, zone A, limits of gain and \
                    noise current; over the stabilising sampled linear controllers whose Youla parameter has these \
                    taps: more taps can only raise it",
        }
    }
}

/// µ and tool stiffness at rest with the coefficients of one arithmetic.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ArithmeticSummary {
    coefficients: String,
    mu_peak: Option<f64>,
    mu_table_as_written: Option<f64>,
    minimum_stiffness_n_per_m: Option<f64>,
    minimum_stiffness_frequency_hz: Option<f64>,
    stiffness_at_10_hz_n_per_m: Option<f64>,
}

impl ArithmeticSummary {
    /// Every arithmetic; `predictions` in the order of the design's list.
    pub(crate) fn all(design: &Design, predictions: &[Prediction]) -> Vec<Self> {
        let both = design.delivery.arithmetic.iter().zip(predictions);
        both.map(|(a, p)| Self {
            coefficients: a.name.to_owned(),
            mu_peak: finite(a.covered),
            mu_table_as_written: finite(a.specification),
            minimum_stiffness_n_per_m: finite(p.minimum.0),
            minimum_stiffness_frequency_hz: finite(p.minimum.1),
            stiffness_at_10_hz_n_per_m: finite(p.at_10_hz_n_per_m),
        })
        .collect()
    }
}

/// A design beside others: what it was asked, µ, stiffness and sensitivity at rest; or why there is none.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum VariantSummary {
    /// A design.
    Found(Box<VariantFigures>),
    Failed {
        design: String,
        stable: bool,
        failure: String,
    },
}

/// Figures of a design beside others.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct VariantFigures {
    design: String,
    mu_synthesised: Option<f64>,
    mu_sampled: Option<f64>,
    mu_peak_discrete: Option<f64>,
    mu_table_as_written: Option<f64>,
    controller_order: usize,
    complementary_sensitivity_limit: Option<f64>,
    minimum_n_per_m: Option<f64>,
    minimum_frequency_hz: Option<f64>,
    at_10_hz_n_per_m: Option<f64>,
    at_max_speed_n_per_m: Option<f64>,
    static_tool_n_per_m: Option<f64>,
    front_db: Option<f64>,
    rear_db: Option<f64>,
    zone: Option<String>,
    stable: bool,
}

impl VariantSummary {
    pub(crate) fn of(name: &str, design: &Design, rest: &Prediction) -> Self {
        let (stiffness, sensitivity) = (StiffnessSummary::of(rest), SensitivitySummary::of(rest));
        let rounded = &design.delivery.rounded;
        let dk = design.dk.as_ref();
        let synthesised = dk.map(|dk| dk.full.synthesis);
        let emulated = dk.and_then(|dk| dk.emulated);
        Self::Found(Box::new(VariantFigures {
            design: name.to_owned(),
            mu_synthesised: emulated.map(|e| e.mu_continuous).or(synthesised).and_then(finite),
            mu_sampled: synthesised.and_then(finite),
            mu_peak_discrete: finite(rounded.covered.upper),
            mu_table_as_written: finite(rounded.specification.upper),
            controller_order: 2 * rounded.order,
            complementary_sensitivity_limit: design.problems.sensitivity_limit.and_then(finite),
            minimum_n_per_m: stiffness.minimum_n_per_m,
            minimum_frequency_hz: stiffness.minimum_frequency_hz,
            at_10_hz_n_per_m: stiffness.at_10_hz_n_per_m,
            at_max_speed_n_per_m: stiffness.at_max_speed_n_per_m,
            static_tool_n_per_m: finite(design.delivery.static_stiffness_n_per_m[0]),
            front_db: sensitivity.front_db,
            rear_db: sensitivity.rear_db,
            zone: sensitivity.zone,
            stable: design.is_stable(),
        }))
    }

    /// Designs by both routes, the direct one first: `own` with its loop at rest, and the other.
    pub(crate) fn of_routes(own: (Route, &Design, &Prediction), other: &OtherRoute) -> [Self; 2] {
        let (route, design, rest) = own;
        let own = Self::of(route_word(route), design, rest);
        let name = route_word(other.route);
        let found = match &other.found {
            Ok(found) => Self::of(name, &found.0, &found.1),
            Err(failure) => Self::failed_variant(name, failure.clone()),
        };
        match route {
            Route::Direct => [own, found],
            Route::Emulation { .. } => [found, own],
        }
    }

    /// A design that does not survive sampling.
    fn failed_variant(name: &str, failure: String) -> Self {
        Self::Failed { design: name.to_owned(), stable: false, failure }
    }
}

impl Serialize for Tightening {
    /// The word `auto` or the factor.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::By(factor) => serializer.serialize_f64(*factor),
        }
    }
}

/// `tightening`: the design with a tightened specification beside the one as written.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct TighteningSummary {
    sentence: String,
    factor: Option<f64>,
    asked: Tightening,
    designs: [VariantSummary; 2],
    minimum_stiffness_gain: Option<f64>,
    stiffness_at_10_hz_gain: Option<f64>,
    stiffness_at_max_speed_gain: Option<f64>,
}

impl TighteningSummary {
    /// `design` is the tightened one, `rest` its loop at rest.
    pub(crate) fn of(written: &AsWritten, design: &Design, rest: &Prediction) -> Self {
        let (before, factor) = (&written.rest, written.factor);
        let gain = |now: f64, then: f64| finite(now / then);
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
        Self {
            sentence,
            factor: finite(factor),
            asked: written.asked,
            designs: [
                VariantSummary::of("as written", &written.design, before),
                VariantSummary::of("tightened", design, rest),
            ],
            minimum_stiffness_gain: gain(rest.minimum.0, before.minimum.0),
            stiffness_at_10_hz_gain: gain(rest.at_10_hz_n_per_m, before.at_10_hz_n_per_m),
            stiffness_at_max_speed_gain: gain(rest.at_max_speed_n_per_m, before.at_max_speed_n_per_m),
        }
    }
}
