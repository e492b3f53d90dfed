//! The one renderer: any [`Figure`] to a [`Drawing`], which every format shows alike. Same figure, same drawing.
//!
//! Title, one legend for all panels, then the panels in a grid. What could overlap is spread apart: labels of vertical
//! marks in a strip above the panel, labels of levels in the right margin. Text is measured with the embedded DejaVu
//! font, wider than what viewers usually put in its place.

use super::PlotError;
use super::canvas::{Anchor, Canvas, FINE, Ink, Shape, Type};
use super::draw;
use super::figure::{Axis, Figure, Panel, Scale};
use super::frame::{Direction, PlotFrame, Rect, axis_range, spread};
use super::style::Dash;
use super::ticks::{Ticks, ticks};
use super::typography::face;

/// Em of axis numbers and labels, px.
const SMALL: f64 = 12.0;
const TITLE: f64 = 16.0;
const LINE: f64 = 18.0;

/// A panel with its ranges, ticks and margins settled.
struct PreparedPanel<'a> {
    panel: &'a Panel,
    x: [f64; 2],
    y: [f64; 2],
    y_ticks: Ticks,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// A figure as lines, areas and texts on a surface of its size.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    pub(super) title: String,
    pub(super) description: String,
    pub(super) width_px: f64,
    pub(super) height_px: f64,
    pub(super) shapes: Vec<Shape>,
    /// Axes of the panels as JSON, from which a page reads values at the pointer.
    pub(super) axes: String,
}

pub(super) fn draw(figure: &Figure) -> Result<Drawing, PlotError> {
    figure.check()?;
    let width = f64::from(figure.width_px);
    let columns = figure.columns.max(1);
    let mut canvas = Canvas::new()?;
    let entries = draw::legend_entries(figure);
    let legend_rows = draw::legend_rows(&canvas, &entries, width - 40.0)?;
    // An empty panel is left out unless it is the only one, or carries the labels of the panels above it.
    let carries = |p: &Panel| p.x.labelled && figure.panels.iter().any(|other| !other.x.labelled);
    let any = figure.panels.iter().any(Panel::shows_anything);
    let kept = figure.panels.iter().filter(|p| !any || p.shows_anything() || carries(p));
    let prepared: Vec<PreparedPanel> = kept.map(|p| prepare(&canvas, p)).collect::<Result<_, _>>()?;
    let rows: Vec<f64> = prepared
        .chunks(columns)
        .map(|row| row.iter().map(|p| f64::from(p.panel.height_px)).fold(0.0, f64::max))
        .collect();
    let head = 34.0 + LINE * legend_rows.len() as f64 + if legend_rows.is_empty() { 0.0 } else { 6.0 };
    let height = head + rows.iter().sum::<f64>() + 8.0;

    canvas.text(&figure.title, (16.0, 20.0), Anchor::Left, face(TITLE, true, 25));
    for (k, row) in legend_rows.iter().enumerate() {
        draw::legend_row(&mut canvas, &entries, row, 16.0, 34.0 + LINE * (k as f64 + 0.5));
    }
    let cell = (width - 16.0) / columns as f64;
    let mut top = head;
    let mut axes = vec![];
    for (row, row_height) in prepared.chunks(columns).zip(&rows) {
        for (column, panel) in row.iter().enumerate() {
            // The plot areas of one column line up.
            let side =
                |f: fn(&PreparedPanel) -> f64| prepared.iter().skip(column).step_by(columns).map(f).fold(0.0, f64::max);
            let left = 8.0 + cell * column as f64;
            let rect = Rect {
                left: left + side(|p| p.left),
                top: top + panel.top,
                right: left + cell - side(|p| p.right),
                bottom: top + row_height - panel.bottom,
            };
            axes.push(draw_panel(&mut canvas, panel, rect, left)?);
        }
        top += row_height;
    }
    Ok(Drawing {
        title: figure.title.clone(),
        description: figure.description.clone(),
        width_px: width,
        height_px: height,
        shapes: canvas.shapes,
        axes: format!("[{}]", axes.join(",")),
    })
}

