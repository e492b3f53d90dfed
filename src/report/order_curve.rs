//! Tool stiffness against the order of the controller: figures and picture.

use super::plot::figure::{Axis, Figure, Panel, Series};
use super::plot::{Color, Look, Marker};
use super::summary::finite;
use crate::pipeline::order_curve::{OrderCurve, OrderPoint};
use crate::predict::sensitivity::Zone;
use serde::Serialize;

/// N/m in N/µm.
const PER_MICROMETRE: f64 = 1e-6;

#[derive(Serialize)]
pub(crate) struct OrderCurveSummary {
    /// Orders from that of the polished controller down.
    points: Vec<OrderRow>,
    /// The lowest order that keeps the stiffness and the goals; it is delivered.
    lowest_order: Option<usize>,
    /// Part of the smallest tool stiffness that counts as kept.
    kept_part: f64,
    sentence: String,
}

/// A controller of one order, both planes together.
#[derive(Serialize)]
struct OrderRow {
    order: usize,
    keeps: bool,
    minimum_n_per_m_at_rest: Option<f64>,
    minimum_n_per_m_at_top_speed: Option<f64>,
    mu: Option<f64>,
    zone_at_rest: Option<String>,
    zone_at_top_speed: Option<String>,
    failure: Option<String>,
}

impl OrderCurveSummary {
    pub(crate) fn of(curve: &OrderCurve) -> Self {
        let lowest = curve.lowest();
        let full = curve.points.first().map_or(0, |p| p.order);
        Self {
            points: curve.points.iter().map(OrderRow::of).collect(),
            lowest_order: lowest.map(|p| p.order),
            kept_part: curve.kept_part,
            sentence: match lowest {
                Some(lowest) if lowest.order < full => format!(
                    "A controller of order {} keeps {:.0} % of the smallest tool stiffness and every goal of the one \
                     of order {full}; it is delivered.",
                    lowest.order,
                    100.0 * curve.kept_part
                ),
                _ => format!(
                    "No controller of lower order than {full} keeps {:.0} % of the smallest tool stiffness and every \
                     goal.",
                    100.0 * curve.kept_part
                ),
            },
        }
    }
}

impl OrderRow {
    fn of(point: &OrderPoint) -> Self {
        let zone = |z: Option<Zone>| z.map(|z| z.letter().to_owned());
        let judged = point.judged.as_ref();
        let stiffness = |k: usize| judged.and_then(|j| finite(j.stiffness_n_per_m[k]));
        Self {
            order: point.order,
            keeps: point.keeps,
            minimum_n_per_m_at_rest: stiffness(0),
            minimum_n_per_m_at_top_speed: stiffness(1),
            mu: judged.and_then(|j| finite(j.mu)),
            zone_at_rest: judged.and_then(|j| zone(j.zones[0])),
            zone_at_top_speed: judged.and_then(|j| zone(j.zones[1])),
            failure: point.failure.clone(),
        }
    }
}

/// The curve as a picture, with the level that counts as kept.
pub(crate) fn order_figure(curve: &OrderCurve) -> Figure {
    let mut panel = Panel::new(
        "",
        Axis::linear("Order of the controller, both planes", ""),
        Axis::linear("Smallest tool stiffness", "N/µm"),
    );
    let polished: Vec<_> =
        curve.points.iter().filter_map(|p| Some((p.order as f64, p.judged.as_ref()?.stiffness_n_per_m))).collect();
    let orders: Vec<f64> = polished.iter().map(|p| p.0).collect();
    let shown = [("at rest", Color::Blue, Marker::Circle), ("at top speed", Color::Vermillion, Marker::Triangle)];
    for (k, (name, color, marker)) in shown.into_iter().enumerate() {
        let values: Vec<f64> = polished.iter().map(|p| PER_MICROMETRE * p.1[k]).collect();
        let look = Look::points(color, marker);
        panel.series.push(Series::curve(name, &orders, &values, look));
    }
    if let Some((_, full)) = polished.first() {
        panel.level(
            PER_MICROMETRE * curve.kept_part * full[0].min(full[1]),
            format!("{:.0} % kept", 100.0 * curve.kept_part),
        );
    }
    Figure::new(
        "Tool stiffness against the order of the controller",
        "Each controller is cut from the one before and polished again, within the same limits; every point has all \
         certificates.",
        vec![panel],
    )
}
