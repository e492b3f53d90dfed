//! Tool stiffness against the order of the controller: figures and picture.

use super::plot::figure::{Axis, Figure, Panel, Series};
use super::plot::{Color, Look, Marker};
use crate::pipeline::order_curve::{OrderCurve, OrderPoint};
use crate::predict::sensitivity::Zone;
use serde_json::{Value, json};

/// N/m in N/µm.
const PER_MICROMETRE: f64 = 1e-6;

/// Orders from that of the polished controller down, both planes together; the lowest that keeps the stiffness and the
/// goals is delivered.
pub(crate) fn order_curve_topic(curve: &OrderCurve) -> Value {
    let lowest = curve.lowest();
    let full = curve.points.first().map_or(0, |p| p.order);
    let percent = 100.0 * curve.kept_part;
    json!({
        "points": curve.points.iter().map(point_topic).collect::<Vec<_>>(),
        "lowest_order": lowest.map(|p| p.order),
        "kept_part": curve.kept_part,
        "sentence": match lowest {
            Some(lowest) if lowest.order < full => format!(
                "A controller of order {} keeps {percent:.0} % of the smallest tool stiffness and every goal of the \
                 one of order {full}; it is delivered.",
                lowest.order
            ),
            _ => format!(
                "No controller of lower order than {full} keeps {percent:.0} % of the smallest tool stiffness and \
                 every goal."
            ),
        },
    })
}

fn point_topic(point: &OrderPoint) -> Value {
    let judged = point.judged.as_ref();
    let [rest_n_per_m, speed_n_per_m] = [0, 1].map(|k| judged.map(|j| j.stiffness_n_per_m[k]));
    let [zone_at_rest, zone_at_top_speed] = [0, 1].map(|k| judged.and_then(|j| j.zones[k]).map(Zone::letter));
    json!({
        "order": point.order,
        "keeps": point.keeps,
        "minimum_n_per_m_at_rest": rest_n_per_m,
        "minimum_n_per_m_at_top_speed": speed_n_per_m,
        "mu": judged.map(|j| j.mu),
        "zone_at_rest": zone_at_rest,
        "zone_at_top_speed": zone_at_top_speed,
        "failure": point.failure,
    })
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
    let shown = [("at rest", Color::Blue, Marker::Circle), ("at top speed", Color::Vermillion, Marker::Triangle)];
    for (k, (name, color, marker)) in shown.into_iter().enumerate() {
        let points = polished.iter().map(|(order, stiffness)| (*order, PER_MICROMETRE * stiffness[k]));
        panel.series.push(Series::of_points(name, points, Look::points(color, marker)));
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
