//! One second-order section and its values.

use crate::linalg::c64;

/// One section: b₀ + b₁z⁻¹ + b₂z⁻² over 1 + a₁z⁻¹ + a₂z⁻².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionBiquad {
    /// Number of states, 0 to 2.
    pub order: usize,
    /// b₀, b₁, b₂.
    pub b: [f64; 3],
    /// a₁, a₂.
    pub a: [f64; 2],
}

impl SectionBiquad {
    /// z^−delay Π(1 − zero z⁻¹)/Π(1 − pole z⁻¹); at most two poles, and two zeros with the delay.
    pub(super) fn of_roots(poles: &[c64], zeros: &[c64], delay: usize) -> Self {
        let [_, a1, a2] = monic(poles);
        let plain = monic(zeros);
        let b = std::array::from_fn(|k| if k < delay { 0.0 } else { plain[k - delay] });
        Self { order: poles.len().max(zeros.len() + delay), b, a: [a1, a2] }
    }

    pub(super) fn of_gain(gain: f64) -> Self {
        Self { order: 0, b: [gain, 0.0, 0.0], a: [0.0; 2] }
    }

    /// The same with another numerator.
    pub(super) fn with_numerator(self, b: [f64; 3]) -> Self {
        Self { b, ..self }
    }

    pub(super) fn denominator(&self) -> [f64; 3] {
        [1.0, self.a[0], self.a[1]]
    }

    pub(super) fn response(&self, q: c64) -> c64 {
        value(self.b, q) / value(self.denominator(), q)
    }

    /// The power of two nearest to the inverse of the gain in the middle of the band, z = j; one where that is zero.
    pub(super) fn levelling_factor(&self) -> f64 {
        let gain = self.response(c64::new(0.0, -1.0)).norm();
        let factor = gain.log2().round().exp2().recip();
        if factor.is_normal() { factor } else { 1.0 }
    }

    /// Roots of z² + a₁z + a₂, without those at zero.
    pub(super) fn poles(&self) -> Vec<c64> {
        let [a1, a2] = self.a;
        if a2 == 0.0 {
            return if a1 == 0.0 { vec![] } else { vec![c64::new(-a1, 0.0)] };
        }
        let (half, square) = (-0.5 * a1, 0.25 * a1 * a1 - a2);
        if square < 0.0 {
            let pole = c64::new(half, (-square).sqrt());
            return vec![pole, pole.conj()];
        }
        // The root farther from zero has no cancellation.
        let far = half + square.sqrt().copysign(half);
        vec![c64::new(far, 0.0), c64::new(a2 / far, 0.0)]
    }
}

/// c₀ + c₁q + c₂q².
pub(super) fn value(c: [f64; 3], q: c64) -> c64 {
    (q * c[2] + c[1]) * q + c[0]
}

/// Π(1 − root q) as coefficients.
fn monic(roots: &[c64]) -> [f64; 3] {
    match roots {
        [] => [1.0, 0.0, 0.0],
        [r] => [1.0, -r.re, 0.0],
        [r, s, ..] => [1.0, -(r + s).re, (r * s).re],
    }
}
