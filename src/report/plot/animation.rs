//! The shaft in motion as an SVG that moves by itself: frames as SMIL animations, so that the report needs no script.
//!
//! Left: the shaft from the side, x upwards and y into the picture, displacements enlarged, with the circles of the
//! backup bearings and the orbits at tool, front and rear actuator. Right: the orbits seen along the axis within the
//! backup clearance.
//! Readers who ask their system for less motion see the picture at rest. Same frames, same bytes.

use super::Picture;
use super::svg::escape;
use std::fmt::Write;

/// A plane whose orbit is drawn.
#[derive(Clone, Debug)]
pub(crate) struct OrbitPlane {
    pub name: String,
    pub position_m: f64,
    /// Whether the circle of the backup bearing is drawn round it.
    pub in_bearing: bool,
    /// Displacements in x and y, frame by frame, m.
    pub path_m: Vec<[f64; 2]>,
}

/// What moves.
#[derive(Clone, Debug)]
pub(crate) struct AnimatedMotion {
    pub title: String,
    pub position_m: Vec<f64>,
    /// Displacements of the stations, frame by frame: x, y, m.
    pub frames: Vec<[Vec<f64>; 2]>,
    pub time_s: Vec<f64>,
    pub planes: Vec<OrbitPlane>,
    /// Radial clearance of the backup bearings, m.
    pub clearance_m: f64,
    /// Length of one turn of the animation, s.
    pub seconds: f64,
}

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 400.0;
/// Area of the side view: left, right, middle height.
const SIDE: (f64, f64, f64) = (78.0, 590.0, 235.0);
/// Largest displacement in the side view, px.
const SWING: f64 = 62.0;
/// Direction of the y axis in the side view.
const OBLIQUE: (f64, f64) = (0.55, 0.32);
/// Radius of an orbit seen along the axis, and the column of their centres.
const ORBIT: f64 = 50.0;
const COLUMN: f64 = 722.0;
const COLORS: [&str; 3] = ["#D55E00", "#0072B2", "#009E73"];
const INK: &str = "#191919";
const SOFT: &str = "#7D7D7D";

/// The style of an animation: nothing moves for people who do not want it.
pub(crate) const REDUCED_MOTION: &str = "@media (prefers-reduced-motion: reduce) { .muspin-moving { display: none } }";

/// The animation as SVG text, and its frames as CSV text.
pub(crate) fn animate(motion: &AnimatedMotion) -> Picture {
    Picture { svg: svg(motion), csv: csv(motion), drawing: None }
}

/// Opening tag, title and the scale of time.
fn header(m: &AnimatedMotion) -> String {
    let mut out = String::new();
    let w = &mut out;
    // Writing to a string does not fail.
    let _ = writeln!(
        w,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 \
         0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" stroke-linejoin=\"round\">"
    );
    let _ = writeln!(w, "<title>{}</title>", escape(&m.title));
    let _ = writeln!(
        w,
        "<desc>The shaft in motion, slowed down: from the side with enlarged displacements, and its orbits along the \
         axis.</desc>"
    );
    let _ = writeln!(w, "<style>{REDUCED_MOTION}</style>");
    let _ = writeln!(w, "<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#FFFFFF\"/>");
    text(w, (16.0, 26.0), Style::start(16.0, INK).bold(), &m.title);
    let span_ms = 1e3 * (m.time_s.last().unwrap_or(&0.0) - m.time_s.first().unwrap_or(&0.0));
    let slower = m.seconds / (1e-3 * span_ms).max(1e-9);
    text(w, (16.0, 46.0), Style::start(12.0, SOFT), &format!("{span_ms:.3} ms, slowed down {slower:.0} times"));
    out
}

