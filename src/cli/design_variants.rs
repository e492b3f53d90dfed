//! What else `muspin design` can be asked: tighten the tool's specification, or design by both routes.

use super::Failure;
use super::design_progress::run_design_with;
use super::progress::Progress;
use crate::augment::plane::Route;
use crate::augment::weights::Weights;
use crate::pipeline::PipelineError;
use crate::pipeline::comparison::{Prediction, predict};
use crate::pipeline::design::Design;
use crate::pipeline::settings::DesignSettings;
use crate::pipeline::tightening::largest_tightening;
use crate::report::variant_summary::{
    AskedTightening, TighteningSummary, VariantSummary, route_word,
};
use crate::spindle::Machine;
use std::str::FromStr;

/// Order of the Padé approximant of an emulated design: its phase is exact to 0.1° up to half the sample rate at 1.5
/// samples.
const PADE_ORDER: usize = 4;

/// `--route`.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub enum RouteArgument {
    /// Synthesis on the sampled plant in the w plane
    #[default]
    Direct,
    /// Continuous synthesis with a Padé delay, then Tustin's rule
    Emulation,
}

impl From<RouteArgument> for Route {
    fn from(argument: RouteArgument) -> Self {
        match argument {
            RouteArgument::Direct => Self::Direct,
            RouteArgument::Emulation => Self::Emulation {
                pade_order: PADE_ORDER,
            },
        }
    }
}

/// `--tighten`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tighten {
    /// As far as μ ≤ 1 allows.
    Auto,
    /// By this factor.
    By(f64),
}

impl FromStr for Tighten {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        match text.parse::<f64>() {
            Ok(factor) if factor.is_finite() && factor > 0.0 => Ok(Self::By(factor)),
            _ => Err("must be `auto` or a positive factor such as 1.5".to_owned()),
        }
    }
}

/// The design with the tool's displacement limits divided by the factor asked for, and that factor. `auto` starts from
/// the largest factor that the problem itself allows and steps back until the controller as it runs, reduced and
/// rounded and stable itself, has µ ≤ 1 as well.
pub(super) fn tightened(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    tighten: Tighten,
    progress: &Progress,
) -> Result<(Design, f64), Failure> {
    let by = |factor: f64| {
        let tighter = Weights {
            tool_tightening: weights.tool_tightening * factor,
            ..weights.clone()
        };
        run_design_with(machine, &tighter, settings, progress)
    };
    let mut factor = match tighten {
        Tighten::By(factor) => return Ok((by(factor)?, factor)),
        Tighten::Auto => {
            progress.stage("largest tightening");
            largest_tightening(machine, weights, settings)?
        }
    };
    let mut found = by(factor)?;
    for _ in 0..STEPS_BACK {
        let mu = found.delivery.rounded.specification.upper;
        if mu <= 1.0 {
            break;
        }
        progress.line(format!("tightening by {factor:.2}: µ {mu:.3}"));
        factor *= (STEP_BACK / mu).min(STEP_BACK);
        found = by(factor)?;
    }
    Ok((found, factor))
}

/// What the tool's specification is loosened by beyond the excess of µ: it is not the only one that µ weighs.
const STEP_BACK: f64 = 0.95;
/// Designs tried with looser specifications; each step is at least 5 %.
const STEPS_BACK: usize = 5;

/// The design without tightening beside the tightened one.
pub(super) fn tightening_beside(
    machine: &Machine,
    written: &Weights,
    settings: &DesignSettings,
    (tightened, rest): (&Design, &Prediction),
    (factor, asked): (f64, Tighten),
    progress: &Progress,
) -> Result<TighteningSummary, Failure> {
    let before = run_design_with(machine, written, settings, progress)?;
    let before_rest = predict(machine, &before.delivery.controller, 0.0)?;
    let asked = match asked {
        Tighten::Auto => AskedTightening::Auto,
        Tighten::By(factor) => AskedTightening::By(factor),
    };
    let (written, tightened) = ((&before, &before_rest), (tightened, rest));
    Ok(TighteningSummary::of(written, tightened, factor, asked))
}

/// Designs by both routes side by side, each judged on the sampled loop.
pub(super) fn both_routes(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    own: (&Design, &Prediction),
    progress: &Progress,
) -> Result<Vec<VariantSummary>, Failure> {
    let mut rows: Vec<VariantSummary> = vec![];
    for argument in [RouteArgument::Direct, RouteArgument::Emulation] {
        let route = Route::from(argument);
        let name = route_word(route);
        if name == route_word(settings.route) {
            rows.push(VariantSummary::of(name, own.0, own.1));
            continue;
        }
        let settings = DesignSettings {
            route,
            ..settings.clone()
        };
        rows.push(
            match crate::pipeline::design::design(machine, weights, &settings, &mut |_| {}) {
                Ok(other) => {
                    let rest = predict(machine, &other.delivery.controller, 0.0)?;
                    VariantSummary::of(name, &other, &rest)
                }
                // That it does not survive sampling is the answer of the comparison.
                Err(error @ PipelineError::Emulated { .. }) => {
                    VariantSummary::failed(name, error.to_string())
                }
                Err(error) => return Err(error.into()),
            },
        );
    }
    progress.line("both routes designed");
    Ok(rows)
}
