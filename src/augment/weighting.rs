//! Weighting functions of the generalized plant, written in s = jω of true frequency.
//! First order between two levels: W(s) = (h s + d p)/(s + p), p = 2π f_c √(h/d), so that W(0) = d, W(∞) = h and
//! |W(j2πf_c)| = √(h d) exactly, for d > h and for d < h.
//! Roll-on of the control weight: W(s) = (1/limit)·((1 + s/ω₁)/(1 + s/(r ω₁)))², flat in band, r² times steeper above.
//! How they enter the w plane of the sampled loop: [`super::warp`].

use crate::linalg::{Mat, NumericError};
use crate::lti::{Continuous, StateSpace};
use std::f64::consts::TAU;

/// W(s) = (b₁ s + b₀)/(a₁ s + a₀); b₀, a₀, a₁ positive, b₁ not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightSection {
    /// Numerator at s = 0.
    pub b0: f64,
    /// Coefficient of s in the numerator.
    pub b1: f64,
    /// Denominator at s = 0.
    pub a0: f64,
    /// Coefficient of s in the denominator.
    pub a1: f64,
}

impl WeightSection {
    /// Section with DC value `dc`, high-frequency value `hf` and geometric-mean crossing at `crossover_hz`.
    ///
    /// # Errors
    /// [`NumericError::NotFinite`] when a value is not finite or not positive.
    pub fn level_change(dc: f64, hf: f64, crossover_hz: f64) -> Result<Self, NumericError> {
        if ![dc, hf, crossover_hz].iter().all(|v| v.is_finite() && *v > 0.0) {
            return Err(NumericError::NotFinite { what: "first-order weight (levels and crossover must be positive)" });
        }
        let pole = TAU * crossover_hz * (hf / dc).sqrt();
        Ok(Self { b0: dc * pole, b1: hf, a0: pole, a1: 1.0 })
    }

    /// Leaky integrator: DC value `dc`, falling with 1/s above `leak_hz`.
    ///
    /// # Errors
    /// As [`WeightSection::level_change`].
    pub fn leaky_integrator(dc: f64, leak_hz: f64) -> Result<Self, NumericError> {
        if ![dc, leak_hz].iter().all(|v| v.is_finite() && *v > 0.0) {
            return Err(NumericError::NotFinite { what: "integral weight (gain and corner must be positive)" });
        }
        let pole = TAU * leak_hz;
        Ok(Self { b0: dc * pole, b1: 0.0, a0: pole, a1: 1.0 })
    }

    /// One of the two equal stages of the control weight, without the limit.
    ///
    /// # Errors
    /// As [`WeightSection::level_change`].
    pub fn roll_on_stage(corner_hz: f64, ratio: f64) -> Result<Self, NumericError> {
        Self::level_change(1.0, ratio, corner_hz * ratio.sqrt())
    }

    /// The section times a positive factor.
    #[must_use]
    pub(crate) fn times(&self, factor: f64) -> Self {
        Self { b0: factor * self.b0, b1: factor * self.b1, ..*self }
    }

    /// |W(jω)|.
    pub fn magnitude(&self, omega_rad_s: f64) -> f64 {
        self.b0.hypot(self.b1 * omega_rad_s) / self.a0.hypot(self.a1 * omega_rad_s)
    }

    /// State space; a positive constant when zero and pole coincide.
    ///
    /// # Errors
    /// [`NumericError`] when a coefficient is not finite.
    pub fn system(&self) -> Result<StateSpace<Continuous>, NumericError> {
        let (direct, pole) = (self.b1 / self.a1, self.a0 / self.a1);
        // h + r/(s + p); the state carries √|r| on both sides.
        let residue = self.b0 / self.a1 - direct * pole;
        let split = residue.abs().sqrt();
        let one = |x: f64| Mat::from_fn(1, 1, |_, _| x);
        StateSpace::new(one(-pole), one(split), one(residue.signum() * split), one(direct), Continuous)
    }
}

/// Rise of the integral weight below its corner: a leaky integrator, since a pole at zero cannot be stabilised.
const INTEGRAL_RISE: f64 = 1e3;

/// Integral weight of a signal that may be displaced by `allowed_m` at DC.
pub(crate) fn integral_section(allowed_m: f64, corner_hz: f64) -> Result<WeightSection, NumericError> {
    WeightSection::leaky_integrator(INTEGRAL_RISE / allowed_m, corner_hz / INTEGRAL_RISE)
}
