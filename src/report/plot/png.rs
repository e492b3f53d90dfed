//! A drawing as PNG, by plotters' bitmap backend.
//!
//! The backend smooths texts only: it draws on a surface [`SUBPIXELS`] times as fine as the picture, of which every
//! pixel is the mean. Wide lines are drawn piece by piece with round joints, since its mitred ones leave spikes
//! where a curve turns sharply; dashes are cut here, since it knows none.

use super::PlotError;
use super::canvas::{DROP, FINE, Ink, STROKE, Shape, pattern, style};
use super::render::Drawing;
use flate2::{Compression, Crc, write::ZlibEncoder};
use plotters::prelude::{BitMapBackend, DrawingBackend, RGBAColor};
use plotters::style::text_anchor::{Pos, VPos};
use plotters::style::{FontTransform, ShapeStyle};
use std::io::Write;

/// Pixels of the picture for one of the report: 288 dpi where the report has 96.
const SCALE: usize = 3;
/// Subdivisions of a pixel of the picture in each direction.
const SUBPIXELS: usize = 2;
/// Subdivisions of a pixel of the report.
const FINEST: f64 = (SCALE * SUBPIXELS) as f64;

pub(super) fn png(drawing: &Drawing) -> Result<Vec<u8>, PlotError> {
    let [width, height] = [drawing.width_px, drawing.height_px].map(|px| px.ceil() as usize * SCALE);
    let mut surface = vec![u8::MAX; 3 * width * height * SUBPIXELS * SUBPIXELS];
    let size = ((width * SUBPIXELS) as u32, (height * SUBPIXELS) as u32);
    let mut backend = BitMapBackend::with_buffer(&mut surface, size);
    drawing.shapes.iter().try_for_each(|shape| draw(&mut backend, shape))?;
    drop(backend);
    file(&average(&surface, width), width, height)
}

/// The file of three bytes a pixel (ISO/IEC 15948): header, resolution, rows without filter, end.
fn file(pixels: &[u8], width: usize, height: usize) -> Result<Vec<u8>, PlotError> {
    const EIGHT_BIT_COLOURS: [u8; 5] = [8, 2, 0, 0, 0];
    const METRE: u8 = 1;
    let [width_bytes, height_bytes] = [width, height].map(|size| (size as u32).to_be_bytes());
    let resolution = [&PER_METRE.to_be_bytes()[..], &PER_METRE.to_be_bytes(), &[METRE]].concat();
    let rows: Vec<u8> = pixels.chunks(3 * width).flat_map(|row| [&[0], row].concat()).collect();
    let chunks = [
        (b"IHDR", [&width_bytes[..], &height_bytes, &EIGHT_BIT_COLOURS].concat()),
        (b"pHYs", resolution),
        (b"IDAT", compress(&rows)?),
        (b"IEND", vec![]),
    ];
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    for (kind, data) in chunks {
        let mut sum = Crc::new();
        sum.update(kind);
        sum.update(&data);
        file.extend((data.len() as u32).to_be_bytes());
        file.extend(kind.iter().chain(&data).chain(&sum.sum().to_be_bytes()));
    }
    Ok(file)
}

pub(super) fn compress(bytes: &[u8]) -> Result<Vec<u8>, PlotError> {
    let mut encoder = ZlibEncoder::new(vec![], Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).map_err(PlotError::drawing)
}

/// Ascent and descent of DejaVu Sans over its em (`hhea` table), the size by which the backend scales it.
const LINE_PER_EM: f64 = 1.164;
/// Pixels a metre: 96 an inch of 25.4 mm, times [`SCALE`].
const PER_METRE: u32 = 11_339;

