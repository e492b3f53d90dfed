//! Pictures of the rotor: mode shapes along the axis over its outline, and the Campbell diagram.

use super::Curve;
use super::figure::{Axis, Figure, Mark, Panel, Series, SeriesShape};
use super::style::{Color, Dash, Look, Marker, Role};
use crate::pipeline::loop_curves::WhirlLine;
use crate::rotor::Rotor;

/// A piece of shaft for the outline: from, to, outer diameter, m, in the machine's axis (tool side negative).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePiece {
    /// Start, m.
    pub from_m: f64,
    /// End, m.
    pub to_m: f64,
    /// Outer diameter, m.
    pub diameter_m: f64,
}

impl OutlinePiece {
    /// The pieces of a rotor; a cone as a cylinder of its mean diameter.
    pub(crate) fn list(rotor: &Rotor) -> Vec<Self> {
        let each = rotor.sections().iter().zip(rotor.node_positions_m().windows(2));
        let piece = |d: [f64; 2], z: &[f64]| Self { from_m: z[0], to_m: z[1], diameter_m: 0.5 * (d[0] + d[1]) };
        each.map(|(section, z)| piece(section.outer_diameter_m, z)).collect()
    }
}

/// What stands at an axial position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationKind {
    /// Displacement sensors.
    Sensor,
    /// Bearing actuator.
    Actuator,
    /// Tool plane or any other.
    Other,
}

/// A named axial position.
#[derive(Clone, Copy, Debug)]
pub struct Station<'a> {
    /// Short name above the picture.
    pub name: &'a str,
    /// Position, m.
    pub position_m: f64,
    /// Sensor, actuator or other.
    pub kind: StationKind,
}

/// Outline of the rotor on top, below it one panel a mode: heading (`mode 1: 1069 Hz`) and its curves over positions in
/// m. Every curve is scaled to a largest amplitude of one, and its sign is turned to agree with the first of its mode;
/// what is measured is drawn as points.
pub fn mode_shapes(
    title: &str,
    outline: &[OutlinePiece],
    stations: &[Station],
    modes: &[(String, Vec<Curve>)],
) -> Figure {
    const MILLI: f64 = 1e3;
    let ends = |f: fn(&OutlinePiece) -> f64, pick: fn(f64, f64) -> f64, start: f64| {
        outline.iter().map(f).fold(start, pick) * MILLI
    };
    let mut low = ends(|p| p.from_m, f64::min, f64::INFINITY);
    let mut high = ends(|p| p.to_m, f64::max, f64::NEG_INFINITY);
    for z in modes.iter().flat_map(|m| &m.1).flat_map(|c| c.x) {
        low = low.min(z * MILLI);
        high = high.max(z * MILLI);
    }
    if !(low.is_finite() && high > low) {
        (low, high) = (0.0, 1.0);
    }
    let x = || Axis::linear("Axial position from the nose face", "mm").with_range(low - 5.0, high + 5.0);

    let mut panels = Vec::new();
    if !outline.is_empty() {
        let mut shaft = Panel::new("", x(), Axis::linear("Radius", "mm"));
        let z: Vec<f64> = outline.iter().flat_map(|p| [p.from_m * MILLI, p.to_m * MILLI]).collect();
        let r: Vec<f64> = outline.iter().flat_map(|p| [0.5 * p.diameter_m * MILLI; 2]).collect();
        let lower: Vec<f64> = r.iter().map(|r| -r).collect();
        let look = Look::line(Color::Black, Dash::Solid).with_width(1.0);
        let edge = |name: &str, y: &[f64]| Series::curve(name, &z, y, look).without_entry();
        shaft.series = vec![
            Series::curve("outline", &z, &r, look)
                .with_shape(SeriesShape::Band { lower: lower.clone() })
                .without_entry(),
            edge("outline, upper edge", &r),
            edge("outline, lower edge", &lower),
        ];
        shaft.marks = station_marks(stations, true);
        shaft.height_px = 150;
        panels.push(shaft);
    }
    let last = modes.len().saturating_sub(1);
    for (k, (heading, curves)) in modes.iter().enumerate() {
        let y = Axis::linear("Amplitude", "").with_range(-1.15, 1.15).with_step(1.0);
        let mut panel = Panel::new(heading, x(), y);
        let reference = curves.first().copied();
        for c in curves {
            let sign = reference.map_or(1.0, |r| agreement(&r, c));
            let largest = c.y.iter().fold(0.0, |a: f64, b| a.max(b.abs())).max(f64::MIN_POSITIVE);
            let z: Vec<f64> = c.x.iter().map(|z| z * MILLI).collect();
            let y: Vec<f64> = c.y.iter().map(|a| sign * a / largest).collect();
            let look = match c.role {
                Role::Measured => Look::points(Color::Black, Marker::Circle),
                role => role.look(),
            };
            panel.series.push(Series::curve(c.name, &z, &y, look));
        }
        panel.marks = station_marks(stations, outline.is_empty() && k == 0);
        panel.height_px = if k == last { 190 } else { 155 };
        panels.push(panel);
    }
    let words = "Bending mode shapes along the rotor, with the outline and the planes of sensors and actuators.";
    Figure::stacked(title, words, panels)
}

