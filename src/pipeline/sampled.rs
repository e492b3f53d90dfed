//! A controller at the sample rate of its machine, and its rows as firmware computes them.

use super::PipelineError;
use super::firmware_proof::prewarp_hz;
use crate::controller::discretise::discretise_law;
use crate::controller::{ControlLaw, Controller};
use crate::lti::{Discrete, StateSpace};
use crate::spindle::Machine;

#[derive(Clone, Debug)]
pub(crate) struct SampledController {
    /// With its sampled law.
    pub controller: Controller,
    pub law: StateSpace<Discrete>,
    /// Frequency at which Tustin's rule kept it, Hz; none where it was sampled already.
    pub prewarp_hz: Option<f64>,
}

/// Samples a continuous controller by Tustin's rule; a sampled one has to have the sample time of the machine.
pub(crate) fn sample_controller(machine: &Machine, given: &Controller) -> Result<SampledController, PipelineError> {
    let electronics = &machine.spindle.electronics;
    let period_s = electronics.sample_period_s();
    let (controller, prewarp_hz) = match &given.law {
        ControlLaw::Discrete(_) => (given.clone(), None),
        ControlLaw::Continuous(_) => {
            let prewarp_hz = prewarp_hz(machine)?;
            let sampled = discretise_law(given, period_s, prewarp_hz)?;
            (sampled.unwrap_or_else(|| given.clone()), Some(prewarp_hz))
        }
    };
    let law = super::comparison::discrete(&controller, period_s)?;
    Ok(SampledController { controller, law, prewarp_hz })
}
