//! Coordinates in which the answer is close to linear in an effect: the number of a coordinate, and its derivative.

/// How a number follows from its coordinate t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinate {
    /// unit·t.
    Linear(f64),
    /// unit/t.
    Inverse(f64),
    /// unit/t².
    InverseSquare(f64),
    /// exp t.
    Logarithm,
    /// 1/(1/nominal + unit·t).
    Slowness(f64),
}

impl Coordinate {
    /// The number at t, for a nominal value of the machine.
    pub fn value(self, t: f64, nominal: f64) -> f64 {
        match self {
            Self::Linear(unit) => unit * t,
            Self::Inverse(unit) => unit / t,
            Self::InverseSquare(unit) => unit / (t * t),
            Self::Logarithm => t.exp(),
            Self::Slowness(unit) => (nominal.recip() + unit * t).recip(),
        }
    }

    /// Its derivative at t.
    pub fn slope(self, t: f64, nominal: f64) -> f64 {
        match self {
            Self::Linear(unit) => unit,
            Self::Inverse(unit) => -unit / (t * t),
            Self::InverseSquare(unit) => -2.0 * unit / t.powi(3),
            Self::Logarithm => t.exp(),
            Self::Slowness(unit) => -unit * self.value(t, nominal).powi(2),
        }
    }
}