fn station_marks(stations: &[Station], labelled: bool) -> Vec<Mark> {
    stations
        .iter()
        .map(|s| {
            let (color, dash, legend) = match s.kind {
                StationKind::Sensor => (Color::Green, Dash::Dashed, "sensor"),
                StationKind::Actuator => (Color::Vermillion, Dash::DashDot, "actuator"),
                StationKind::Other => (Color::Grey, Dash::Dotted, ""),
            };
            Mark {
                value: 1e3 * s.position_m,
                label: if labelled { s.name.to_owned() } else { String::new() },
                color,
                dash,
                legend: legend.to_owned(),
            }
        })
        .collect()
}

/// +1 or −1: whether a curve points the way of the reference, by their product at the curve's positions.
fn agreement(reference: &Curve, curve: &Curve) -> f64 {
    let mut points: Vec<(f64, f64)> = reference.x.iter().copied().zip(reference.y.iter().copied()).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let interpolated = |z: f64| match points.windows(2).find(|w| w[0].0 <= z && z <= w[1].0) {
        Some([a, b]) if b.0 > a.0 => a.1 + (b.1 - a.1) * (z - a.0) / (b.0 - a.0),
        Some([a, ..]) => a.1,
        _ => 0.0,
    };
    let product: f64 = curve.x.iter().zip(curve.y).map(|(z, a)| a * interpolated(*z)).sum();
    if product < 0.0 { -1.0 } else { 1.0 }
}

/// Campbell diagram with the lines of `orders` times the speed.
pub fn campbell(title: &str, lines: &[WhirlLine], orders: &[f64]) -> Figure {
    let mut panel = Panel::new("", Axis::linear("Speed", "rpm"), Axis::linear("Natural frequency", "Hz"));
    panel.height_px = 420;
    for line in lines {
        let (name, look) = match line.whirl {
            w if w > 0 => ("forward whirl", Look::line(Color::Blue, Dash::Solid).with_marker(Marker::Triangle)),
            w if w < 0 => ("backward whirl", Look::line(Color::Vermillion, Dash::Dashed).with_marker(Marker::Circle)),
            _ => ("planar", Look::line(Color::Grey, Dash::Solid).with_marker(Marker::Square)),
        };
        panel.series.push(Series::curve(name, &line.speed_rpm, &line.frequency_hz, look));
    }
    let top = lines.iter().flat_map(|l| &l.frequency_hz).fold(0.0, |a: f64, b| a.max(*b));
    let last = lines.iter().flat_map(|l| &l.speed_rpm).fold(0.0, |a: f64, b| a.max(*b));
    for (order, dash) in orders.iter().zip([Dash::DashDot, Dash::Dotted, Dash::Dashed].into_iter().cycle()) {
        let name = format!("{order}× speed");
        let y = [0.0, order * last / 60.0];
        panel.series.push(Series::curve(&name, &[0.0, last], &y, Look::line(Color::Black, dash).with_width(1.2)));
    }
    if top > 0.0 {
        panel.y.range = Some([0.0, (top * 1.05 / 500.0).ceil() * 500.0]);
    }
    Figure::new(title, "Natural frequencies of the free rotor over speed, forward and backward whirl.", vec![panel])
}
