//! Zeros and poles of a weight.

use crate::linalg::c64;

/// A zero or pole in the left half plane: 1 + s/ω₀, or 1 + 2ζ s/ω₀ + (s/ω₀)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// Corner frequency ω₀, rad/s.
    pub omega_rad_s: f64,
    /// Damping ratio ζ below one of a complex pair; none of a real root.
    pub damping: Option<f64>,
}

impl Root {
    /// Of a root s in the left half plane, rad/s; of a complex pair either one.
    pub fn of(s: c64) -> Self {
        let omega_rad_s = s.norm();
        // Eigenvalues of real matrices are real or have imaginary parts well above rounding.
        let damping = (s.im != 0.0).then(|| -s.re / omega_rad_s);
        Self { omega_rad_s, damping }
    }

    pub(super) fn degree(&self) -> usize {
        1 + usize::from(self.damping.is_some())
    }

    /// Coefficients of s⁰, s¹, s², one at s = 0.
    pub(super) fn coefficients(&self) -> [f64; 3] {
        let w = self.omega_rad_s;
        match self.damping {
            None => [1.0, w.recip(), 0.0],
            Some(zeta) => [1.0, 2.0 * zeta / w, w.powi(-2)],
        }
    }
}
