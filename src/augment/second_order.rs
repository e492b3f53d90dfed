//! A second-order factor of a weight.

use crate::linalg::{Mat, NumericError};
use crate::lti::{Continuous, StateSpace};

/// W(s) = (b₂ s² + b₁ s + b₀)/(a₂ s² + a₁ s + a₀), stable and minimum phase; a₂ positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondOrder {
    /// b₀, b₁, b₂.
    pub b: [f64; 3],
    /// a₀, a₁, a₂.
    pub a: [f64; 3],
}

impl SecondOrder {
    /// |W(jω)|.
    pub fn magnitude(&self, omega_rad_s: f64) -> f64 {
        let size = |c: &[f64; 3]| {
            let real = c[0] - c[2] * omega_rad_s.powi(2);
            real.hypot(c[1] * omega_rad_s)
        };
        size(&self.b) / size(&self.a)
    }

    /// State space; the states are scaled by the poles' corner.
    pub(crate) fn system(&self) -> Result<StateSpace<Continuous>, NumericError> {
        let [b0, b1, b2] = self.b.map(|b| b / self.a[2]);
        let (square, damping) = (self.a[0] / self.a[2], self.a[1] / self.a[2]);
        let corner = square.sqrt();
        let a = [[0.0, corner], [-corner, -damping]];
        let c = [(b0 - b2 * square) / square, (b1 - b2 * damping) / corner];
        StateSpace::new(
            Mat::from_fn(2, 2, |i, j| a[i][j]),
            Mat::from_fn(2, 1, |i, _| if i == 0 { 0.0 } else { corner }),
            Mat::from_fn(1, 2, |_, j| c[j]),
            Mat::from_fn(1, 1, |_, _| b2),
            Continuous,
        )
    }

    /// The factor with `stretch` s in the place of s.
    #[must_use]
    fn stretch_frequencies(&self, stretch: f64) -> Self {
        let own = |c: [f64; 3]| [c[0], c[1] * stretch, c[2] * stretch.powi(2)];
        Self { b: own(self.b), a: own(self.a) }
    }

    /// Corner and damping of the sharper of numerator and denominator.
    pub(super) fn corner(&self) -> Option<(f64, f64)> {
        let of = |c: &[f64; 3]| {
            let omega = (c[0] / c[2]).sqrt();
            (omega, 0.5 * c[1] / (c[2] * omega))
        };
        let both = [&self.b, &self.a].into_iter().filter(|c| c[2] > 0.0).map(of);
        both.filter(|(omega, damping)| omega.is_finite() && *damping < 1.0).min_by(|x, y| x.1.total_cmp(&y.1))
    }

    /// The factor with v in the place of ω, its corner where it is written.
    pub(super) fn at_corner(&self, period_s: f64) -> Self {
        match self.corner() {
            Some((omega, _)) if 0.5 * omega * period_s < LAST_CORNER => {
                let theta = 0.5 * omega * period_s;
                self.stretch_frequencies(theta / theta.tan())
            }
            _ => *self,
        }
    }
}

/// θ of the last corner that can be held in place: nine tenths of Nyquist.
pub(super) const LAST_CORNER: f64 = 0.45 * std::f64::consts::PI;