fn svg(m: &AnimatedMotion) -> String {
    let largest = largest(m);
    // A round scale of the side view: so many px for that many µm.
    let gain = SWING / round_up(largest.max(1e-12));
    let (from, to) = (m.position_m.first().copied().unwrap_or(0.0), m.position_m.last().copied().unwrap_or(1.0));
    let along = |z: f64| SIDE.0 + (SIDE.1 - SIDE.0) * (z - from) / (to - from).max(1e-9);
    let point = |z: f64, x: f64, y: f64| (along(z) + gain * y * OBLIQUE.0, SIDE.2 - gain * (x + y * OBLIQUE.1));
    let orbit = |plane: &OrbitPlane| -> Vec<(f64, f64)> {
        plane.path_m.iter().map(|[x, y]| point(plane.position_m, *x, *y)).collect()
    };
    let mut out = header(m);
    let w = &mut out;
    // Side view: axis at rest, backup bearings, orbits, shaft.
    let rest = [point(from, 0.0, 0.0), point(to, 0.0, 0.0)];
    polyline(w, &rest, SOFT, 1.0, "stroke-dasharray=\"7 5\"");
    let scale_m = round_up(largest.max(1e-12));
    let ruler = [(26.0, SIDE.2), (26.0, SIDE.2 - SWING)];
    polyline(w, &ruler, INK, 1.4, "");
    text(w, (26.0, SIDE.2 - SWING - 7.0), Style::middle(11.5, INK), &length(scale_m));
    text(w, (38.0, SIDE.2 - 0.5 * SWING), Style::start(11.5, INK), "x");
    let y_tip = (26.0 + SWING * OBLIQUE.0, SIDE.2 - SWING * OBLIQUE.1);
    polyline(w, &[(26.0, SIDE.2), y_tip], INK, 1.4, "");
    text(w, (y_tip.0 + 4.0, y_tip.1 + 4.0), Style::start(11.5, INK), "y");
    for (k, plane) in m.planes.iter().enumerate() {
        let color = COLORS[k % COLORS.len()];
        if plane.in_bearing && m.clearance_m <= 1.6 * scale_m {
            let circle: Vec<(f64, f64)> = (0..=72)
                .map(|i| {
                    let (sin, cos) = (f64::from(i) * 5f64.to_radians()).sin_cos();
                    point(plane.position_m, m.clearance_m * cos, m.clearance_m * sin)
                })
                .collect();
            polyline(w, &circle, SOFT, 1.0, "stroke-dasharray=\"3 3\"");
        }
        polyline(w, &orbit(plane), color, 0.9, "stroke-opacity=\"0.55\"");
        let at = along(plane.position_m);
        // Names of neighbouring planes stand on two lines.
        let drop = if k % 2 == 0 { 0.0 } else { 16.0 };
        text(w, (at, SIDE.2 + SWING + 52.0 + drop), Style::middle(12.0, color), &plane.name);
    }
    let shaft: Vec<Vec<(f64, f64)>> = m
        .frames
        .iter()
        .map(|[x, y]| {
            let stations = m.position_m.iter().zip(x).zip(y);
            stations.map(|((z, x), y)| point(*z, *x, *y)).collect()
        })
        .collect();
    moving_line(w, &shaft, m.seconds);
    for (k, plane) in m.planes.iter().enumerate() {
        moving_dot(w, &orbit(plane), COLORS[k % COLORS.len()], m.seconds);
    }
    for (k, plane) in m.planes.iter().enumerate() {
        end_view(w, m, plane, k);
    }
    out.push_str("</svg>\n");
    out
}

/// One orbit along the axis: y to the right, x upwards.
fn end_view(w: &mut String, m: &AnimatedMotion, plane: &OrbitPlane, k: usize) {
    let color = COLORS[k % COLORS.len()];
    let centre = (COLUMN, 78.0 + 122.0 * k as f64);
    let own = plane.path_m.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
    let radius_m =
        if plane.in_bearing && own > 0.2 * m.clearance_m { m.clearance_m.max(own) } else { round_up(own.max(1e-12)) };
    let gain = ORBIT / radius_m;
    let _ = writeln!(
        w,
        "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"none\" stroke=\"{SOFT}\" stroke-dasharray=\"3 3\"/>",
        short(centre.0),
        short(centre.1),
        short(ORBIT)
    );
    let is_clearance = plane.in_bearing && radius_m == m.clearance_m;
    let circle = if is_clearance { "backup clearance" } else { "circle" };
    text(w, (centre.0 + ORBIT + 12.0, centre.1 - 8.0), Style::start(12.0, color).bold(), &plane.name);
    text(w, (centre.0 + ORBIT + 12.0, centre.1 + 9.0), Style::start(11.0, SOFT), circle);
    text(w, (centre.0 + ORBIT + 12.0, centre.1 + 24.0), Style::start(11.0, SOFT), &length(radius_m));
    let at: Vec<(f64, f64)> = plane.path_m.iter().map(|[x, y]| (centre.0 + gain * y, centre.1 - gain * x)).collect();
    polyline(w, &at, color, 1.0, "stroke-opacity=\"0.6\"");
    moving_dot(w, &at, color, m.seconds);
}

