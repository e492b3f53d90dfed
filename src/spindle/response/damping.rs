//! Damping of the modal coordinates of a shaft: of its modes, and of its material, which turns with it.

use crate::rotor::modes::RIGID;

/// c_k = 2ζ_k ω_k + β ω_k² and the circulatory stiffness Ω β ω_k² of a loss time β, per modal mass.
#[derive(Clone, Debug)]
pub(crate) struct ModalDamping {
    /// 2ζω, 1/s.
    pub modal: Vec<f64>,
    /// With that of the material, 1/s.
    pub total: Vec<f64>,
    /// Circulatory stiffness, 1/s².
    pub circulatory: Vec<f64>,
}

impl ModalDamping {
    /// Damping of coordinates with natural frequencies `omega`, rad/s, of which the first two are rigid; `zeta` gives
    /// the damping ratio of flexible mode k, counted from 0.
    pub(crate) fn new(omega: &[f64], zeta: impl Fn(usize) -> f64, loss_time_s: f64, speed_rad_s: f64) -> Self {
        let ratio = |k: usize| k.checked_sub(RIGID).map_or(0.0, &zeta);
        let each = omega.iter().enumerate();
        let modal: Vec<f64> = each.map(|(k, w)| 2.0 * ratio(k) * w).collect();
        let material: Vec<f64> = omega.iter().map(|w| loss_time_s * w * w).collect();
        Self {
            total: modal.iter().zip(&material).map(|(a, b)| a + b).collect(),
            circulatory: material.iter().map(|m| speed_rad_s * m).collect(),
            modal,
        }
    }

    /// Appends a coordinate of its own, which does not turn, with damping `total` in 1/s.
    pub(crate) fn push(&mut self, total: f64) {
        self.modal.push(total);
        self.total.push(total);
        self.circulatory.push(0.0);
    }
}
