//! Pictures of motion in time: responses stacked by quantity, and orbits in the clearance circle.

use super::figure::{Axis, Figure, Level, Panel, Series};
use super::style::{Color, Dash, Look, Role};

/// A quantity over time in ms: heading, label and unit of its axis, series, and limits drawn as lines.
pub fn time_panel(title: &str, [label, unit]: [&str; 2], series: Vec<Series>, limits: &[(f64, &str)]) -> Panel {
    let mut panel = Panel::new(title, Axis::linear("Time", "ms"), Axis::linear(label, unit));
    panel.series = series;
    let level = |(value, name): &(f64, &str)| Level { value: *value, label: (*name).to_owned(), dash: Dash::DashDot };
    panel.levels = limits.iter().map(level).collect();
    panel
}

/// Time responses below each other on one time axis.
pub fn time_responses(title: &str, mut panels: Vec<Panel>) -> Figure {
    panels.iter_mut().for_each(|panel| panel.height_px = 190);
    panels.iter_mut().last().into_iter().for_each(|panel| panel.height_px = 225);
    Figure::stacked(title, "Responses over time with their limits.", panels)
}

/// Orbits, one panel a plane: name, x and y in m; drawn in µm within the backup clearance (m).
pub fn orbits(title: &str, planes: &[(&str, &[f64], &[f64])], clearance_m: f64) -> Figure {
    const MICRO: f64 = 1e6;
    let circle = (0..=120).map(|k| f64::from(k) * 3f64.to_radians());
    let circle = circle.map(|a| (clearance_m * MICRO * a.cos(), clearance_m * MICRO * a.sin()));
    let panels = planes.iter().map(|(name, x, y)| {
        let axis = |label: &str| Axis::linear(label, "µm");
        let mut panel = Panel::new(name, axis("x"), axis("y"));
        panel.equal_aspect = true;
        panel.height_px = 380;
        let orbit = x.iter().zip(*y).map(|(x, y)| (MICRO * x, MICRO * y));
        panel.series = vec![
            Series::of_points("backup bearing", circle.clone(), Role::Limit.look()),
            Series::of_points("orbit", orbit, Look::line(Color::Blue, Dash::Solid).with_width(1.2)),
        ];
        panel
    });
    let columns = if planes.len() > 1 { 2 } else { 1 };
    Figure::new(title, "Orbits of the rotor in each plane within the circle of the backup bearing.", panels.collect())
        .with_columns(columns)
}
