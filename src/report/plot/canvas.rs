//! The drawing surface: plotters' SVG backend behind lines, areas and text in pixels at report size.
//!
//! plotters rounds to whole pixels, which shows as stairs in a curve; the surface is therefore [`FINE`] times larger
//! than the picture and the SVG header scales it back. The backend knows no dash pattern: a dashed line is written with
//! an opacity reserved for its pattern, and [`finish`] replaces that opacity by the pattern.

use super::PlotError;
use super::style::{Color, Dash, Marker};
use plotters::coord::Shift;
use plotters::prelude::{
    Circle, DrawingArea, IntoDrawingArea, IntoFont, PathElement, Polygon, RGBAColor, SVGBackend, Text, TextStyle,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, FontStyle, FontTransform, ShapeStyle};

/// Subdivisions of a pixel.
pub(super) const FINE: f64 = 3.0;
/// plotters' font size is the line height; the em of its SVG output is smaller by this factor.
const LINE_PER_EM: f64 = 1.24;
const FONT: &str = "sans-serif";

/// Colour with opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ink {
    pub rgb: (u8, u8, u8),
    /// 1 is opaque.
    pub opacity: f64,
}

impl From<Color> for Ink {
    fn from(color: Color) -> Self {
        Self { rgb: color.rgb(), opacity: 1.0 }
    }
}

impl Ink {
    /// An opaque grey, 0 black to 255 white.
    pub(super) fn grey(level: u8) -> Self {
        Self { rgb: (level, level, level), opacity: 1.0 }
    }

    fn style(self, fill: bool, width_px: f64) -> ShapeStyle {
        let (r, g, b) = self.rgb;
        ShapeStyle {
            color: RGBAColor(r, g, b, self.opacity),
            filled: fill,
            stroke_width: (width_px * FINE).round().max(1.0) as u32,
        }
    }
}

/// Where a text sits relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Left,
    Middle,
    Right,
}

/// Size and weight of a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Type {
    /// Em, px at report size.
    pub size_px: f64,
    pub bold: bool,
    /// Turned a quarter, read from below.
    pub upright: bool,
    pub ink: Ink,
}

/// A drawing surface of a given size.
pub(super) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

impl<'a> Canvas<'a> {
    /// A white surface that writes into `buffer`.
    pub(super) fn new(buffer: &'a mut String, width_px: f64, height_px: f64) -> Result<Self, PlotError> {
        let faces = [(FontStyle::Normal, dejavu::sans::regular()), (FontStyle::Bold, dejavu::sans::bold())];
        for (style, bytes) in faces {
            plotters::style::register_font(FONT, style, bytes)
                .map_err(|_| PlotError::Drawing("the embedded font cannot be read".to_owned()))?;
        }
        let size = ((width_px * FINE).round() as u32, (height_px * FINE).round() as u32);
        let area = SVGBackend::with_string(buffer, size).into_drawing_area();
        area.fill(&plotters::style::WHITE).map_err(drawing)?;
        Ok(Self { area })
    }

    pub(super) fn line(&self, points: &[(f64, f64)], ink: Ink, dash: Dash, width_px: f64) -> Result<(), PlotError> {
        let mut path: Vec<(i32, i32)> = points.iter().map(|p| fine(p.0, p.1)).collect();
        // Points closer than the subdivision do not show and would only make the file larger.
        path.dedup();
        if path.len() < 2 {
            return Ok(());
        }
        let opacity = reserved_opacity(dash).unwrap_or(ink.opacity);
        let style = Ink { opacity, ..ink }.style(false, width_px);
        self.area.draw(&PathElement::new(path, style)).map_err(drawing)
    }

    pub(super) fn area(&self, corners: &[(f64, f64)], ink: Ink) -> Result<(), PlotError> {
        let mut path: Vec<(i32, i32)> = corners.iter().map(|p| fine(p.0, p.1)).collect();
        path.dedup();
        self.area.draw(&Polygon::new(path, ink.style(true, 1.0))).map_err(drawing)
    }

    /// A filled rectangle between two corners.
    pub(super) fn rectangle(&self, a: (f64, f64), b: (f64, f64), ink: Ink) -> Result<(), PlotError> {
        let ((x0, y0), (x1, y1)) = (fine(a.0, a.1), fine(b.0, b.1));
        let corners = [(x0.min(x1), y0.min(y1)), (x0.max(x1), y0.max(y1))];
        self.area.draw(&plotters::prelude::Rectangle::new(corners, ink.style(true, 1.0))).map_err(drawing)
    }

