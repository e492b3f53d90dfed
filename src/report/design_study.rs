//! The report of a design with what was asked beside it.

use super::design_summary::design_topic;
use super::order_curve::{order_curve_topic, order_figure};
use super::pictures::Picture;
use super::plot::Role;
use super::run::UNPOLISHED;
use super::run_figures::{Measured, predictions, robustness};
use super::unstable::add_instability;
use super::variant_summary::{arithmetic_topic, limit_topic, routes_topic, tightening_topic};
use super::whole::{Report, ReportError};
use crate::augment::plane::Route;
use crate::pipeline::study::Study;
use crate::spindle::Machine;

/// Summary, pictures and controller files of a design by `route`.
pub(crate) fn design_report(machine: &Machine, study: &Study, route: Route) -> Result<Report, ReportError> {
    let found = &study.design;
    let [rest, speed] = study.delivered.each_ref();
    let mut report = Report::of("design", machine);
    report.summary.set("weights", study.weights.name.as_str());
    report.summary.set("design", design_topic(found));
    if add_instability(&mut report, found) {
        report.controller("controller/", machine, found, None)?;
        return Ok(report);
    }
    if let Some(curve) = &study.orders {
        report.summary.set("design.order_curve", order_curve_topic(curve));
        report.figures([(Picture::OrderCurve, order_figure(curve))])?;
    }
    report.summary.set("design.arithmetic", arithmetic_topic(found, &study.arithmetic));
    if let Some(written) = &study.written {
        report.summary.set("tightening", tightening_topic(written, found, rest));
    }
    if let Some(other) = &study.other_route {
        report.summary.set("routes.designs", routes_topic(route, found, rest, other));
    }
    report.predictions("mu", [rest, speed]);
    let mut runs = vec![(Role::Mu, rest), (Role::Mu, speed)];
    if let Some([dk, fast]) = &study.unpolished {
        report.predictions("dk", [dk, fast]);
        runs.extend([(UNPOLISHED, dk), (UNPOLISHED, fast)]);
    }
    let mut limits = vec![];
    if let Some(limit) = &study.limit {
        report.summary.set("design.stiffness_limit", limit_topic(limit, rest.minimum.0));
        limits.push(Measured::limit(limit, machine.spindle.stiffness_band_hz));
    }
    let top_rpm = machine.spindle.max_rpm;
    let drawn = robustness(found).into_iter();
    report.figures(drawn.chain(predictions(&runs, &limits, top_rpm / 60.0)))?;
    report.loop_of("mu", &study.curves, [rest, speed], top_rpm)?;
    report.controller("controller/", machine, found, None)?;
    Ok(report)
}
