//! A figure as data: panels with axes, series, reference lines. Builders make these, one renderer draws them.
//!
//! Nothing here knows pixels except the sizes the builder asks for, and nothing computes: values arrive in the unit of
//! their axis. Limits: one y axis a panel; a log axis shows positive values only (others are gaps).

use super::style::{Color, Dash, Look};

/// How an axis maps its values to length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences take equal length.
    Linear,
    /// Equal ratios take equal length; values must be positive.
    Log,
}

/// One axis of a panel.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What is plotted, in words: `Frequency`.
    pub label: String,
    /// Its unit as printed: `Hz`, `N/µm`, empty for a pure number.
    pub unit: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Fixed range; `None` takes it from the data.
    pub range: Option<[f64; 2]>,
    /// Fixed distance of the labelled ticks of a linear axis (90 for a phase).
    pub tick_step: Option<f64>,
    /// Names for the positions 0, 1, 2, … of a linear axis; empty for a numeric one.
    pub categories: Vec<String>,
    /// Whether numbers and label are printed (the upper of two stacked panels leaves them to the lower).
    pub labelled: bool,
}

impl Axis {
    fn new(label: &str, unit: &str, scale: Scale) -> Self {
        Self {
            label: label.to_owned(),
            unit: unit.to_owned(),
            scale,
            range: None,
            tick_step: None,
            categories: Vec::new(),
            labelled: true,
        }
    }

    /// A linear axis.
    pub fn linear(label: &str, unit: &str) -> Self {
        Self::new(label, unit, Scale::Linear)
    }

    /// A logarithmic axis.
    pub fn log(label: &str, unit: &str) -> Self {
        Self::new(label, unit, Scale::Log)
    }

    /// A linear axis whose positions 0, 1, 2, … carry names.
    pub(crate) fn categories(label: &str, names: Vec<String>) -> Self {
        let last = names.len() as f64 - 0.5;
        Self { categories: names, range: Some([-0.5, last]), ..Self::linear(label, "") }
    }

    /// The same axis with a fixed range.
    pub(crate) fn with_range(self, low: f64, high: f64) -> Self {
        Self { range: Some([low, high]), ..self }
    }

    /// The same axis with a fixed tick distance.
    pub(crate) fn with_step(self, step: f64) -> Self {
        Self { tick_step: Some(step), ..self }
    }

    /// Label with its unit, as printed beside the axis.
    pub(crate) fn caption(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} ({})", self.label, self.unit) }
    }
}

/// What is drawn at the points of a series.
#[derive(Clone, Debug, PartialEq)]
pub enum SeriesShape {
    /// A line and/or markers, as the look says.
    Curve,
    /// The area between these lower values and the series' y.
    Band {
        /// Lower edge, as long as y.
        lower: Vec<f64>,
    },
    /// Upright bars from the axis (or from 0) to y, this wide in units of x.
    Bars {
        /// Width in units of the x axis.
        width: f64,
    },
    /// Lying bars from 0 to x, this high in units of y.
    LyingBars {
        /// Height in units of the y axis.
        height: f64,
    },
}

/// One named set of points.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend and in the CSV.
    pub name: String,
    /// Abscissae; not a number is a gap.
    pub x: Vec<f64>,
    /// Ordinates; not a number is a gap.
    pub y: Vec<f64>,
    /// Half length of the error bars, as long as y.
    pub y_error: Option<Vec<f64>>,
    /// What is drawn.
    pub shape: SeriesShape,
    /// Colour, dash, marker.
    pub look: Look,
    /// Whether the legend lists it.
    pub in_legend: bool,
    /// The line is interrupted where y jumps by more than this (wrapped phases).
    pub break_at_jump: Option<f64>,
}

impl Series {
    /// A line and/or markers through the points.
    pub fn curve(name: &str, x: &[f64], y: &[f64], look: Look) -> Self {
        Self {
            name: name.to_owned(),
            x: x.to_vec(),
            y: y.to_vec(),
            y_error: None,
            shape: SeriesShape::Curve,
            look,
            in_legend: true,
            break_at_jump: None,
        }
    }

    /// The same of points.
    pub(crate) fn of_points(name: &str, points: impl IntoIterator<Item = (f64, f64)>, look: Look) -> Self {
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        Self::curve(name, &x, &y, look)
    }

    /// Bars at 0, 1, 2, …: those of group member `number` of `members`, which share that part of a unit.
    pub(super) fn grouped_bars(name: &str, y: &[f64], look: Look, [number, members]: [usize; 2], share: f64) -> Self {
        let width = share / members.max(1) as f64;
        let centre = (number as f64 + 0.5) * width - 0.5 * share;
        let x: Vec<f64> = (0..y.len()).map(|k| k as f64 + centre).collect();
        Self::curve(name, &x, y, look).with_shape(SeriesShape::Bars { width: 0.9 * width })
    }

