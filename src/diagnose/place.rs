//! Places where something may be missing: on the shaft, in the electronics, in one small parameter.

use super::model::Model;
use super::model::port::Probe;
use crate::spindle::{EffectKind, Location};

/// A place; bearings and axes by index, front first, x first.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// None: only small parameters.
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
    /// One small parameter without its prior.
    Freed(usize),
}

/// What the numbers at a place are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Force per displacement, N/m.
    Stiffness,
    /// Moment per angle, N m/rad.
    TurningStiffness,
    /// Relative change.
    Relative,
    /// Arm on which the slope is read, m.
    Arm,
    /// Displacement of the stator per force, m/N.
    Flexibility,
}

impl Unit {
    /// As printed.
    pub fn text(self) -> &'static str {
        match self {
            Self::Stiffness => "N/m",
            Self::TurningStiffness => "N m/rad",
            Self::Relative => "relative",
            Self::Arm => "m",
            Self::Flexibility => "m/N",
        }
    }

    /// As in keys of the summary.
    pub fn key(self) -> &'static str {
        match self {
            Self::Stiffness => "n_per_m",
            Self::TurningStiffness => "n_m_per_rad",
            Self::Relative => "relative",
            Self::Arm => "m",
            Self::Flexibility => "m_per_n",
        }
    }
}

impl Place {
    /// Whether the law is on the shaft.
    pub(super) fn mechanical(&self) -> bool {
        matches!(
            self,
            Self::Station(_) | Self::Apart(_) | Self::Circulating(_) | Self::Joint | Self::Housing
        )
    }

    /// Whether an effect of this kind may be what is missing here.
    pub fn hosts(&self, kind: EffectKind, location: &Location) -> bool {
        use EffectKind as K;
        let at = |b: usize| matches!(location, Location::Bearing(w) if w.includes(b));
        let both = at(0) && at(1);
        match self {
            Self::Nowhere | Self::Freed(_) => true,
            Self::Station(_) | Self::Apart(_) | Self::Circulating(_) => matches!(
                kind,
                K::ToolMass
                    | K::AddedMass
                    | K::AddedStiffness
                    | K::CrossCoupling
                    | K::InternalDamping
                    | K::Gyroscopic
                    | K::NegativeStiffness
            ),
            Self::Joint => matches!(kind, K::ToolJoint | K::ToolMass | K::RegionStiffness),
            Self::Housing => kind == K::HousingMode,
            Self::Loop => match kind {
                K::LoopDelay => true,
                K::AmplifierBandwidth
                | K::EddyCurrents
                | K::ForceConstant
                | K::SensorLowpass
                | K::SensorGain => both,
                _ => false,
            },
            Self::Sensors(b) => matches!(kind, K::SensorLowpass | K::SensorGain) && at(*b),
            Self::Currents(b) => {
                let kinds = [K::AmplifierBandwidth, K::EddyCurrents, K::ForceConstant];
                kinds.contains(&kind) && at(*b)
            }
            Self::Turned(b) => kind == K::AxisMisalignment && at(*b),
            Self::Coupled(b) => kind == K::BearingCoupling && at(*b),
            Self::SensorPlane(b) => kind == K::SensorOffset && at(*b),
            Self::ActuatorPlane(b) => kind == K::ActuatorOffset && at(*b),
            Self::Sensor(_) | Self::Current(_) | Self::Crosstalk(_) => false,
        }
    }

    /// Position of a place on the shaft, m.
    pub fn position_m(&self) -> Option<f64> {
        match self {
            Self::Station(z) | Self::Apart(z) | Self::Circulating(z) => Some(*z),
            _ => None,
        }
    }

    /// The same elsewhere on the shaft.
    pub fn moved_to(&self, z: f64) -> Self {
        match self {
            Self::Station(_) => Self::Station(z),
            Self::Apart(_) => Self::Apart(z),
            Self::Circulating(_) => Self::Circulating(z),
            other => other.clone(),
        }
    }

    /// Whether the other is of the same kind within 25 mm, less than stations are apart.
    pub fn beside(&self, other: &Self) -> bool {
        match (self.position_m(), other.position_m()) {
            (Some(a), Some(b)) => (a - b).abs() < 0.025 && self.moved_to(b) == *other,
            _ => self == other,
        }
    }

    pub(super) fn probes(&self, model: &Model) -> Vec<Probe> {
        let planes = &model.machine.spindle.planes;
        match self {
            Self::Station(z) | Self::Apart(z) | Self::Circulating(z) => vec![Probe::Station(*z)],
            Self::Joint => vec![Probe::JointAcross, Probe::JointTurning],
            Self::SensorPlane(b) => vec![Probe::Slope(
                [planes.front_sensor_m, planes.rear_sensor_m][*b],
            )],
            Self::ActuatorPlane(b) => vec![Probe::Slope(
                [planes.front_actuator_m, planes.rear_actuator_m][*b],
            )],
            _ => vec![],
        }
    }

    /// What the laws found here are: names and units, in the order of [`View::laws`].
    pub fn laws(&self, split: bool) -> Vec<(&'static str, Unit)> {
        match self {
            Self::Nowhere | Self::Freed(_) => vec![],
            Self::Joint => vec![
                ("turning", Unit::TurningStiffness),
                ("across", Unit::Stiffness),
            ],
            Self::Apart(_) => vec![("x", Unit::Stiffness), ("y", Unit::Stiffness)],
            Self::Circulating(_) => vec![
                ("x to y", Unit::Stiffness),
                ("x and y alike", Unit::Stiffness),
            ],
            Self::Station(_) if split => vec![
                ("x and y alike", Unit::Stiffness),
                ("x to y", Unit::Stiffness),
            ],
            Self::Station(_) => vec![("", Unit::Stiffness)],
            Self::Housing => vec![("", Unit::Flexibility)],
            Self::SensorPlane(_) | Self::ActuatorPlane(_) => vec![("", Unit::Arm)],
            _ => vec![("", Unit::Relative)],
        }
    }
}
