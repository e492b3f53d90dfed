//! What acts between a place and the ground: a force per displacement.

use crate::linalg::c64;

/// A force per displacement, of one unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Against the displacement.
    Spring,
    /// Across it.
    Circulatory,
    /// Against the velocity.
    Dashpot,
    /// Against the acceleration.
    Mass,
}

impl Law {
    /// The springs and circulatory laws, with their stiffness, that make up a constant gain.
    pub fn parts(gain: c64) -> impl Iterator<Item = (Self, f64)> {
        let all = [(Self::Spring, -gain.re), (Self::Circulatory, gain.im)];
        all.into_iter().filter(|(_, value)| *value != 0.0)
    }

    /// Force per displacement at a signed frequency, rad/s.
    pub fn gain(self, w: f64) -> c64 {
        match self {
            Self::Spring => c64::new(-1.0, 0.0),
            Self::Circulatory => c64::new(0.0, 1.0),
            Self::Dashpot => c64::new(0.0, -w),
            Self::Mass => c64::new(w * w, 0.0),
        }
    }
}
