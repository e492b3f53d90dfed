//! Where an effect acts: at a bearing, at a position of the shaft, on a mode, in a region, or on the whole machine.

/// The control axes, in channel order.
pub const AXIS_NAMES: [&str; 4] = ["front_x", "front_y", "rear_x", "rear_y"];

named! {
    /// Which bearing an effect sits at.
    pub enum Bearings {
        /// The front bearing.
        Front = "front",
        /// The rear bearing.
        Rear = "rear",
        /// Both.
        Both = "both",
    }
}

impl Bearings {
    /// Whether bearing 0 (front) or 1 (rear) is meant.
    pub fn includes(self, bearing: usize) -> bool {
        match self {
            Self::Front => bearing == 0,
            Self::Rear => bearing == 1,
            Self::Both => true,
        }
    }
}

named! {
    /// One of the two planes in which the shaft moves.
    pub enum Plane {
        /// The plane of the x axes.
        X = "x",
        /// The plane of the y axes.
        Y = "y",
    }
}

/// Where an effect acts.
#[derive(Clone, Debug, PartialEq)]
pub enum Location {
    /// The machine as a whole, or a place that the kind implies.
    None,
    /// At a bearing (`bearing:` in files).
    Bearing(Bearings),
    /// At one axis of a bearing, counted from 0 in channel order (`axis:`, in place of `bearing:`).
    Axis(usize),
    /// From one axis to another, counted from 0 in channel order (`from:` and `to:`).
    Across {
        /// The axis that is seen.
        from: usize,
        /// The axis that sees it.
        to: usize,
    },
    /// At an axial position, m from the nose face (`position_m:`).
    Position(f64),
    /// At an axial position, m from the nose face, in one plane only (`position_m:` and `axis:`).
    InPlane(f64, Plane),
    /// On a flexible mode, counted from 1 (`mode:`).
    Mode(usize),
    /// In an update region (`region:`).
    Region(String),
}

impl Location {
    /// The axial position, m from the nose face; none where the location is not a position.
    pub fn position_m(&self) -> Option<f64> {
        match self {
            Self::Position(z) | Self::InPlane(z, _) => Some(*z),
            _ => None,
        }
    }

    /// The same at another axial position, m from the nose face; unchanged where the location is not a position.
    #[must_use]
    pub(crate) fn moved_to(&self, position_m: f64) -> Self {
        match self {
            Self::Position(_) => Self::Position(position_m),
            Self::InPlane(_, plane) => Self::InPlane(position_m, *plane),
            other => other.clone(),
        }
    }
}

/// What kind of location an effect needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocationKind {
    /// None.
    None,
    /// `bearing: front | rear | both`.
    Bearing,
    /// `from:` and `to:`, each an axis.
    Across,
    /// `position_m:`.
    Position,
    /// `mode:`.
    Mode,
    /// `region:`.
    Region,
}

impl LocationKind {
    /// The keys of the location in files; none for an effect of the whole machine.
    pub fn keys(self) -> &'static [&'static str] {
        match self {
            Self::None => &[],
            Self::Bearing => &["bearing"],
            Self::Across => &["from", "to"],
            Self::Position => &["position_m"],
            Self::Mode => &["mode"],
            Self::Region => &["region"],
        }
    }
}