    /// The same series with another shape.
    pub(crate) fn with_shape(self, shape: SeriesShape) -> Self {
        Self { shape, ..self }
    }

    /// The same series, left out of the legend.
    pub(crate) fn without_entry(self) -> Self {
        Self { in_legend: false, ..self }
    }
}

/// A horizontal reference line, labelled at the right of the panel.
#[derive(Clone, Debug)]
pub struct Level {
    /// Position on the y axis.
    pub value: f64,
    /// Text at its right end.
    pub label: String,
    /// Dash.
    pub dash: Dash,
}

/// A vertical reference line: a published frequency, a sensor plane.
#[derive(Clone, Debug)]
pub struct Mark {
    /// Position on the x axis.
    pub value: f64,
    /// Text above the panel; empty for none.
    pub label: String,
    /// Colour.
    pub color: Color,
    /// Dash.
    pub dash: Dash,
    /// Name in the legend; empty for none.
    pub legend: String,
}

impl Mark {
    /// A grey dotted line.
    pub(super) fn dotted(value: f64, label: &str) -> Self {
        Self { value, label: label.to_owned(), color: Color::Grey, dash: Dash::Dotted, legend: String::new() }
    }

    /// The top speed on an axis of speed or frequency.
    pub(crate) fn top_speed(value: f64) -> Self {
        Self::dotted(value, "top speed")
    }
}

/// A map of values over a numeric x and named rows.
#[derive(Clone, Debug)]
pub struct HeatMap {
    /// Edges of the columns, one more than there are columns.
    pub x_edges: Vec<f64>,
    /// `values[row][column]`; rows are the categories of the y axis.
    pub values: Vec<Vec<f64>>,
    /// What the values are, with their unit, beside the colour bar.
    pub label: String,
    /// Values that take the lightest and the darkest colour.
    pub range: [f64; 2],
}

/// One set of axes with what is drawn in it.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Heading above the panel; empty for none. Names the panel in the CSV.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Points.
    pub series: Vec<Series>,
    /// Horizontal reference lines.
    pub levels: Vec<Level>,
    /// Vertical reference lines.
    pub marks: Vec<Mark>,
    /// Map behind the series.
    pub heat: Option<HeatMap>,
    /// Same length for one unit of x and one of y (orbits, Nyquist).
    pub equal_aspect: bool,
    /// Height of the panel with its labels, px at report size.
    pub height_px: u32,
}

impl Panel {
    /// An empty panel of the usual height.
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        Self {
            title: title.to_owned(),
            x,
            y,
            series: Vec::new(),
            levels: Vec::new(),
            marks: Vec::new(),
            heat: None,
            equal_aspect: false,
            height_px: 300,
        }
    }

    /// Whether anything is drawn besides reference lines.
    pub(crate) fn shows_anything(&self) -> bool {
        let drawn = |axis: &Axis, value: &f64| value.is_finite() && (axis.scale == Scale::Linear || *value > 0.0);
        let shows = |s: &Series| s.x.iter().zip(&s.y).any(|(x, y)| drawn(&self.x, x) && drawn(&self.y, y));
        self.heat.is_some() || self.series.iter().any(shows)
    }

    /// Adds a dashed reference line.
    pub(crate) fn level(&mut self, value: f64, label: impl Into<String>) {
        self.levels.push(Level { value, label: label.into(), dash: Dash::Dashed });
    }
}

/// A picture: title, panels in a grid, one legend for all of them.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Title, printed on top.
    pub title: String,
    /// What is to be seen, in words, for readers who do not see the picture.
    pub description: String,
    /// Panels, row by row.
    pub panels: Vec<Panel>,
    /// Panels a row.
    pub columns: usize,
    /// Width at report size, px.
    pub width_px: u32,
}

impl Figure {
    /// Panels below each other at the width of the report.
    pub fn new(title: &str, description: &str, panels: Vec<Panel>) -> Self {
        Self { title: title.to_owned(), description: description.to_owned(), panels, columns: 1, width_px: 900 }
    }

    /// Panels below each other on one horizontal axis, which the last one has the labels of.
    pub(crate) fn stacked(title: &str, description: &str, panels: impl IntoIterator<Item = Panel>) -> Self {
        let mut figure = Self::new(title, description, panels.into_iter().collect());
        if let Some((_, upper)) = figure.panels.split_last_mut() {
            upper.iter_mut().for_each(|panel| panel.x.labelled = false);
        }
        figure
    }

    /// The same figure with that many panels a row.
    pub(crate) fn with_columns(self, columns: usize) -> Self {
        Self { columns: columns.max(1), ..self }
    }
}