    /// A marker centred at `at`, with this half size.
    pub(super) fn marker(&self, at: (f64, f64), marker: Marker, ink: Ink, half_px: f64) -> Result<(), PlotError> {
        let (x, y) = at;
        let h = half_px;
        let stroke = 1.3;
        match marker {
            Marker::Circle | Marker::Disc => {
                let filled = marker == Marker::Disc;
                let radius = (h * FINE).round() as i32;
                let circle = Circle::new(fine(at.0, at.1), radius, ink.style(filled, stroke));
                self.area.draw(&circle).map_err(drawing)
            }
            Marker::Square => self.line(
                &[(x - h, y - h), (x + h, y - h), (x + h, y + h), (x - h, y + h), (x - h, y - h)],
                ink,
                Dash::Solid,
                stroke,
            ),
            Marker::Triangle => self.area(&[(x - h, y + h), (x + h, y + h), (x, y - h)], ink),
            Marker::Diamond => {
                let d = 1.25 * h;
                self.area(&[(x - d, y), (x, y - d), (x + d, y), (x, y + d)], ink)
            }
            Marker::Cross => {
                self.line(&[(x - h, y - h), (x + h, y + h)], ink, Dash::Solid, stroke)?;
                self.line(&[(x - h, y + h), (x + h, y - h)], ink, Dash::Solid, stroke)
            }
        }
    }

    /// A text, vertically centred on its point.
    pub(super) fn text(&self, text: &str, at: (f64, f64), anchor: Anchor, face: Type) -> Result<(), PlotError> {
        let horizontal = match anchor {
            Anchor::Left => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::Right => HPos::Right,
        };
        // Centred by hand: a viewer's reading of half an "ex" differs from font to font, the baseline does not.
        let drop = 0.36 * face.size_px;
        let (x, y) = at;
        let (at, vertical) = if face.upright { ((x + drop, y), VPos::Bottom) } else { ((x, y + drop), VPos::Bottom) };
        let transform = if face.upright { FontTransform::Rotate270 } else { FontTransform::None };
        let style = style(face).transform(transform).pos(Pos::new(horizontal, vertical));
        self.area.draw(&Text::new(text.to_owned(), fine(at.0, at.1), style)).map_err(drawing)
    }

    /// Width of a text, px at report size, from the metrics of the embedded font.
    pub(super) fn text_width(&self, text: &str, face: Type) -> Result<f64, PlotError> {
        let (width, _) = self.area.estimate_text_size(text, &style(face)).map_err(drawing)?;
        Ok(f64::from(width) / FINE)
    }

    pub(super) fn close(self) -> Result<(), PlotError> {
        self.area.present().map_err(drawing)
    }
}

/// Report-size header, title and description for readers without the picture, dash patterns, exact baselines.
pub(super) fn finish(svg: &str, width_px: f64, height_px: f64, title: &str, description: &str) -> String {
    let (fine_width, fine_height) = ((width_px * FINE).round(), (height_px * FINE).round());
    let header = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" width=\"{width_px}\" height=\"{height_px}\" \
         viewBox=\"0 0 {fine_width} {fine_height}\" stroke-linejoin=\"round\">\n<title>{}</title>\n<desc>{}</desc>\n",
        escape(title),
        escape(description)
    );
    let body = svg.split_once(">\n").map_or("", |(_, rest)| rest);
    let mut text = header + body;
    for dash in [Dash::Dashed, Dash::Dotted, Dash::DashDot] {
        if let (Some(opacity), Some(pattern)) = (reserved_opacity(dash), pattern(dash)) {
            text = text.replace(&format!("opacity=\"{opacity}\""), &format!("stroke-dasharray=\"{pattern}\""));
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

/// Pattern in subdivisions: three to a pixel.
fn pattern(dash: Dash) -> Option<&'static str> {
    match dash {
        Dash::Solid => None,
        Dash::Dashed => Some("21 10"),
        Dash::Dotted => Some("5 8"),
        Dash::DashDot => Some("24 8 5 8"),
    }
}

fn fine(x: f64, y: f64) -> (i32, i32) {
    ((x * FINE).round() as i32, (y * FINE).round() as i32)
}

pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn drawing<E: std::error::Error + Send + Sync>(error: plotters::drawing::DrawingAreaErrorKind<E>) -> PlotError {
    PlotError::Drawing(error.to_string())
}

/// Font, size and colour of a text.
fn style(face: Type) -> TextStyle<'static> {
    let (r, g, b) = face.ink.rgb;
    let weight = if face.bold { FontStyle::Bold } else { FontStyle::Normal };
    let font = (FONT, face.size_px * LINE_PER_EM * FINE).into_font().style(weight);
    let color = RGBAColor(r, g, b, face.ink.opacity).to_backend_color();
    TextStyle { color, ..TextStyle::from(font) }
}
