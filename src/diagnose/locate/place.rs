//! Places where something may be missing: on the shaft, in the electronics, in one nuisance parameter.

use super::super::fit::model::Model;
use crate::spindle::effects::entry::Site;
use crate::spindle::effects::{AXIS_NAMES, LocationKind};
use crate::spindle::response::probe::Probe;
use crate::spindle::{EffectKind, Location, Side};

/// A place; bearings and axes by index, front first, x first.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// None: only nuisance parameters.
    Nowhere,
    /// A law between ground and a position of the shaft, m.
    Station(f64),
    /// The same in x and y by two laws.
    Apart(f64),
    /// The same with a part that couples x and y (circulatory).
    Circulating(f64),
    /// Between tool and nose.
    Joint,
    /// The stator of both bearings hangs in a law; sensors ride on it.
    Housing,
    /// Sensors of a bearing.
    Sensors(usize),
    /// One sensor axis.
    Sensor(usize),
    /// Currents of a bearing.
    Currents(usize),
    /// One current axis.
    Current(usize),
    /// Every current, or what is the same in a sweep, every sensor.
    Loop,
    /// Sensor axes of a bearing turned.
    Turned(usize),
    /// Currents of a bearing that leak from x to y.
    Coupled(usize),
    /// Sensor plane of a bearing elsewhere: it reads the slope of the shaft too.
    SensorPlane(usize),
    /// Actuator plane of a bearing elsewhere.
    ActuatorPlane(usize),
    /// Currents of this bearing that act in the other.
    Crosstalk(usize),
    /// One nuisance parameter without its prior.
    Freed(usize),
}

/// What the numbers at a place are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawUnit {
    /// Force per displacement, N/m.
    Stiffness,
    /// Angle per moment, rad/(N m).
    TurningFlexibility,
    /// Relative change.
    Relative,
    /// Arm on which the slope is read, m.
    Arm,
    /// Displacement per force, m/N: of the stator, of the tool against the nose.
    Flexibility,
}

impl LawUnit {
    /// As printed.
    pub fn text(self) -> &'static str {
        match self {
            Self::Stiffness => "N/m",
            Self::TurningFlexibility => "rad/(N m)",
            Self::Relative => "relative",
            Self::Arm => "m",
            Self::Flexibility => "m/N",
        }
    }

    /// As in keys of the summary.
    pub fn key(self) -> &'static str {
        match self {
            Self::Stiffness => "n_per_m",
            Self::TurningFlexibility => "rad_per_n_m",
            Self::Relative => "relative",
            Self::Arm => "m",
            Self::Flexibility => "m_per_n",
        }
    }
}

impl Place {
    /// Whether the law is on the shaft.
    pub(crate) fn mechanical(&self) -> bool {
        matches!(self, Self::Station(_) | Self::Apart(_) | Self::Circulating(_) | Self::Joint | Self::Housing)
    }

    /// Whether free laws here may take up an effect anywhere on the shaft: those across the joint are two of the three
    /// complex numbers by which a reciprocal response of two bearings can change at a line.
    pub(crate) fn absorbs_others(&self) -> bool {
        *self == Self::Joint
    }

    /// Whether an effect of this kind may be what is missing here.
    pub(crate) fn hosts(&self, kind: EffectKind, location: &Location) -> bool {
        let entry = kind.entry();
        let at = |b: usize| match location {
            Location::Bearing(which) => which.includes(b),
            Location::Axis(axis) => axis / 2 == b,
            _ => entry.location != LocationKind::Bearing,
        };
        let (site, here) = match self {
            Self::Nowhere | Self::Freed(_) => return true,
            Self::Sensor(axis) => (Site::Sensors, *location == Location::Axis(*axis)),
            Self::Current(axis) => (Site::Currents, *location == Location::Axis(*axis)),
            Self::Crosstalk(_) => return false,
            Self::Station(_) | Self::Apart(_) | Self::Circulating(_) => (Site::Shaft, true),
            Self::Joint => (Site::Joint, true),
            Self::Housing => (Site::Housing, true),
            Self::Loop => (Site::Loop, at(0) && at(1)),
            Self::Sensors(b) => (Site::Sensors, at(*b)),
            Self::Currents(b) => (Site::Currents, at(*b)),
            Self::Turned(b) => (Site::SensorAxes, at(*b)),
            Self::Coupled(b) => (Site::AxisCoupling, at(*b)),
            Self::SensorPlane(b) => (Site::SensorPlane, at(*b)),
            Self::ActuatorPlane(b) => (Site::ActuatorPlane, at(*b)),
        };
        here && entry.sites.contains(&site)
    }

