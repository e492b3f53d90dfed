//! Whirl modes in space: the line of the shaft and the orbits along it, seen obliquely.

use super::figure::{Axis, Figure, Panel, Series};
use super::style::{Color, Dash, Look, Marker};
use crate::linalg::c64;
use crate::spindle::WhirlOrbits;
use std::f64::consts::TAU;

/// Where a unit of y points on the page, in units of x: into the picture.
const OBLIQUE: [f64; 2] = [0.55, 0.32];
/// Length on the axis of the shaft that a unit of displacement is drawn as, as a share of the shaft.
const UNIT: f64 = 0.12;
/// Modes that are drawn: the first pairs.
const MODES: usize = 6;
/// An orbit is drawn at every so many places, over this share of its turn: from the mark on, it shows the direction.
const EVERY: usize = 4;
const TURN: f64 = 0.85;
const POINTS: usize = 48;

/// The modes of a rotor at a speed.
pub fn whirl_shapes(title: &str, found: &WhirlOrbits) -> Figure {
    let (first, last) = (found.position_m.first().unwrap_or(&0.0), found.position_m.last().unwrap_or(&1.0));
    let length = 1e3 * (last - first);
    // An orbit at an end of the shaft reaches beyond it.
    let beyond = 1.1 * UNIT * length * OBLIQUE[0];
    let project = |z: f64, [x, y]: [c64; 2], angle: f64| {
        let turned = [x, y].map(|amplitude| (amplitude * c64::cis(angle)).re);
        (1e3 * z + UNIT * length * OBLIQUE[0] * turned[1], turned[0] + OBLIQUE[1] * turned[1])
    };
    let panels = found.shapes.iter().take(MODES).enumerate().map(|(k, shape)| {
        let (name, color) = match shape.mode.whirl {
            w if w > 0.0 => ("forward whirl", Color::Blue),
            w if w < 0.0 => ("backward whirl", Color::Vermillion),
            _ => ("motion in one plane", Color::Green),
        };
        let hz = shape.mode.damped_rad_s / TAU;
        let x = Axis::linear("Axial position from the nose face", "mm")
            .with_range(1e3 * first - beyond, 1e3 * last + beyond);
        let mut panel = Panel::new(&format!("{}: {hz:.1} Hz, {name}", k + 1), x, Axis::linear("Displacement", ""));
        panel.y.range = Some([-1.4, 1.4]);
        panel.height_px = 250;
        let places = || found.position_m.iter().zip(&shape.orbits);
        let rest = Look::line(Color::Grey, Dash::Dotted).with_width(1.0);
        panel.series.push(Series::of_points("shaft at rest", places().map(|(z, _)| (1e3 * z, 0.0)), rest));
        for (place, (z, orbit)) in places().step_by(EVERY).enumerate() {
            let angle = |k: usize| TAU * TURN * k as f64 / POINTS as f64;
            let points = (0..=POINTS).map(|k| project(*z, *orbit, angle(k)));
            let begin = points.clone().take(1);
            let mut turn = Series::of_points(name, points, Look::line(color, Dash::Solid).with_width(1.0));
            let look = Look::points(color, Marker::Disc);
            let mut mark = Series::of_points("place at the beginning of the turn", begin, look);
            turn.in_legend = place == 0;
            mark.in_legend = k == 0 && place == 0;
            panel.series.extend([turn, mark]);
        }
        let line = places().map(|(z, orbit)| project(*z, *orbit, 0.0));
        let look = Look::line(Color::Black, Dash::Solid);
        panel.series.push(Series::of_points("shaft at the beginning of the turn", line, look));
        panel
    });
    let words = "Whirl modes seen obliquely, x upwards and y into the picture: orbits along the shaft from their marks \
                 on, in the direction of the whirl, and the line of the shaft at one instant.";
    Figure::new(title, words, panels.collect()).with_columns(2)
}
