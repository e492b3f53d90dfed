//! What stands in a panel: series of every shape, the heat map with its colour bar, and the legend that explains them.

use super::PlotError;
use super::canvas::{Anchor, Canvas, Ink};
use super::figure::{Figure, HeatMap, Series, SeriesShape};
use super::frame::{PlotFrame, Rect};
use super::style::{Color, Dash, Look};
use super::ticks::ticks;
use super::typography::face;

/// Half size of a marker, px.
const MARKER: f64 = 3.4;
/// Length of a legend sample, px.
const SAMPLE: f64 = 30.0;
/// Opacity of a band: grid and lines stay visible through it.
const BAND: f64 = 0.22;

pub(super) fn series(canvas: &mut Canvas, frame: &PlotFrame, series: &Series) {
    let ink: Ink = series.look.color.into();
    match &series.shape {
        SeriesShape::Curve => curve(canvas, frame, series, ink),
        SeriesShape::Band { lower } => band(canvas, frame, series, lower, ink),
        SeriesShape::Bars { width } => {
            let zero = frame.clamp(frame.rect.left, frame.py(0.0).min(frame.rect.bottom)).1;
            for (x, y) in series.x.iter().zip(&series.y) {
                if let (Some(a), Some(b)) = (frame.point(x - 0.5 * width, *y), frame.point(x + 0.5 * width, *y)) {
                    canvas.rectangle(frame.clamp(a.0, a.1), frame.clamp(b.0, zero), ink);
                }
            }
            error_bars(canvas, frame, series);
        }
        SeriesShape::LyingBars { height } => {
            let zero = frame.clamp(frame.px(0.0).max(frame.rect.left), frame.rect.top).0;
            for (x, y) in series.x.iter().zip(&series.y) {
                if let (Some(a), Some(b)) = (frame.point(*x, y - 0.5 * height), frame.point(*x, y + 0.5 * height)) {
                    canvas.rectangle(frame.clamp(a.0, a.1), frame.clamp(zero, b.1), ink);
                }
            }
        }
    }
}

fn curve(canvas: &mut Canvas, frame: &PlotFrame, series: &Series, ink: Ink) {
    if let Some(dash) = series.look.line {
        let mut path: Vec<Option<(f64, f64)>> = Vec::with_capacity(series.x.len());
        let mut last = f64::NAN;
        for (x, y) in series.x.iter().zip(&series.y) {
            if series.break_at_jump.is_some_and(|jump| (y - last).abs() > jump) {
                path.push(None);
            }
            path.push(frame.point(*x, *y));
            last = *y;
        }
        for piece in frame.clip_points(path) {
            canvas.line(&piece, ink, dash, series.look.width_px);
        }
    }
    error_bars(canvas, frame, series);
    if let Some(marker) = series.look.marker {
        for at in series.x.iter().zip(&series.y).filter_map(|(x, y)| frame.point(*x, *y)) {
            if frame.contains(at.0, at.1) {
                canvas.marker(at, marker, ink, MARKER);
            }
        }
    }
}

fn error_bars(canvas: &mut Canvas, frame: &PlotFrame, series: &Series) {
    let Some(error) = &series.y_error else {
        return;
    };
    for ((x, y), e) in series.x.iter().zip(&series.y).zip(error) {
        if let (Some(low), Some(high)) = (frame.point(*x, y - e), frame.point(*x, y + e)) {
            let (low, high) = (frame.clamp(low.0, low.1), frame.clamp(high.0, high.1));
            let ink = Ink::grey(40);
            canvas.line(&[low, high], ink, Dash::Solid, 1.1);
            for end in [low, high] {
                canvas.line(&[(end.0 - 3.0, end.1), (end.0 + 3.0, end.1)], ink, Dash::Solid, 1.1);
            }
        }
    }
}

fn band(canvas: &mut Canvas, frame: &PlotFrame, series: &Series, lower: &[f64], ink: Ink) {
    let ink = Ink { opacity: BAND, ..ink };
    // A gap in either edge splits the area.
    let mut upper_edge: Vec<(f64, f64)> = Vec::new();
    let mut lower_edge: Vec<(f64, f64)> = Vec::new();
    let mut flush = |upper: &mut Vec<(f64, f64)>, lower: &mut Vec<(f64, f64)>| {
        let corners: Vec<(f64, f64)> = upper.drain(..).chain(lower.drain(..).rev()).collect();
        if corners.len() >= 4 {
            canvas.area(&corners, ink);
        }
    };
    for ((x, y), low) in series.x.iter().zip(&series.y).zip(lower) {
        match (frame.point(*x, *y), frame.point(*x, *low)) {
            (Some(a), Some(b)) => {
                upper_edge.push(frame.clamp(a.0, a.1));
                lower_edge.push(frame.clamp(b.0, b.1));
            }
            _ => flush(&mut upper_edge, &mut lower_edge),
        }
    }
    flush(&mut upper_edge, &mut lower_edge);
}

/// Light to dark in one hue: order survives printing in grey and every kind of colour vision.
fn shade_ink(fraction: f64) -> Ink {
    const STOPS: [(f64, f64, f64); 5] =
        [(247.0, 250.0, 253.0), (198.0, 219.0, 239.0), (107.0, 174.0, 214.0), (33.0, 113.0, 181.0), (8.0, 38.0, 87.0)];
    if fraction.is_nan() {
        return Ink::grey(255);
    }
    let place = fraction.clamp(0.0, 1.0) * 4.0;
    let k = (place.floor() as usize).min(3);
    let (a, b) = (STOPS[k], STOPS[k + 1]);
    let mix = |a: f64, b: f64| (a + (place - k as f64) * (b - a)).round() as u8;
    Ink { rgb: (mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2)), opacity: 1.0 }
}

