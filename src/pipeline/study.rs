//! A design with the options of its command: a tightened specification, the other route, controllers of lower order,
//! the limit of the stiffness.

use super::PipelineError;
use super::comparison::{Prediction, predict};
use super::design::{Design, design, design_in_words};
use super::emulation::PADE_ORDER;
use super::loop_curves::LoopCurves;
use super::order_curve::{OrderCurve, lowest_order};
use super::progress::{Event, Listener};
use super::run::{by_arithmetic, predict_delivered, predict_unpolished};
use super::settings::DesignSettings;
use super::tightening::{Tightening, tighten_specification, tighter};
use crate::augment::plane::Route;
use crate::augment::weights::Weights;
use crate::controller::stiffness_limit::StiffnessLimit;
use crate::spindle::Machine;

/// What is asked beside the design.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Questions {
    /// A tightened specification, compared with the one as written.
    pub tightening: Option<Tightening>,
    /// The design by the other route.
    pub other_route: bool,
    /// The lowest order that keeps stiffness and goals; it is delivered.
    pub lowest_order: bool,
    /// The limit of the tool stiffness over all linear controllers.
    pub limit: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct Study {
    pub design: Design,
    /// The specification that it was asked to meet.
    pub weights: Weights,
    pub orders: Option<OrderCurve>,
    /// The loop at rest and at top speed.
    pub delivered: [Prediction; 2],
    /// The loop at rest with the coefficients of each arithmetic.
    pub arithmetic: Vec<Prediction>,
    /// The design as written, where this one is tightened.
    pub written: Option<AsWritten>,
    /// The design by the other route.
    pub other_route: Option<OtherRoute>,
    /// The loop at rest and at top speed before the polish.
    pub unpolished: Option<[Prediction; 2]>,
    pub limit: Option<StiffnessLimit>,
    pub curves: LoopCurves,
}

/// The design with the specification as written beside a tightened one.
#[derive(Clone, Debug)]
pub(crate) struct AsWritten {
    pub design: Design,
    /// Its loop at rest.
    pub rest: Prediction,
    pub asked: Tightening,
    /// Factor by which the other design is tightened.
    pub factor: f64,
}

/// The design by the other route.
#[derive(Clone, Debug)]
pub(crate) struct OtherRoute {
    pub route: Route,
    /// Design and its loop at rest, or why it does not survive sampling.
    pub found: Result<Box<(Design, Prediction)>, String>,
}

/// Designs, and answers what is asked beside the design.
pub(crate) fn study(
    machine: &Machine,
    written: &Weights,
    settings: &DesignSettings,
    questions: Questions,
    progress: &mut Listener,
) -> Result<Study, PipelineError> {
    let mut settings = settings.clone();
    if let Some(earlier) = settings.earlier.as_mut().filter(|_| questions.other_route) {
        // Routes differ in their syntheses.
        earlier.suffices = false;
    }
    let settings = &settings;
    let (mut found, factor) = match questions.tightening {
        None => (design_in_words(machine, written, settings, progress)?, 1.0),
        Some(asked) => tighten_specification(machine, written, settings, asked, progress)?,
    };
    let weights = tighter(written, factor);
    let orders = if questions.lowest_order {
        Some(lowest_order(machine, &weights, settings, &mut found, progress)?)
    } else {
        None
    };
    progress(Event::Begins("predictions"));
    let delivered = predict_delivered(machine, &found)?;
    let as_written = match questions.tightening {
        Some(asked) => {
            let design = design_in_words(machine, written, settings, progress)?;
            let rest = predict(machine, &design.delivery.controller, 0.0)?;
            Some(AsWritten { design, rest, asked, factor })
        }
        None => None,
    };
    let other_route = if questions.other_route {
        progress(Event::Begins("other route"));
        let other = other_route(machine, &weights, settings)?;
        progress(Event::Found("both routes designed"));
        Some(other)
    } else {
        None
    };
    let limit = if questions.limit {
        progress(Event::Begins("limit of the stiffness"));
        Some(found.stiffness_limit(machine)?)
    } else {
        None
    };
    progress(Event::Begins("predictions"));
    let unpolished = predict_unpolished(machine, &found)?;
    let (arithmetic, curves) = rayon::join(
        || by_arithmetic(machine, &found),
        || LoopCurves::of(machine, &found.delivery.controller, &delivered[0], &weights.mode_uncertainty),
    );
    let (arithmetic, curves) = (arithmetic?, curves?);
    Ok(Study {
        design: found,
        weights,
        orders,
        delivered,
        arithmetic,
        written: as_written,
        other_route,
        unpolished,
        limit,
        curves,
    })
}

/// The design by the route that the settings do not take.
fn other_route(machine: &Machine, weights: &Weights, settings: &DesignSettings) -> Result<OtherRoute, PipelineError> {
    let route = match settings.route {
        Route::Direct => Route::Emulation { pade_order: PADE_ORDER },
        Route::Emulation { .. } => Route::Direct,
    };
    let settings = DesignSettings { route, ..settings.clone() };
    let found = match design(machine, weights, &settings, &mut |_| {}) {
        Ok(other) => {
            let rest = predict(machine, &other.delivery.controller, 0.0)?;
            Ok(Box::new((other, rest)))
        }
        // That it does not survive sampling is the answer of the comparison.
        Err(error @ PipelineError::Emulated { .. }) => Err(error.to_string()),
        Err(error) => return Err(error),
    };
    Ok(OtherRoute { route, found })
}