fn prepare<'a>(ruler: &Canvas, panel: &'a Panel) -> Result<PreparedPanel<'a>, PlotError> {
    let x = axis_range(panel, Direction::Across)?;
    let y = axis_range(panel, Direction::Up)?;
    let room = ((f64::from(panel.height_px) - 60.0) / 26.0).clamp(2.0, 12.0) as usize;
    let y_ticks = axis_ticks(&panel.y, y, room);
    let number = face(SMALL, false, 60);
    let mut widest: f64 = 0.0;
    for (_, label) in &y_ticks.major {
        widest = widest.max(ruler.text_width(label, number)?);
    }
    let mut right: f64 = 24.0;
    for level in &panel.levels {
        right = right.max(16.0 + ruler.text_width(&level.label, face(SMALL - 1.0, false, 60))?);
    }
    if panel.heat.is_some() {
        right = right.max(92.0);
    }
    let has_mark_labels = panel.marks.iter().any(|m| !m.label.is_empty());
    Ok(PreparedPanel {
        panel,
        x,
        y,
        y_ticks,
        left: widest + 12.0 + if panel.y.label.is_empty() { 4.0 } else { 22.0 },
        right,
        top: if panel.title.is_empty() { 8.0 } else { 24.0 } + if has_mark_labels { 30.0 } else { 0.0 },
        bottom: match (panel.x.labelled, panel.x.caption().is_empty()) {
            (false, _) => 10.0,
            (true, true) => 26.0,
            (true, false) => 46.0,
        },
    })
}

fn axis_ticks(axis: &super::figure::Axis, range: [f64; 2], room: usize) -> Ticks {
    if axis.categories.is_empty() {
        return ticks(axis.scale, range, room, axis.tick_step);
    }
    let named = axis.categories.iter().enumerate().map(|(k, name)| (k as f64, name.clone()));
    Ticks { major: named.filter(|(k, _)| *k >= range[0] && *k <= range[1]).collect(), minor: Vec::new() }
}

fn draw_panel(canvas: &mut Canvas, prepared: &PreparedPanel, rect: Rect, left: f64) -> Result<String, PlotError> {
    let panel = prepared.panel;
    let (mut x, mut y) = (prepared.x, prepared.y);
    let mut y_ticks = prepared.y_ticks.clone();
    if panel.equal_aspect {
        (x, y) = equal_aspect(rect, x, y);
        y_ticks = axis_ticks(&panel.y, y, ((rect.bottom - rect.top) / 30.0) as usize);
    }
    let frame = PlotFrame { rect, x: (panel.x.scale, x), y: (panel.y.scale, y) };
    let room = ((rect.right - rect.left) / 58.0).max(2.0) as usize;
    let x_ticks = axis_ticks(&panel.x, x, room);

    if let Some(heat) = &panel.heat {
        draw::heat_map(canvas, &frame, heat);
    } else {
        grid(canvas, &frame, &x_ticks, &y_ticks);
    }
    for mark in &panel.marks {
        let at = frame.px(mark.value);
        if frame.contains(at, rect.top) {
            canvas.line(&[(at, rect.top), (at, rect.bottom)], mark.color.into(), mark.dash, 1.0);
        }
    }
    for level in &panel.levels {
        let at = frame.py(level.value);
        if frame.contains(rect.left, at) {
            canvas.line(&[(rect.left, at), (rect.right, at)], Ink::grey(40), level.dash, 1.2);
        }
    }
    for series in &panel.series {
        draw::series(canvas, &frame, series);
    }
    let corners = [
        (rect.left, rect.top),
        (rect.right, rect.top),
        (rect.right, rect.bottom),
        (rect.left, rect.bottom),
        (rect.left, rect.top),
    ];
    canvas.line(&corners, Ink::grey(90), Dash::Solid, 1.0);
    labels(canvas, panel, &frame, &x_ticks, &y_ticks, left)?;
    mark_labels(canvas, panel, &frame)?;
    level_labels(canvas, panel, &frame);
    Ok(axes_of(panel, &frame))
}

/// The axes of a panel as JSON: plot area in units of the picture, scale, range and caption of x and y.
fn axes_of(panel: &Panel, frame: &PlotFrame) -> String {
    let r = frame.rect;
    let area: Vec<String> = [r.left, r.top, r.right, r.bottom].iter().map(|px| format!("{:.0}", px * FINE)).collect();
    let axis = |(scale, [low, high]): (Scale, [f64; 2]), axis: &Axis| {
        let log = u8::from(scale == Scale::Log);
        let plain = |text: &str| text.replace(['"', '\\'], "'");
        let (label, unit) = (plain(&axis.label), plain(&axis.unit));
        format!("[{log},{low:e},{high:e},\"{label}\",\"{unit}\"]")
    };
    format!("{{\"r\":[{}],\"x\":{},\"y\":{}}}", area.join(","), axis(frame.x, &panel.x), axis(frame.y, &panel.y))
}

/// Ranges widened so that a unit is as long across as up.
fn equal_aspect(rect: Rect, x: [f64; 2], y: [f64; 2]) -> ([f64; 2], [f64; 2]) {
    let (width, height) = (rect.right - rect.left, rect.bottom - rect.top);
    let unit = ((x[1] - x[0]) / width).max((y[1] - y[0]) / height);
    let widen = |[low, high]: [f64; 2], length: f64| {
        let (centre, half) = (0.5 * (low + high), 0.5 * unit * length);
        [centre - half, centre + half]
    };
    (widen(x, width), widen(y, height))
}

