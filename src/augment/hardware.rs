//! Errors of actuators, sensors, magnets and delay in a specification.

use super::plane::LOOPS;
use super::shape::Shape;

/// What may be otherwise than the model, the same at both bearings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uncertainty {
    /// Relative error of the actuators (amplifier, magnet).
    pub actuator: Option<Shape>,
    /// Additive error of the signals, m per A of the bearing's commanded current: dynamics that the model leaves out.
    pub sensor: Option<Shape>,
    /// Relative error of k_i; none: 0.
    pub force_constant: f64,
    /// Relative error of k_s; none: 0.
    pub negative_stiffness: f64,
    /// Error of the loop's delay, s, either way; none: 0.
    pub delay_s: f64,
    /// |k_s| of front and rear bearing, N/m, once it is known from the machine ([`super::weights::Weights::on`]).
    pub ks_n_per_m: Option<[f64; LOOPS]>,
}

impl Uncertainty {
    /// With every error multiplied by a factor.
    #[must_use]
    pub(crate) fn times(&self, factor: f64) -> Self {
        let larger = |size: &Shape| size.times(factor);
        Self {
            actuator: self.actuator.as_ref().map(larger),
            sensor: self.sensor.as_ref().map(larger),
            force_constant: factor * self.force_constant,
            negative_stiffness: factor * self.negative_stiffness,
            delay_s: factor * self.delay_s,
            ..*self
        }
    }

    /// True when there is none.
    pub(crate) fn is_none(&self) -> bool {
        self.actuator.is_none()
            && self.sensor.is_none()
            && self.force_constant == 0.0
            && self.negative_stiffness == 0.0
            && self.delay_s == 0.0
    }
}