fn draw(backend: &mut BitMapBackend, shape: &Shape) -> Result<(), PlotError> {
    match shape {
        Shape::Line { points, ink, dash, width_px } => {
            let lengths: Vec<f64> = pattern(*dash).iter().map(|third| f64::from(*third) / FINE).collect();
            return dashes(points, &lengths).iter().try_for_each(|piece| line(backend, piece, *ink, *width_px));
        }
        Shape::Area { corners, ink } => backend.fill_polygon(corners.iter().copied().map(finest), &fill(*ink)),
        Shape::Rectangle { corners, ink } => {
            let [(x0, y0), (x1, y1)] = corners.map(finest);
            backend.draw_rect((x0.min(x1), y0.min(y1)), (x0.max(x1), y0.max(y1)), &fill(*ink), true)
        }
        Shape::Circle { centre, radius_px, ink, is_filled } => {
            let radius = (radius_px * FINEST).round() as u32;
            backend.draw_circle(finest(*centre), radius, &stroke(*ink, STROKE), *is_filled)
        }
        Shape::Text { text, at: (x, y), anchor, face } => {
            // The backend draws the baseline half a line below the point.
            let shift = (DROP - 0.5 * LINE_PER_EM) * face.size_px;
            let (at, transform) = if face.upright {
                ((x + shift, *y), FontTransform::Rotate270)
            } else {
                ((*x, y + shift), FontTransform::None)
            };
            let style = style(*face, face.size_px * LINE_PER_EM * FINEST);
            backend.draw_text(
                text,
                &style.transform(transform).pos(Pos::new(anchor.horizontal(), VPos::Top)),
                finest(at),
            )
        }
    }
    .map_err(PlotError::drawing)
}

/// A line with round joints.
fn line(backend: &mut BitMapBackend, points: &[(f64, f64)], ink: Ink, width_px: f64) -> Result<(), PlotError> {
    let mut path: Vec<(i32, i32)> = points.iter().copied().map(finest).collect();
    path.dedup();
    let style = stroke(ink, width_px);
    for pair in path.windows(2) {
        backend.draw_line(pair[0], pair[1], &style).map_err(PlotError::drawing)?;
    }
    let joints = path.get(1..path.len().saturating_sub(1)).unwrap_or_default();
    let mut joint = |at: &(i32, i32)| backend.draw_circle(*at, style.stroke_width / 2, &fill(ink), true);
    joints.iter().try_for_each(|at| joint(at).map_err(PlotError::drawing))
}

/// The pieces of a line that a pattern of lengths of line and gap, px, leaves; the whole line without a pattern.
fn dashes(points: &[(f64, f64)], lengths: &[f64]) -> Vec<Vec<(f64, f64)>> {
    let Some(first) = lengths.first() else {
        return vec![points.to_vec()];
    };
    let mut pieces = vec![points.first().copied().into_iter().collect::<Vec<_>>()];
    let (mut next, mut left) = (0, *first);
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        let length = (x1 - x0).hypot(y1 - y0);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let at = (x0 + (x1 - x0) * done / length, y0 + (y1 - y0) * done / length);
            if next % 2 == 0 {
                pieces.last_mut().into_iter().for_each(|piece| piece.push(at));
            } else {
                pieces.push(vec![at]);
            }
            next += 1;
            left = lengths[next % lengths.len()];
        }
        left -= length - done;
        if next % 2 == 0 {
            pieces.last_mut().into_iter().for_each(|piece| piece.push((x1, y1)));
        }
    }
    pieces
}

/// Every pixel as the mean of its subdivisions.
fn average(surface: &[u8], width: usize) -> Vec<u8> {
    let row = 3 * width * SUBPIXELS;
    let mean = |rows: &[u8], at: usize, colour: usize| {
        let places = (0..SUBPIXELS * SUBPIXELS).map(|k| k / SUBPIXELS * row + 3 * (at * SUBPIXELS + k % SUBPIXELS));
        let sum: usize = places.map(|place| usize::from(rows[place + colour])).sum();
        ((sum + SUBPIXELS * SUBPIXELS / 2) / (SUBPIXELS * SUBPIXELS)) as u8
    };
    let rows = surface.chunks_exact(row * SUBPIXELS);
    rows.flat_map(|rows| (0..3 * width).map(move |k| mean(rows, k / 3, k % 3))).collect()
}

fn stroke(ink: Ink, width_px: f64) -> ShapeStyle {
    let (r, g, b) = ink.rgb;
    let stroke_width = (width_px * FINEST).round().max(1.0) as u32;
    ShapeStyle { color: RGBAColor(r, g, b, ink.opacity), filled: false, stroke_width }
}

fn fill(ink: Ink) -> ShapeStyle {
    ShapeStyle { filled: true, ..stroke(ink, 1.0) }
}

fn finest(at: (f64, f64)) -> (i32, i32) {
    let (x, y) = at;
    ((x * FINEST).round() as i32, (y * FINEST).round() as i32)
}