fn grid(canvas: &mut Canvas, frame: &PlotFrame, x: &Ticks, y: &Ticks) {
    let r = frame.rect;
    let majors = |t: &Ticks| t.major.iter().map(|m| m.0).collect::<Vec<f64>>();
    for (positions, level) in [((&x.minor, &y.minor), 236), ((&majors(x), &majors(y)), 208)] {
        let ink = Ink::grey(level);
        for value in positions.0 {
            let at = frame.px(*value);
            canvas.line(&[(at, r.top), (at, r.bottom)], ink, Dash::Solid, 1.0);
        }
        for value in positions.1 {
            let at = frame.py(*value);
            canvas.line(&[(r.left, at), (r.right, at)], ink, Dash::Solid, 1.0);
        }
    }
}

fn labels(
    canvas: &mut Canvas,
    panel: &Panel,
    frame: &PlotFrame,
    x: &Ticks,
    y: &Ticks,
    left: f64,
) -> Result<(), PlotError> {
    let r = frame.rect;
    let number = face(SMALL, false, 60);
    let caption = face(SMALL + 1.0, false, 25);
    if panel.x.labelled {
        // A label that would run into its left neighbour (crowded categories) is left out.
        let mut free_from = f64::NEG_INFINITY;
        for (value, text) in &x.major {
            let (at, half) = (frame.px(*value), 0.5 * canvas.text_width(text, number)?);
            if at - half >= free_from {
                canvas.text(text, (at, r.bottom + 13.0), Anchor::Middle, number);
                free_from = at + half + 4.0;
            }
        }
        let middle = (0.5 * (r.left + r.right), r.bottom + 32.0);
        canvas.text(&panel.x.caption(), middle, Anchor::Middle, caption);
    }
    if panel.y.labelled {
        for (value, text) in &y.major {
            canvas.text(text, (r.left - 6.0, frame.py(*value)), Anchor::Right, number);
        }
    }
    let upright = Type { upright: true, ..caption };
    canvas.text(&panel.y.caption(), (left + 10.0, 0.5 * (r.top + r.bottom)), Anchor::Middle, upright);
    if !panel.title.is_empty() {
        let strip = if panel.marks.iter().any(|m| !m.label.is_empty()) { 30.0 } else { 0.0 };
        canvas.text(&panel.title, (r.left, r.top - strip - 11.0), Anchor::Left, face(SMALL + 1.0, true, 40));
    }
    Ok(())
}

/// Labels of vertical marks: spread along a strip above the panel, each led to its line.
fn mark_labels(canvas: &mut Canvas, panel: &Panel, frame: &PlotFrame) -> Result<(), PlotError> {
    let r = frame.rect;
    let small = face(SMALL - 1.0, false, 40);
    let mut marks: Vec<_> =
        panel.marks.iter().filter(|m| !m.label.is_empty() && frame.contains(frame.px(m.value), r.top)).collect();
    marks.sort_by(|a, b| a.value.total_cmp(&b.value));
    let wanted: Vec<f64> = marks.iter().map(|m| frame.px(m.value)).collect();
    let mut sizes = Vec::new();
    for mark in &marks {
        sizes.push(canvas.text_width(&mark.label, small)? + 8.0);
    }
    let places = spread(&wanted, &sizes, [r.left - 20.0, r.right + 16.0]);
    for ((mark, from), to) in marks.iter().zip(&wanted).zip(&places) {
        let ink: Ink = mark.color.into();
        canvas.line(&[(*from, r.top), (*to, r.top - 13.0)], ink, Dash::Solid, 0.8);
        canvas.text(&mark.label, (*to, r.top - 21.0), Anchor::Middle, Type { ink, ..small });
    }
    Ok(())
}

/// Labels of levels: in the right margin, spread upwards and downwards.
fn level_labels(canvas: &mut Canvas, panel: &Panel, frame: &PlotFrame) {
    let r = frame.rect;
    let mut levels: Vec<_> = panel.levels.iter().filter(|l| frame.contains(r.left, frame.py(l.value))).collect();
    levels.sort_by(|a, b| b.value.total_cmp(&a.value));
    let wanted: Vec<f64> = levels.iter().map(|l| frame.py(l.value)).collect();
    let places = spread(&wanted, &vec![13.0; levels.len()], [r.top - 6.0, r.bottom + 6.0]);
    for ((level, from), to) in levels.iter().zip(&wanted).zip(&places) {
        canvas.line(&[(r.right, *from), (r.right + 7.0, *to)], Ink::grey(90), Dash::Solid, 0.8);
        canvas.text(&level.label, (r.right + 10.0, *to), Anchor::Left, face(SMALL - 1.0, false, 40));
    }
}
