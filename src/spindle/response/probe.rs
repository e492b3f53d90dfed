//! A further port of the shaft.

use super::ritz::ReducedShaft;
use crate::spindle::SpindleError;

/// A further port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Probe {
    /// Displacement at a position, m.
    Station(f64),
    /// Slope of the shaft at a position.
    Slope(f64),
    /// Rotation of the section at a position.
    Rotation(f64),
    /// The derivative of [`Self::Rotation`] to the position.
    RotationAlong(f64),
    /// What a moment at a position acts on.
    Tilt(f64),
    /// The derivative of [`Self::Tilt`] to the position.
    TiltAlong(f64),
    /// What another mesh may read more at a position.
    Misread(f64),
    /// Tool against nose, across.
    JointAcross,
    /// Tool against nose, turning.
    JointTurning,
}

impl Probe {
    /// Amplitudes of the port over the coordinates of a shaft.
    pub(crate) fn row(self, shaft: &ReducedShaft) -> Result<Vec<f64>, SpindleError> {
        let joint = |i: usize| {
            shaft.joint.as_ref().and_then(|rows| rows.get(i).cloned()).unwrap_or_else(|| vec![0.0; shaft.len()])
        };
        Ok(match self {
            Self::Station(z) => shaft.row(z)?,
            Self::Misread(z) => shaft.misread(z)?.unwrap_or_else(|| vec![0.0; shaft.len()]),
            Self::JointAcross => joint(0),
            Self::JointTurning => joint(1),
            Self::Slope(z) => shaft.slope_row(z)?,
            Self::Rotation(z) => shaft.rotation_rows(z)?[0].clone(),
            Self::RotationAlong(z) => shaft.rotation_rows(z)?[1].clone(),
            Self::Tilt(z) => shaft.tilt_row(z)?,
            Self::TiltAlong(z) => shaft.tilt_along_row(z)?,
        })
    }
}
