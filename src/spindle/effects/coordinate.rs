//! Coordinates in which the answer is close to linear in an effect: the number of a coordinate, and its derivative.

use super::scale::MachineScale;

/// The unit of a number, from the size of the machine.
pub type Unit = fn(&MachineScale) -> f64;

/// How a number follows from its coordinate t.
#[derive(Clone, Copy, Debug)]
pub enum Coordinate {
    /// unit·t.
    Linear(Unit),
    /// unit/t.
    Inverse(Unit),
    /// unit/t².
    InverseSquare(Unit),
    /// exp t.
    Logarithm,
    /// 1/(1/f + unit·t) with f the bandwidth of the amplifiers.
    Slowness(Unit),
}

impl Coordinate {
    /// The number at t.
    pub fn value(self, t: f64, scale: &MachineScale) -> f64 {
        match self {
            Self::Linear(unit) => unit(scale) * t,
            Self::Inverse(unit) => unit(scale) / t,
            Self::InverseSquare(unit) => unit(scale) / (t * t),
            Self::Logarithm => t.exp(),
            Self::Slowness(unit) => (scale.amplifier_bandwidth_hz.recip() + unit(scale) * t).recip(),
        }
    }

    /// Its derivative at t.
    pub fn slope(self, t: f64, scale: &MachineScale) -> f64 {
        match self {
            Self::Linear(unit) => unit(scale),
            Self::Inverse(unit) => -unit(scale) / (t * t),
            Self::InverseSquare(unit) => -2.0 * unit(scale) / t.powi(3),
            Self::Logarithm => t.exp(),
            Self::Slowness(unit) => -unit(scale) * self.value(t, scale).powi(2),
        }
    }
}
