//! The report of a design with what was asked beside it.

use super::design_summary::DesignSummary;
use super::order_curve::{OrderCurveSummary, order_figure};
use super::pictures::Picture;
use super::plot::Role;
use super::run::UNPOLISHED;
use super::run_figures::{Measured, predictions, robustness};
use super::unstable::add_instability;
use super::variant_summary::{LimitSummary, TighteningSummary, VariantSummary};
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
    report.summary.set("design", DesignSummary::from(found));
    if add_instability(&mut report, found) {
        report.controller(machine, found, None)?;
        return Ok(report);
    }
    if let Some(curve) = &study.orders {
        report.summary.set("design.order_curve", OrderCurveSummary::of(curve));
        report.figures([(Picture::OrderCurve, order_figure(curve))])?;
    }
    report.arithmetic(found, &study.arithmetic);
    if let Some(written) = &study.written {
        let beside = TighteningSummary::of(written, found, rest);
        report.summary.set("tightening", beside);
    }
    if let Some(other) = &study.other_route {
        let designs = VariantSummary::of_routes((route, found, rest), other);
        report.summary.set("routes.designs", designs);
    }
    report.predictions("mu", [rest, speed]);
    let mut runs = vec![(Role::Mu, rest), (Role::Mu, speed)];
    if let Some([dk, fast]) = &study.unpolished {
        report.predictions("dk", [dk, fast]);
        runs.extend([(UNPOLISHED, dk), (UNPOLISHED, fast)]);
    }
    let mut limits = vec![];
    if let Some(limit) = &study.limit {
        let figures = LimitSummary::of(limit, rest.minimum.0);
        report.summary.set("design.stiffness_limit", figures);
        limits.push(Measured::limit(limit, machine.spindle.stiffness_band_hz));
    }
    let top_rpm = machine.spindle.max_rpm;
    let drawn = robustness(found).into_iter();
    report.figures(drawn.chain(predictions(&runs, &limits, top_rpm / 60.0)))?;
    report.loop_of("mu", &study.curves, [rest, speed], top_rpm)?;
    report.controller(machine, found, None)?;
    Ok(report)
}
