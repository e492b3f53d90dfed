//! Pictures: builders turn finished results into a [`Figure`], one renderer draws it, one table writes the same series.
//!
//! `builder(values) -> Figure`, then [`picture`] gives the SVG and the CSV of the same stem; PNG and PDF are drawn from
//! the same [`Drawing`]. plotters is used here only.

mod canvas;
mod draw;
pub mod figure;
mod frame;
mod pdf;
mod png;
mod render;
pub(crate) mod style;
mod svg;
mod table;
mod ticks;
mod typography;

pub(crate) mod animation;
pub mod diagnosis;
pub mod loops;
pub mod machining;
pub mod measured;
pub mod motion;
pub mod robustness;
pub mod shaft;
pub(crate) mod speed;
pub mod updating;
pub mod whirl;

pub use figure::{Axis, Figure, Panel, Series};
pub use render::Drawing;
pub use style::{Color, Dash, Look, Marker, Role};

/// Why a figure cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlotError {
    /// No panel.
    #[error("figure '{title}' has no panel")]
    Empty {
        /// Title of the figure.
        title: String,
    },
    /// Lists of one series differ in length.
    #[error("series '{series}': {x} abscissae, {y} ordinates; lower edge and error bars need as many")]
    Lengths {
        /// Name of the series.
        series: String,
        /// Number of abscissae.
        x: usize,
        /// Number of ordinates.
        y: usize,
    },
    /// An impossible axis range.
    #[error("axis '{axis}': range {low} to {high} must be finite, ascending, and positive on a log axis")]
    Range {
        /// Label of the axis.
        axis: String,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// The drawing backend failed.
    #[error("drawing failed: {0}")]
    Drawing(String),
}

impl PlotError {
    fn drawing(error: impl std::fmt::Display) -> Self {
        Self::Drawing(error.to_string())
    }
}

/// A drawn figure and the table of what it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// SVG text.
    pub svg: String,
    /// CSV text with the same series.
    pub csv: String,
    /// What other formats are drawn from; none for what moves.
    pub drawing: Option<Drawing>,
}

named! {
    /// A format of pictures beside the SVG that pages are made of, by the ending of its files.
    pub enum PictureFormat {
        /// Scalable vector graphics.
        Svg = "svg",
        /// Pixels, three for each one of the report.
        Png = "png",
        /// A page of the size of the picture: curves as vectors, texts as text in an embedded font.
        Pdf = "pdf",
    }
}

impl Drawing {
    /// The file of a format. Same drawing, same bytes.
    ///
    /// # Errors
    /// [`PlotError::Drawing`] when the backend fails.
    pub fn file(&self, format: PictureFormat) -> Result<Vec<u8>, PlotError> {
        match format {
            PictureFormat::Svg => Ok(svg::svg(self)?.into_bytes()),
            PictureFormat::Png => png::png(self),
            PictureFormat::Pdf => pdf::pdf(self),
        }
    }

    /// Puts the texts into other words.
    pub(crate) fn reword(&mut self, words: impl Fn(&str) -> String) {
        self.title = words(&self.title);
        self.description = words(&self.description);
        for shape in &mut self.shapes {
            if let canvas::Shape::Text { text, .. } = shape {
                *text = words(text);
            }
        }
    }
}

/// Draws a figure and writes its table. Same figure, same bytes.
///
/// # Errors
/// [`PlotError`] when the figure is inconsistent or the backend fails.
pub fn picture(figure: &Figure) -> Result<Picture, PlotError> {
    let drawing = render::draw(figure)?;
    Ok(Picture { svg: svg::svg(&drawing)?, csv: table::csv(figure), drawing: Some(drawing) })
}

/// One named curve as builders take it, of numbers or of a complex response.
#[derive(Clone, Copy, Debug)]
pub struct Curve<'a, T = f64> {
    /// Name in the legend and in the CSV.
    pub name: &'a str,
    /// What it stands for, hence how it looks.
    pub role: Role,
    /// Abscissae.
    pub x: &'a [f64],
    /// Ordinates, as many.
    pub y: &'a [T],
}

impl Curve<'_> {
    fn series(&self) -> Series {
        Series::curve(self.name, self.x, self.y, self.role.look())
    }

    /// The same with other ordinates.
    fn map_values(&self, to: impl Fn(f64) -> f64) -> Series {
        let y: Vec<f64> = self.y.iter().map(|y| to(*y)).collect();
        Series::curve(self.name, self.x, &y, self.role.look())
    }
}

impl Figure {
    /// Checks that every series has lists of one length.
    pub(crate) fn check(&self) -> Result<(), PlotError> {
        if self.panels.is_empty() {
            return Err(PlotError::Empty { title: self.title.clone() });
        }
        for s in self.panels.iter().flat_map(|p| &p.series) {
            let lower = match &s.shape {
                figure::SeriesShape::Band { lower } => lower.len(),
                _ => s.y.len(),
            };
            let error = s.y_error.as_ref().map_or(s.y.len(), Vec::len);
            if s.x.len() != s.y.len() || lower != s.y.len() || error != s.y.len() {
                return Err(PlotError::Lengths { series: s.name.clone(), x: s.x.len(), y: s.y.len() });
            }
        }
        Ok(())
    }
}