    /// Position of a place on the shaft, m.
    pub fn position_m(&self) -> Option<f64> {
        match self {
            Self::Station(z) | Self::Apart(z) | Self::Circulating(z) => Some(*z),
            _ => None,
        }
    }

    /// The name in files, which says what the laws found here act on.
    pub fn name_in_files(&self) -> String {
        let bearing = |b: &usize| Side::ALL[*b].name();
        let axis = |axis: &usize| AXIS_NAMES[*axis];
        match self {
            Self::Nowhere | Self::Freed(_) => "nowhere".into(),
            Self::Station(z) | Self::Apart(z) | Self::Circulating(z) => format!("shaft:{z}"),
            Self::Joint => "joint".into(),
            Self::Housing => "housing".into(),
            Self::Sensors(b) => format!("signals:{}", bearing(b)),
            Self::Sensor(k) => format!("signals:{}", axis(k)),
            Self::Currents(b) => format!("currents:{}", bearing(b)),
            Self::Current(k) => format!("currents:{}", axis(k)),
            Self::Loop => "loop".into(),
            Self::Turned(b) => format!("sensor_axes:{}", bearing(b)),
            Self::Coupled(b) => format!("axis_coupling:{}", bearing(b)),
            Self::SensorPlane(b) => format!("sensor_plane:{}", bearing(b)),
            Self::ActuatorPlane(b) => format!("actuator_plane:{}", bearing(b)),
            Self::Crosstalk(b) => format!("crosstalk:{}", bearing(b)),
        }
    }

    /// The same elsewhere on the shaft.
    pub(crate) fn moved_to(&self, z: f64) -> Self {
        match self {
            Self::Station(_) => Self::Station(z),
            Self::Apart(_) => Self::Apart(z),
            Self::Circulating(_) => Self::Circulating(z),
            other => other.clone(),
        }
    }

    /// Whether the other is of the same kind and less than a distance away, m.
    pub fn within(&self, distance_m: f64, other: &Self) -> bool {
        match (self.position_m(), other.position_m()) {
            (Some(a), Some(b)) => (a - b).abs() < distance_m && self.moved_to(b) == *other,
            _ => self == other,
        }
    }

    pub(super) fn probes(&self, model: &Model) -> Vec<Probe> {
        let planes = &model.reduced.machine.spindle.planes;
        match self {
            Self::Station(z) | Self::Apart(z) | Self::Circulating(z) => vec![Probe::Station(*z)],
            Self::Joint => vec![Probe::JointAcross, Probe::JointTurning],
            Self::SensorPlane(b) => vec![Probe::Slope([planes.front_sensor_m, planes.rear_sensor_m][*b])],
            Self::ActuatorPlane(b) => vec![Probe::Slope([planes.front_actuator_m, planes.rear_actuator_m][*b])],
            _ => vec![],
        }
    }

    /// What the laws found here are: names and units, in the order of `PlaceResponse::laws`.
    pub fn laws(&self, split: bool) -> Vec<(&'static str, LawUnit)> {
        match self {
            Self::Nowhere | Self::Freed(_) => vec![],
            Self::Joint => vec![("turning", LawUnit::TurningFlexibility), ("across", LawUnit::Flexibility)],
            Self::Apart(_) => vec![("x", LawUnit::Stiffness), ("y", LawUnit::Stiffness)],
            Self::Circulating(_) => vec![("x to y", LawUnit::Stiffness), ("x and y alike", LawUnit::Stiffness)],
            Self::Station(_) if split => vec![("x and y alike", LawUnit::Stiffness), ("x to y", LawUnit::Stiffness)],
            Self::Station(_) => vec![("", LawUnit::Stiffness)],
            Self::Housing => vec![("", LawUnit::Flexibility)],
            Self::SensorPlane(_) | Self::ActuatorPlane(_) => vec![("", LawUnit::Arm)],
            _ => vec![("", LawUnit::Relative)],
        }
    }
}