/// Draws the map and its colour bar. Neighbours of one shade become one rectangle.
pub(super) fn heat_map(canvas: &mut Canvas, frame: &PlotFrame, heat: &HeatMap) {
    // Steps of the shade the eye cannot tell apart keep the file small.
    const SHADES: f64 = 48.0;
    let [low, high] = heat.range;
    let quantise = |v: f64| ((v - low) / (high - low) * SHADES).round().clamp(0.0, SHADES) / SHADES;
    for (row, values) in heat.values.iter().enumerate() {
        let (top, bottom) = (frame.py(row as f64 + 0.5), frame.py(row as f64 - 0.5));
        let mut cells = values.iter().zip(heat.x_edges.windows(2)).peekable();
        while let Some((value, edges)) = cells.next() {
            let (shade_here, start, mut end) = (quantise(*value), edges[0], edges[1]);
            while let Some((_, more)) = cells.next_if(|(v, _)| quantise(**v) == shade_here) {
                end = more[1];
            }
            // Half a pixel of overlap hides the seams that anti-aliasing would show between neighbours.
            let (a, b) = (frame.clamp(frame.px(start), top), frame.clamp(frame.px(end) + 0.5, bottom + 0.5));
            canvas.rectangle(a, b, shade_ink(shade_here));
        }
    }
    let r = frame.rect;
    let bar = Rect { left: r.right + 16.0, right: r.right + 28.0, ..r };
    let height = (bar.bottom - bar.top) / SHADES;
    for k in 0..SHADES as usize {
        let bottom = bar.bottom - height * k as f64;
        let ink = shade_ink((k as f64 + 0.5) / SHADES);
        canvas.rectangle((bar.left, bottom - height - 0.4), (bar.right, bottom), ink);
    }
    let room = ((r.bottom - r.top) / 30.0).clamp(2.0, 8.0) as usize;
    for (value, text) in ticks(super::figure::Scale::Linear, heat.range, room, None).major {
        let y = bar.bottom - (value - low) / (high - low) * (bar.bottom - bar.top);
        canvas.line(&[(bar.right, y), (bar.right + 4.0, y)], Ink::grey(90), Dash::Solid, 1.0);
        canvas.text(&text, (bar.right + 7.0, y), Anchor::Left, face(11.0, false, 60));
    }
    let upright = super::canvas::Type { upright: true, ..face(12.0, false, 25) };
    canvas.text(&heat.label, (r.right + 80.0, 0.5 * (r.top + r.bottom)), Anchor::Middle, upright);
}

/// A line of the legend: what the sample shows, and its name.
pub(super) struct LegendEntry {
    name: String,
    sample: LegendSample,
}

enum LegendSample {
    Curve(Look),
    Area(Color, f64),
    Upright(Color, Dash),
}

/// Every listed series and mark of the figure once, in order of appearance.
pub(super) fn legend_entries(figure: &Figure) -> Vec<LegendEntry> {
    let mut entries: Vec<LegendEntry> = Vec::new();
    let mut add = |name: &str, sample: LegendSample| {
        if !name.is_empty() && entries.iter().all(|e| e.name != name) {
            entries.push(LegendEntry { name: name.to_owned(), sample });
        }
    };
    for panel in &figure.panels {
        for series in panel.series.iter().filter(|s| s.in_legend) {
            let sample = match series.shape {
                SeriesShape::Curve => LegendSample::Curve(series.look),
                SeriesShape::Band { .. } => LegendSample::Area(series.look.color, BAND),
                _ => LegendSample::Area(series.look.color, 1.0),
            };
            add(&series.name, sample);
        }
        for mark in &panel.marks {
            add(&mark.legend, LegendSample::Upright(mark.color, mark.dash));
        }
    }
    entries
}

/// The legend broken into rows no wider than `width`: for each row, entries with their offsets.
pub(super) fn legend_rows(
    canvas: &Canvas,
    entries: &[LegendEntry],
    width: f64,
) -> Result<Vec<Vec<(usize, f64)>>, PlotError> {
    let mut rows: Vec<Vec<(usize, f64)>> = Vec::new();
    let mut at = f64::INFINITY;
    for (k, entry) in entries.iter().enumerate() {
        let length = SAMPLE + 6.0 + canvas.text_width(&entry.name, face(12.5, false, 25))?;
        if at + length > width {
            rows.push(Vec::new());
            at = 0.0;
        }
        if let Some(row) = rows.last_mut() {
            row.push((k, at));
        }
        at += length + 16.0;
    }
    Ok(rows)
}

pub(super) fn legend_row(canvas: &mut Canvas, entries: &[LegendEntry], row: &[(usize, f64)], left: f64, y: f64) {
    for (k, offset) in row {
        let entry = &entries[*k];
        let (start, end) = (left + offset, left + offset + SAMPLE);
        match entry.sample {
            LegendSample::Curve(look) => {
                if let Some(dash) = look.line {
                    canvas.line(&[(start, y), (end, y)], look.color.into(), dash, look.width_px);
                }
                if let Some(marker) = look.marker {
                    canvas.marker((0.5 * (start + end), y), marker, look.color.into(), MARKER);
                }
            }
            LegendSample::Area(color, opacity) => {
                let ink = Ink { opacity, ..color.into() };
                canvas.rectangle((start + 6.0, y - 5.0), (end - 2.0, y + 5.0), ink);
            }
            LegendSample::Upright(color, dash) => {
                let middle = 0.5 * (start + end);
                canvas.line(&[(middle, y - 8.0), (middle, y + 8.0)], color.into(), dash, 1.3);
            }
        }
        canvas.text(&entry.name, (end + 6.0, y), Anchor::Left, face(12.5, false, 25));
    }
}