fn moving_line(w: &mut String, frames: &[Vec<(f64, f64)>], seconds: f64) {
    let Some(first) = frames.first() else { return };
    let values: Vec<String> = frames.iter().map(|f| points(f)).collect();
    // At rest the first frame stands; the moving copy lies over it.
    polyline(w, first, INK, 1.2, "stroke-opacity=\"0.3\"");
    let _ = writeln!(
        w,
        "<polyline class=\"muspin-moving\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"4\" \
         stroke-linecap=\"round\" points=\"{}\"><animate attributeName=\"points\" dur=\"{}s\" \
         repeatCount=\"indefinite\" values=\"{}\"/></polyline>",
        points(first),
        short(seconds),
        values.join(";")
    );
}

fn moving_dot(w: &mut String, at: &[(f64, f64)], color: &str, seconds: f64) {
    let Some(first) = at.first() else { return };
    let list = |f: fn(&(f64, f64)) -> f64| at.iter().map(|p| short(f(p))).collect::<Vec<String>>().join(";");
    let animate = |name: &str, values: String| {
        format!(
            "<animate attributeName=\"{name}\" dur=\"{}s\" repeatCount=\"indefinite\" values=\"{values}\"/>",
            short(seconds)
        )
    };
    let _ = writeln!(
        w,
        "<circle class=\"muspin-moving\" cx=\"{}\" cy=\"{}\" r=\"4.5\" fill=\"{color}\">{}{}</circle>",
        short(first.0),
        short(first.1),
        animate("cx", list(|p| p.0)),
        animate("cy", list(|p| p.1))
    );
}

fn polyline(w: &mut String, at: &[(f64, f64)], color: &str, width: f64, more: &str) {
    let _ = writeln!(
        w,
        "<polyline fill=\"none\" stroke=\"{color}\" stroke-width=\"{}\" {more} points=\"{}\"/>",
        short(width),
        points(at)
    );
}

/// How a text of the picture looks.
#[derive(Clone, Copy)]
struct Style<'a> {
    size: f64,
    color: &'a str,
    anchor: &'static str,
    bold: bool,
}

impl<'a> Style<'a> {
    fn start(size: f64, color: &'a str) -> Self {
        Self { size, color, anchor: "start", bold: false }
    }

    fn middle(size: f64, color: &'a str) -> Self {
        Self { anchor: "middle", ..Self::start(size, color) }
    }

    fn bold(self) -> Self {
        Self { bold: true, ..self }
    }
}

fn text(w: &mut String, at: (f64, f64), style: Style, words: &str) {
    let Style { size, color, anchor, bold } = style;
    let weight = if bold { " font-weight=\"bold\"" } else { "" };
    let _ = writeln!(
        w,
        "<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{color}\"{weight}>{}</text>",
        short(at.0),
        short(at.1),
        short(size),
        escape(words)
    );
}

fn points(at: &[(f64, f64)]) -> String {
    let pairs: Vec<String> = at.iter().map(|p| format!("{},{}", short(p.0), short(p.1))).collect();
    pairs.join(" ")
}

/// A tenth of a pixel is as fine as a screen shows.
fn short(x: f64) -> String {
    let text = format!("{x:.1}");
    let text = text.strip_suffix(".0").unwrap_or(&text);
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// 1, 2 or 5 times a power of ten, not below x > 0.
fn round_up(x: f64) -> f64 {
    let decade = 10f64.powf(x.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|step| step * decade)
        .find(|value| *value >= x * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

fn length(m: f64) -> String {
    let micro = 1e6 * m;
    if micro < 0.0995 {
        format!("{:.0} nm", 1e3 * micro)
    } else if micro < 9.95 {
        format!("{} µm", short(micro))
    } else {
        format!("{micro:.0} µm")
    }
}

fn largest(m: &AnimatedMotion) -> f64 {
    let stations = m.frames.iter().flat_map(|[x, y]| x.iter().zip(y));
    stations.map(|(x, y)| x.hypot(*y)).fold(0.0, f64::max)
}

/// Frames of the planes: time, then x and y of each, m.
fn csv(m: &AnimatedMotion) -> String {
    let mut header = vec!["time_s".to_owned()];
    for plane in &m.planes {
        let name = plane.name.replace(' ', "_");
        header.push(format!("{name}_x_m"));
        header.push(format!("{name}_y_m"));
    }
    let mut table = crate::report::tables::Table::new(header);
    for (k, time) in m.time_s.iter().enumerate() {
        let row: Vec<f64> = std::iter::once(*time).chain(m.planes.iter().flat_map(|p| p.path_m[k])).collect();
        table.push_numbers(&row);
    }
    table.to_csv()
}
