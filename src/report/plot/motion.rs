//! Pictures of motion in time: responses stacked by quantity, and orbits in the clearance circle.

use super::Curve;
use super::figure::{Axis, Figure, Level, Panel, Series};
use super::style::{Color, Dash, Look, Role};

/// One quantity over time: heading, label and unit of its axis, curves, and limits drawn as lines.
#[derive(Clone, Debug)]
pub struct TimePanel<'a> {
    /// Heading.
    pub title: &'a str,
    /// Label of the y axis.
    pub label: &'a str,
    /// Unit of the y axis; the curves are in it.
    pub unit: &'a str,
    /// Curves over seconds.
    pub curves: Vec<Curve<'a>>,
    /// Limits with their names.
    pub limits: Vec<(f64, &'a str)>,
}

impl<'a> TimePanel<'a> {
    /// A quantity by its heading, the label and unit of its axis, its curves and limits.
    pub(crate) fn of(
        title: &'a str,
        [label, unit]: [&'a str; 2],
        curves: Vec<Curve<'a>>,
        limits: [(f64, &'a str); 2],
    ) -> Self {
        Self { title, label, unit, curves, limits: limits.to_vec() }
    }
}

/// Time responses below each other on one time axis, in ms.
pub fn time_responses(title: &str, panels: &[TimePanel]) -> Figure {
    let last = panels.len().saturating_sub(1);
    let drawn = panels.iter().enumerate().map(|(k, p)| {
        let mut panel = Panel::new(p.title, Axis::linear("Time", "ms"), Axis::linear(p.label, p.unit));
        panel.series = p
            .curves
            .iter()
            .map(|c| {
                let ms: Vec<f64> = c.x.iter().map(|t| 1e3 * t).collect();
                Series::curve(c.name, &ms, c.y, c.role.look())
            })
            .collect();
        panel.levels = p
            .limits
            .iter()
            .map(|(value, name)| Level { value: *value, label: (*name).to_owned(), dash: Dash::DashDot })
            .collect();
        panel.height_px = if k == last { 225 } else { 190 };
        panel
    });
    Figure::stacked(title, "Responses over time with their limits.", drawn)
}

/// Orbits, one panel a plane: name, x and y in m; drawn in µm within the backup clearance (m).
pub fn orbits(title: &str, planes: &[(&str, &[f64], &[f64])], clearance_m: f64) -> Figure {
    const MICRO: f64 = 1e6;
    let circle = |radius: f64, f: fn(f64) -> f64| -> Vec<f64> {
        (0..=120).map(|k| radius * MICRO * f(f64::from(k) * 3f64.to_radians())).collect()
    };
    let panels = planes.iter().map(|(name, x, y)| {
        let axis = |label: &str| Axis::linear(label, "µm");
        let mut panel = Panel::new(name, axis("x"), axis("y"));
        panel.equal_aspect = true;
        panel.height_px = 380;
        let micro = |v: &[f64]| v.iter().map(|m| MICRO * m).collect::<Vec<f64>>();
        let clearance = (circle(clearance_m, f64::cos), circle(clearance_m, f64::sin));
        panel.series = vec![
            Series::curve("backup bearing", &clearance.0, &clearance.1, Role::Limit.look()),
            Series::curve("orbit", &micro(x), &micro(y), Look::line(Color::Blue, Dash::Solid).with_width(1.2)),
        ];
        panel
    });
    let columns = if planes.len() > 1 { 2 } else { 1 };
    Figure::new(title, "Orbits of the rotor in each plane within the circle of the backup bearing.", panels.collect())
        .with_columns(columns)
}
