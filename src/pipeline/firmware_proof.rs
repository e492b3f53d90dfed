//! What firmware needs of a controller beside its law: the frequency at which a continuous one is kept exact, and the
//! proof of stability with the coefficients as they are rounded.

use super::PipelineError;
use crate::controller::ControllerError;
use crate::controller::arithmetic::q31;
use crate::controller::fidelity::{TransferChange, transfer_change_by_entry};
use crate::controller::scaling::ScaledRealisation;
use crate::controller::verification::{Verification, verify_with_proof};
use crate::lti::{Discrete, StateSpace};
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use std::f64::consts::TAU;

/// Speeds at which the loop is checked, from 0 to the largest.
const SPEEDS: usize = 11;

/// Frequency at which Tustin's rule keeps a continuous controller, Hz: the first flexible mode, where phase is
/// scarcest, up to a fifth of the sample rate; a tenth of it without one.
pub(crate) fn prewarp_hz(machine: &Machine) -> Result<f64, SpindleError> {
    let detail = ModelDetail::Modes { flexible: 1, static_residual: false };
    let model = Plant::new(machine, 0.0, detail)?;
    let fallback = 0.1 / machine.spindle.electronics.sample_period_s();
    let first = model.flexible_rad_s().first().map(|w| w / TAU);
    Ok(first.unwrap_or(fallback).min(2.0 * fallback))
}

/// Proof of stability with float32 coefficients, and with Q31 ones: whichever is worse.
pub(crate) fn proven_as_rounded(machine: &Machine, rows: &ScaledRealisation) -> Result<Verification, PipelineError> {
    let check = |law: &StateSpace<Discrete>, format: &str| {
        let conditions = format!("full finite-element plant, exact delay, sampled; coefficients rounded to {format}");
        verify_with_proof(machine, law, SPEEDS, &conditions)
    };
    let float = check(&rows.rows.rounded_f32()?, "float32 and to Q31")?;
    let fixed = check(&q31(rows)?.to_rounded_system()?, "Q31")?;
    Ok(if float.is_proven() && !fixed.is_proven() { fixed } else { float })
}

/// What rounding of its coefficients changes of a controller's transfer function, in each arithmetic.
pub(crate) struct RoundedTransfer {
    /// With float32 coefficients.
    pub float32: TransferChange,
    /// With Q31 coefficients.
    pub q31: TransferChange,
}

/// Compares the controller with its rows as they are rounded.
pub(crate) fn changed_by_rounding(
    law: &StateSpace<Discrete>,
    rows: &ScaledRealisation,
) -> Result<RoundedTransfer, ControllerError> {
    Ok(RoundedTransfer {
        float32: transfer_change_by_entry(law, &rows.rows.rounded_f32()?)?,
        q31: transfer_change_by_entry(law, &q31(rows)?.to_rounded_system()?)?,
    })
}
