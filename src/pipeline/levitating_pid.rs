//! A PID that floats a rotor whose model is not known to be right.

use super::PipelineError;
use super::loop_stability::growth_rate_at;
use crate::controller::Controller;
use crate::pid::settings::TuneSettings;
use crate::pid::tune::{is_infeasible, textbook, tune};
use crate::spindle::Machine;
use crate::spindle::halved::refined_around_tilting;

/// A textbook PID for the model; where that does not levitate the machine that is measured at these speeds (rpm), the
/// PID of a short search on this machine, as on a rig. Where the search finds none either, the textbook PID. `watch` is
/// called on the way.
pub(crate) fn levitating_pid(
    model: &Machine,
    truth: &Machine,
    speeds_rpm: &[f64],
    watch: &dyn Fn(),
) -> Result<Controller, PipelineError> {
    let settings = TuneSettings::quick();
    let simple = textbook(model, &settings)?;
    let measured = refined_around_tilting(truth);
    for rpm in speeds_rpm {
        watch();
        if growth_rate_at(&measured, &simple.controller, *rpm)? >= 0.0 {
            return match tune(truth, &settings, &mut |_, _| watch()) {
                Ok(tuned) => Ok(tuned.controller),
                Err(error) if is_infeasible(&error) => Ok(simple.controller),
                Err(error) => Err(error.into()),
            };
        }
    }
    Ok(simple.controller)
}
