//! Data that no fit uses: the hammer FRF at the tool of the levitated spindle against the model's prediction.
//!
//! x_t/F_t = G₂₂ + G₂₁ K (I − G₁₁K)⁻¹ G₁₂ with u = K y, the full model with its exact delay and the hold of a sampled
//! K. Figure of merit: root mean square over the lines of 20 log₁₀ |model/measured|, dB.

use super::UpdateError;
use crate::identify::HammerFrf;
use crate::identify::hammer::closed_loop_compliance;
use crate::lti::HeldResponse;
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// Root mean square error of the predicted tool compliance in dB; `axis` 0 is x, 1 is y.
///
/// # Errors
/// [`UpdateError::Machine`] when the machine has no plant.
pub fn tool_error_db(
    machine: &Machine,
    measured: &HammerFrf,
    axis: usize,
    controller: &dyn HeldResponse,
) -> Result<f64, UpdateError> {
    let speed = measured.speed_rpm * TAU / 60.0;
    let plant = Plant::new(machine, speed, ModelDetail::Full)?;
    let mut sum = 0.0;
    for (f, h) in measured.frequency_hz.iter().zip(&measured.compliance) {
        let model = closed_loop_compliance(&plant, controller, TAU * f, axis);
        let db = 20.0 * (model.norm() / h.norm()).log10();
        sum += db * db;
    }
    Ok((sum / measured.frequency_hz.len().max(1) as f64).sqrt())
}
