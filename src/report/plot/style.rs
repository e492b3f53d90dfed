//! How series look: a palette that colour-blind readers can tell apart, dashes and markers that carry the meaning as
//! well.
//!
//! Colours are those of Okabe and Ito (2008). A [`Role`] gives the same thing the same look in every picture of a
//! report; no two roles that meet in one picture differ in colour alone.

/// A colour of the palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Color {
    /// Blue.
    Blue,
    /// Vermillion.
    Vermillion,
    /// Bluish green.
    Green,
    /// Reddish purple.
    Purple,
    /// Orange.
    Orange,
    /// Sky blue.
    Sky,
    /// Black.
    Black,
    /// Mid grey, for what is context.
    Grey,
}

impl Color {
    pub(crate) fn rgb(self) -> (u8, u8, u8) {
        match self {
            Self::Blue => (0, 114, 178),
            Self::Vermillion => (213, 94, 0),
            Self::Green => (0, 158, 115),
            Self::Purple => (176, 90, 143),
            Self::Orange => (230, 159, 0),
            Self::Sky => (86, 180, 233),
            Self::Black => (20, 20, 20),
            Self::Grey => (125, 125, 125),
        }
    }
}

/// Dash pattern of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// Unbroken.
    Solid,
    /// Long dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Dash, dot.
    DashDot,
}

/// Marker at the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// Open circle.
    Circle,
    /// Filled disc.
    Disc,
    /// Open square.
    Square,
    /// Filled triangle, point up.
    Triangle,
    /// Filled diamond.
    Diamond,
    /// Diagonal cross.
    Cross,
}

/// Look of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Colour.
    pub color: Color,
    /// Dash of the line; `None` draws markers only.
    pub line: Option<Dash>,
    /// Line width, px at report size.
    pub width_px: f64,
    /// Marker at each point.
    pub marker: Option<Marker>,
}

impl Look {
    /// A line without markers.
    pub fn line(color: Color, dash: Dash) -> Self {
        Self { color, line: Some(dash), width_px: 1.7, marker: None }
    }

    /// Markers without a line.
    pub(crate) fn points(color: Color, marker: Marker) -> Self {
        Self { color, line: None, width_px: 1.3, marker: Some(marker) }
    }

    /// The same look with markers.
    pub(crate) fn with_marker(self, marker: Marker) -> Self {
        Self { marker: Some(marker), ..self }
    }

    /// The same look with another line width.
    pub(crate) fn with_width(self, width_px: f64) -> Self {
        Self { width_px, ..self }
    }
}

/// What a series stands for; the same role looks the same in every picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Model from the drawing.
    Nominal,
    /// Model after updating or correction.
    Updated,
    /// Measured data.
    Measured,
    /// The µ controller.
    Mu,
    /// The tuned PID.
    Pid,
    /// The textbook PID.
    TextbookPid,
    /// The worst case over the uncertainty.
    WorstCase,
    /// A limit or a specification.
    Limit,
    /// Any further series, told apart by number.
    Other(usize),
}

impl Role {
    pub(crate) fn look(self) -> Look {
        match self {
            Self::Nominal => Look::line(Color::Grey, Dash::Dashed),
            Self::Updated | Self::Mu => Look::line(Color::Blue, Dash::Solid),
            Self::Measured => Look::line(Color::Black, Dash::Dotted).with_width(1.5),
            Self::Pid => Look::line(Color::Vermillion, Dash::Dashed),
            Self::TextbookPid => Look::line(Color::Purple, Dash::Dotted),
            Self::WorstCase => Look::line(Color::Sky, Dash::DashDot),
            Self::Limit => Look::line(Color::Black, Dash::DashDot).with_width(1.2),
            Self::Other(k) => Self::look_number(k),
        }
    }

    fn look_number(k: usize) -> Look {
        const COLORS: [Color; 6] =
            [Color::Blue, Color::Vermillion, Color::Green, Color::Purple, Color::Orange, Color::Sky];
        const DASHES: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::DashDot, Dash::Dotted];
        // The dash advances with every series, and slips by one after each round of the palette, so that pairs do not
        // repeat.
        Look::line(COLORS[k % COLORS.len()], DASHES[(k + k / 12) % DASHES.len()])
    }
}
