//! A drawing as SVG, by plotters' backend.
//!
//! plotters rounds to whole pixels, which shows as stairs in a curve; the surface is therefore [`FINE`] times larger
//! than the picture and the SVG header scales it back. The backend knows no dash pattern: a dashed line is written with
//! an opacity reserved for its pattern, and [`finish`] replaces that opacity by the pattern.

use super::PlotError;
use super::canvas::{DROP, FINE, Ink, STROKE, Shape, fine_line, pattern, style};
use super::render::Drawing;
use super::style::Dash;
use plotters::coord::Shift;
use plotters::prelude::{
    Circle, DrawingArea, IntoDrawingArea, PathElement, Polygon, RGBAColor, Rectangle, SVGBackend, Text,
};
use plotters::style::text_anchor::{Pos, VPos};
use plotters::style::{FontTransform, ShapeStyle};

pub(super) fn svg(drawing: &Drawing) -> Result<String, PlotError> {
    let mut buffer = String::new();
    let size = ((drawing.width_px * FINE).round() as u32, (drawing.height_px * FINE).round() as u32);
    let area = SVGBackend::with_string(&mut buffer, size).into_drawing_area();
    area.fill(&plotters::style::WHITE).map_err(PlotError::drawing)?;
    drawing.shapes.iter().try_for_each(|shape| draw(&area, shape))?;
    area.present().map_err(PlotError::drawing)?;
    drop(area);
    Ok(finish(&buffer, drawing))
}

fn draw(area: &DrawingArea<SVGBackend, Shift>, shape: &Shape) -> Result<(), PlotError> {
    match shape {
        Shape::Line { points, ink, dash, width_px } => {
            let path = fine_path(points);
            if path.len() < 2 {
                return Ok(());
            }
            let opacity = reserved_opacity(*dash).unwrap_or(ink.opacity);
            area.draw(&PathElement::new(path, shape_style(Ink { opacity, ..*ink }, false, *width_px)))
        }
        Shape::Area { corners, ink } => area.draw(&Polygon::new(fine_path(corners), shape_style(*ink, true, 1.0))),
        Shape::Rectangle { corners, ink } => {
            let [(x0, y0), (x1, y1)] = corners.map(fine);
            let corners = [(x0.min(x1), y0.min(y1)), (x0.max(x1), y0.max(y1))];
            area.draw(&Rectangle::new(corners, shape_style(*ink, true, 1.0)))
        }
        Shape::Circle { centre, radius_px, ink, is_filled } => {
            let radius = (radius_px * FINE).round() as i32;
            area.draw(&Circle::new(fine(*centre), radius, shape_style(*ink, *is_filled, STROKE)))
        }
        Shape::Text { text, at: (x, y), anchor, face } => {
            let drop = DROP * face.size_px;
            let (at, transform) = if face.upright {
                ((x + drop, *y), FontTransform::Rotate270)
            } else {
                ((*x, y + drop), FontTransform::None)
            };
            let style =
                style(*face, fine_line(*face)).transform(transform).pos(Pos::new(anchor.horizontal(), VPos::Bottom));
            area.draw(&Text::new(text.clone(), fine(at), style))
        }
    }
    .map_err(PlotError::drawing)
}

/// Report-size header, title and description for readers without the picture, axes from which a page reads values at
/// the pointer, dash patterns, exact baselines.
fn finish(svg: &str, drawing: &Drawing) -> String {
    let Drawing { width_px, height_px, .. } = drawing;
    let (fine_width, fine_height) = ((width_px * FINE).round(), (height_px * FINE).round());
    let header = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" width=\"{width_px}\" height=\"{height_px}\" \
         viewBox=\"0 0 {fine_width} {fine_height}\" stroke-linejoin=\"round\">\n<title>{}</title>\n<desc>{}</desc>\n\
         <metadata>{}</metadata>\n",
        escape(&drawing.title),
        escape(&drawing.description),
        escape(&drawing.axes)
    );
    let body = svg.split_once(">\n").map_or("", |(_, rest)| rest);
    let mut text = header + body;
    for dash in [Dash::Dashed, Dash::Dotted, Dash::DashDot] {
        if let Some(opacity) = reserved_opacity(dash) {
            let lengths: Vec<String> = pattern(dash).iter().map(u8::to_string).collect();
            let pattern = format!("stroke-dasharray=\"{}\"", lengths.join(" "));
            text = text.replace(&format!("opacity=\"{opacity}\""), &pattern);
        }
    }
    text.replace("opacity=\"1\" ", "").replace(" dy=\"-0.5ex\"", "").replace(" \"/>", "\"/>")
}

/// Opacities no ink uses, exact in binary, that stand for a dash pattern until [`finish`].
fn reserved_opacity(dash: Dash) -> Option<f64> {
    match dash {
        Dash::Solid => None,
        Dash::Dashed => Some(0.984375),
        Dash::Dotted => Some(0.96875),
        Dash::DashDot => Some(0.953125),
    }
}

fn shape_style(ink: Ink, filled: bool, width_px: f64) -> ShapeStyle {
    let (r, g, b) = ink.rgb;
    let stroke_width = (width_px * FINE).round().max(1.0) as u32;
    ShapeStyle { color: RGBAColor(r, g, b, ink.opacity), filled, stroke_width }
}

fn fine(at: (f64, f64)) -> (i32, i32) {
    let (x, y) = at;
    ((x * FINE).round() as i32, (y * FINE).round() as i32)
}

/// Points closer than the subdivision do not show and would only make the file larger.
fn fine_path(points: &[(f64, f64)]) -> Vec<(i32, i32)> {
    let mut path: Vec<(i32, i32)> = points.iter().copied().map(fine).collect();
    path.dedup();
    path
}

pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
