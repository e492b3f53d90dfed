//! The controller of the thrust axis: a tuned PID, as firmware computes it, with the certificate of its loop. The loop
//! does not depend on the speed of the shaft.

use super::PipelineError;
use crate::controller::scaling::{ScaledRealisation, SignalLimits, scale_realisation};
use crate::controller::sections::second_order_sections;
use crate::controller::speed_proof::{SpeedInterval, SpeedProof};
use crate::controller::verification::{SpeedCheck, Verification, growth_words};
use crate::controller::{ControlLaw, ControllerError, in_step};
use crate::lti::connect::lower_lft;
use crate::pid::thrust::{ThrustPid, tune_thrust};
use crate::spindle::{Machine, ThrustAxis};

/// What the check of the loop used.
const CONDITIONS: &str = "thrust axis, which does not depend on the speed; coefficients in single precision";

/// A thrust axis with its controller.
#[derive(Clone, Debug)]
pub struct ThrustDesign {
    /// The plant.
    pub axis: ThrustAxis,
    /// The controller and its figures.
    pub pid: ThrustPid,
    /// The controller as firmware computes it, its input and output within the air gap and the range of the coils.
    pub realisation: ScaledRealisation,
    /// Stability with coefficients in single precision.
    pub verification: Verification,
}

/// The controller of the thrust axis of a machine; none where the machine has no such axis.
///
/// # Errors
/// [`PipelineError`] where no PID was found that stabilises the axis, or a computation fails.
pub fn design_thrust(machine: &Machine) -> Result<Option<ThrustDesign>, PipelineError> {
    let Some(axis) = ThrustAxis::of(machine)? else {
        return Ok(None);
    };
    let pid = tune_thrust(&axis, machine.spindle.stiffness_band_hz)?;
    let ControlLaw::Discrete(law) = &pid.controller.law else {
        return Ok(None);
    };
    // The rotor lands before it touches the magnet: about half the gap is left to it.
    let limits = SignalLimits { input_m: 0.5 * axis.bearing.gap_m, output_a: axis.bearing.current_range_a() };
    let realisation = scale_realisation(&second_order_sections(law)?, limits)?;
    let rounded = realisation.rows.rounded_f32()?;
    let growth = || lower_lft(&axis.sample_plant()?, &rounded)?.growth_rate();
    let growth_rate_per_s = growth().map_err(in_step("loop of the thrust axis"))?;
    if growth_rate_per_s.is_nan() || growth_rate_per_s >= 0.0 {
        let reason = format!("the loop {} with coefficients in single precision", growth_words(growth_rate_per_s, 0.0));
        let advice = "take a lower sample rate, or check mass, k_i, k_s and delay";
        return Err(ControllerError::Infeasible { step: "rounding of the thrust PID", reason, advice }.into());
    }
    let top_rpm = machine.spindle.max_rpm;
    let interval = SpeedInterval { centre_rpm: 0.0, growth_rate_per_s, radius_rpm: top_rpm };
    let verification = Verification {
        speeds: [0.0, top_rpm].map(|speed_rpm| SpeedCheck { speed_rpm, growth_rate_per_s }).to_vec(),
        conditions: CONDITIONS.to_owned(),
        proof: Some(SpeedProof { to_rpm: top_rpm, intervals: vec![interval], open_rpm: vec![] }),
        top_rpm,
        ..Verification::none()
    };
    Ok(Some(ThrustDesign { axis, pid, realisation, verification }))
}
