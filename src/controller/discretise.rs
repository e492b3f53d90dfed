//! A continuous controller made ready to run: Tustin's rule, exact at one frequency (prewarping), at the spindle's
//! rate.

use super::{ControlLaw, Controller, ControllerError, in_step};
use crate::lti::sample::tustin_prewarped;
use crate::lti::scale::dynamics_scale;
use std::f64::consts::TAU;

/// The controller at the sample period; `None` when it is sampled already. The response at `prewarp_hz` is kept
/// exactly; below a tenth of the sample rate the rest differs by less than 3 % in frequency.
///
/// # Errors
/// [`ControllerError::Numeric`] for a prewarp frequency at or above Nyquist, or a pole at s = 2/T.
pub fn discretise_law(
    controller: &Controller,
    period_s: f64,
    prewarp_hz: f64,
) -> Result<Option<Controller>, ControllerError> {
    let ControlLaw::Continuous(law) = &controller.law else {
        return Ok(None);
    };
    // Coordinates far apart in size, of a companion form for instance, would come back in the sampled controller.
    let even = dynamics_scale(&law.a).map(|scale| law.scale_states(&scale));
    let law = even.as_ref().unwrap_or(law);
    let sampled = tustin_prewarped(law, period_s, TAU * prewarp_hz).map_err(in_step("discretisation"))?;
    Ok(Some(Controller { name: controller.name.clone(), law: ControlLaw::Discrete(sampled) }))
}
