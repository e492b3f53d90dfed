//! The drawing surface: lines, areas, circles and texts in pixels at report size, recorded so that every format draws
//! the same.

use super::PlotError;
use super::style::{Color, Dash, Marker};
use plotters::prelude::{FontDesc, FontFamily, RGBAColor, TextStyle};
use plotters::style::text_anchor::HPos;
use plotters::style::{Color as _, FontStyle};

const FONT: &str = "sans-serif";
/// Subdivisions of a pixel in the SVG, at which texts are measured.
pub(super) const FINE: f64 = 3.0;
/// plotters' font size is the line height; the em of its SVG is smaller by this factor.
const LINE_PER_EM: f64 = 1.24;
/// A text is centred on its height by this share of its em: a viewer's reading of half an "ex" differs from font to
/// font, the baseline does not.
pub(super) const DROP: f64 = 0.36;

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
}

/// Where a text sits relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Left,
    Middle,
    Right,
}

impl Anchor {
    pub(super) fn horizontal(self) -> HPos {
        match self {
            Self::Left => HPos::Left,
            Self::Middle => HPos::Center,
            Self::Right => HPos::Right,
        }
    }
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

/// Anything that is drawn.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    Line {
        points: Vec<(f64, f64)>,
        ink: Ink,
        dash: Dash,
        width_px: f64,
    },
    Area {
        corners: Vec<(f64, f64)>,
        ink: Ink,
    },
    /// A filled rectangle between two corners.
    Rectangle {
        corners: [(f64, f64); 2],
        ink: Ink,
    },
    Circle {
        centre: (f64, f64),
        radius_px: f64,
        ink: Ink,
        is_filled: bool,
    },
    /// A text, vertically centred on its point.
    Text {
        text: String,
        at: (f64, f64),
        anchor: Anchor,
        face: Type,
    },
}

impl Shape {
    pub(super) fn ink(&self) -> Ink {
        match self {
            Self::Line { ink, .. }
            | Self::Area { ink, .. }
            | Self::Rectangle { ink, .. }
            | Self::Circle { ink, .. } => *ink,
            Self::Text { face, .. } => face.ink,
        }
    }
}

/// Line width of open markers, px.
pub(super) const STROKE: f64 = 1.3;

/// A drawing surface.
pub(super) struct Canvas {
    pub shapes: Vec<Shape>,
}

impl Canvas {
    /// An empty white surface; the embedded font stands ready to measure texts.
    pub(super) fn new() -> Result<Self, PlotError> {
        let faces = [(FontStyle::Normal, dejavu::sans::regular()), (FontStyle::Bold, dejavu::sans::bold())];
        for (style, bytes) in faces {
            plotters::style::register_font(FONT, style, bytes)
                .map_err(|_| PlotError::Drawing("the embedded font cannot be read".to_owned()))?;
        }
        Ok(Self { shapes: vec![] })
    }

    pub(super) fn line(&mut self, points: &[(f64, f64)], ink: Ink, dash: Dash, width_px: f64) {
        self.shapes.push(Shape::Line { points: points.to_vec(), ink, dash, width_px });
    }

    pub(super) fn area(&mut self, corners: &[(f64, f64)], ink: Ink) {
        self.shapes.push(Shape::Area { corners: corners.to_vec(), ink });
    }

    /// A filled rectangle between two corners.
    pub(super) fn rectangle(&mut self, a: (f64, f64), b: (f64, f64), ink: Ink) {
        self.shapes.push(Shape::Rectangle { corners: [a, b], ink });
    }

    /// A marker centred at `at`, with this half size.
    pub(super) fn marker(&mut self, at: (f64, f64), marker: Marker, ink: Ink, half_px: f64) {
        let (x, y) = at;
        let h = half_px;
        match marker {
            Marker::Circle | Marker::Disc => {
                let is_filled = marker == Marker::Disc;
                self.shapes.push(Shape::Circle { centre: at, radius_px: h, ink, is_filled });
            }
            Marker::Square => {
                let corners = [(x - h, y - h), (x + h, y - h), (x + h, y + h), (x - h, y + h), (x - h, y - h)];
                self.line(&corners, ink, Dash::Solid, STROKE);
            }
            Marker::Triangle => self.area(&[(x - h, y + h), (x + h, y + h), (x, y - h)], ink),
            Marker::Diamond => {
                let d = 1.25 * h;
                self.area(&[(x - d, y), (x, y - d), (x + d, y), (x, y + d)], ink);
            }
            Marker::Cross => {
                self.line(&[(x - h, y - h), (x + h, y + h)], ink, Dash::Solid, STROKE);
                self.line(&[(x - h, y + h), (x + h, y - h)], ink, Dash::Solid, STROKE);
            }
        }
    }

    /// A text, vertically centred on its point.
    pub(super) fn text(&mut self, text: &str, at: (f64, f64), anchor: Anchor, face: Type) {
        self.shapes.push(Shape::Text { text: text.to_owned(), at, anchor, face });
    }

    /// Width of a text, px at report size, from the metrics of the embedded font.
    pub(super) fn text_width(&self, text: &str, face: Type) -> Result<f64, PlotError> {
        let font = style(face, fine_line(face)).font;
        let ((from, _), (to, _)) = font.layout_box(text).map_err(PlotError::drawing)?;
        Ok(f64::from(to - from) / FINE)
    }
}

/// Pattern of a dash: lengths of line and gap in turn, in thirds of a pixel.
pub(super) fn pattern(dash: Dash) -> &'static [u8] {
    match dash {
        Dash::Solid => &[],
        Dash::Dashed => &[21, 10],
        Dash::Dotted => &[5, 8],
        Dash::DashDot => &[24, 8, 5, 8],
    }
}

/// Height of a line of the SVG in its subdivisions.
pub(super) fn fine_line(face: Type) -> f64 {
    face.size_px * LINE_PER_EM * FINE
}

/// Weight and colour of a text, with the size that plotters knows: the height of a line, subdivisions of a pixel.
pub(super) fn style(face: Type, line: f64) -> TextStyle<'static> {
    let (r, g, b) = face.ink.rgb;
    let weight = if face.bold { FontStyle::Bold } else { FontStyle::Normal };
    let font = FontDesc::new(FontFamily::Name(FONT), line, weight);
    let color = RGBAColor(r, g, b, face.ink.opacity).to_backend_color();
    TextStyle { color, ..TextStyle::from(font) }
}
