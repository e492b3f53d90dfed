//! Tool stiffness against the order of the controller: the polished controller is truncated and polished again, order
//! by order, each with every certificate.

use super::PipelineError;
use super::delivery::{Delivery, plane_of_law, scaled_plane};
use super::design::Design;
use super::judged::Judged;
use super::polish_job::{PolishJob, ZONE_A, limits};
use super::progress::{Event, Listener};
use super::reduction::loop_balancing;
use super::settings::DesignSettings;
use super::specification_scale::specification_scale;
use crate::augment::assembly::unscale_controller;
use crate::augment::weights::Weights;
use crate::controller::ControlLaw;
use crate::lti::sample::tustin;
use crate::lti::{Discrete, StateSpace};
use crate::spindle::Machine;

/// Part of the smallest tool stiffness that a controller of lower order has to keep.
const KEPT: f64 = 0.95;
/// The curve ends where less than this part of the stiffness is left, or at the order of a PD controller with its
/// filters.
const SHOWN: f64 = 0.7;
const LEAST_ORDER: usize = 4;
/// States of one plane that one step takes away: a pair of poles.
const STEP: usize = 2;

#[derive(Clone, Debug)]
pub(crate) struct OrderPoint {
    /// Order over both planes.
    pub order: usize,
    /// Its figures; none when the cut controller could not be polished.
    pub judged: Option<Judged>,
    /// Why it could not be polished.
    pub failure: Option<String>,
    /// Whether it keeps the stiffness and meets every goal that the controller of full order meets.
    pub keeps: bool,
}

/// Tool stiffness against the order of the controller.
#[derive(Clone, Debug)]
pub(crate) struct OrderCurve {
    /// Orders from that of the delivered controller down.
    pub points: Vec<OrderPoint>,
    /// Part of the stiffness that counts as kept.
    pub kept_part: f64,
}

impl OrderCurve {
    /// The lowest order that keeps the stiffness.
    pub(crate) fn lowest(&self) -> Option<&OrderPoint> {
        self.points.iter().filter(|p| p.keeps).min_by_key(|p| p.order)
    }
}

/// Polishes controllers of lower order than that of a design, from one to the next, and puts the lowest that keeps 95 %
/// of the smallest tool stiffness and every goal into the design.
pub(crate) fn lowest_order(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    design: &mut Design,
    progress: &mut Listener,
) -> Result<OrderCurve, PipelineError> {
    let floors = &weights.tool_stiffness;
    let full = Judged::of(machine, "mu", &design.delivery)?.measured_by(machine, floors)?;
    let mut curve = OrderCurve {
        points: vec![OrderPoint { order: full.order, judged: Some(full.clone()), failure: None, keeps: true }],
        kept_part: KEPT,
    };
    let mut plane = plane_of_law(machine, &design.delivery.controller)?;
    let mut lowest: Option<Delivery> = None;
    while plane.order() >= LEAST_ORDER + STEP {
        let order = plane.order() - STEP;
        let job = PolishJob {
            machine,
            weights,
            problems: &design.problems,
            floors,
            shifts: &[],
            least_decay_per_s: weights.least_decay_per_s.unwrap_or_default(),
            asked_between: &[],
            speeds: settings.speeds,
            effort: settings.polish.unwrap_or_default(),
        };
        match shorter(&job, &design.constant_scales, &plane, order) {
            Ok((judged, delivery, found)) => {
                let keeps = keeps(&judged, &full, machine);
                let shown = judged.stiffness_n_per_m[0] >= SHOWN * full.stiffness_n_per_m[0];
                curve.points.push(OrderPoint { order: judged.order, judged: Some(judged), failure: None, keeps });
                if keeps {
                    lowest = Some(delivery);
                }
                if !shown {
                    break;
                }
                plane = found;
            }
            Err(failure) => {
                curve.points.push(OrderPoint { order: 2 * order, judged: None, failure: Some(failure), keeps: false });
                break;
            }
        }
        progress(Event::Stage("controllers of lower order"));
    }
    if let Some(delivery) = lowest {
        if let ControlLaw::Discrete(law) = &delivery.controller.law {
            design.specification_scale =
                specification_scale(machine, weights, &design.problems, law, &delivery.speed_mu)?;
        }
        if let Some(polish) = &mut design.polish {
            polish.sentence = format!(
                "{} Cut to order {} and polished again, it is delivered in place of that one.",
                polish.sentence,
                2 * delivery.rounded.order
            );
        }
        design.delivery = delivery;
    }
    Ok(curve)
}

/// True when a controller is as stiff as [`KEPT`] asks and misses no goal that the one of full order meets.
fn keeps(judged: &Judged, full: &Judged, machine: &Machine) -> bool {
    let stiff = (0..2).all(|k| judged.stiffness_n_per_m[k] >= KEPT * full.stiffness_n_per_m[k]);
    let rank = |j: &Judged| j.zones.map(|z| z.map_or(usize::MAX, |z| z as usize));
    let (zones, before) = (rank(judged), rank(full));
    let goals = judged.met(machine, None).into_iter().zip(full.met(machine, None));
    stiff && (0..2).all(|k| zones[k] <= before[k]) && goals.into_iter().all(|(own, was)| own || !was)
}

/// Cuts `plane` to `order` states and polishes it: by truncation, or, where that does not levitate the machine, with
/// the static gain kept.
fn shorter(
    job: &PolishJob<'_>,
    scales: &[f64],
    plane: &StateSpace<Discrete>,
    order: usize,
) -> Result<(Judged, Delivery, StateSpace<Discrete>), String> {
    let words = |error: &dyn std::fmt::Display| error.to_string();
    let full = scaled_plane(plane).map_err(|e| words(&e))?;
    let balancing = loop_balancing(job.problems, scales, &full).map_err(|e| words(&e))?;
    let limits = limits(job.machine, ZONE_A).map_err(|e| words(&e))?;
    let mut failure = String::new();
    for cut in [balancing.truncate_states(order), balancing.residualise_states(order)] {
        let polished = cut
            .and_then(|cut| tustin(&unscale_controller(&cut), plane.time.period_s))
            .map_err(|e| words(&e))
            .and_then(|start| job.polish(limits, &start).map_err(|e| words(&e)));
        match polished {
            Ok((judged, delivery, found)) => return Ok((judged, delivery, found.plane)),
            Err(said) => failure = said,
        }
    }
    Err(failure)
}
