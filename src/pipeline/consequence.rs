//! What a corrected machine changes for the controller that levitated it: decay of the loop, stiffness at the tool.

use super::PipelineError;
use super::comparison::{LoopAtSpeed, closed_loop, predict};
use crate::controller::Controller;
use crate::controller::verification::rate_words;
use crate::predict::stiffness::stiffness_words;
use crate::spindle::Machine;

/// Change of the stiffness that is not worth another design.
const SMALL_CHANGE: f64 = 0.05;

/// A loop at one speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoopOutcome {
    /// Largest growth rate, 1/s; negative: stable.
    pub growth_rate_per_s: f64,
    /// Least dynamic stiffness at the tool in x and y over the stiffness band of the machine, N/m; none of an unstable
    /// loop.
    pub least_stiffness_n_per_m: Option<f64>,
}

/// The loop that a record was taken in, with the given and with the corrected machine.
#[derive(Clone, Debug)]
pub(crate) struct Consequence {
    /// The record that names the controller.
    pub record: String,
    /// Its speed, rpm.
    pub speed_rpm: f64,
    pub given: LoopOutcome,
    pub corrected: LoopOutcome,
}

impl LoopOutcome {
    /// The loop of a machine with a controller, as [`predict`] has it.
    pub(crate) fn of(machine: &Machine, controller: &Controller, speed_rpm: f64) -> Result<Self, PipelineError> {
        let LoopAtSpeed { poles, .. } = closed_loop(machine, controller, speed_rpm, machine.spindle.stiffness_band_hz)?;
        let growth_rate_per_s = poles.growth_rate_per_s;
        // A controller that nothing can levitate with may have no discrete form to predict with.
        let stable = (growth_rate_per_s < 0.0).then(|| predict(machine, controller, speed_rpm)).transpose()?;
        Ok(Self { growth_rate_per_s, least_stiffness_n_per_m: stable.map(|predicted| predicted.minimum.0) })
    }
}

impl Consequence {
    /// As a sentence.
    pub(crate) fn words(&self) -> String {
        let Self { record, speed_rpm, given, corrected } = self;
        let lead = format!("With the controller of {record} at {speed_rpm:.0} rpm");
        let decay = |state: &LoopOutcome| rate_words(-state.growth_rate_per_s, 1);
        match (given.least_stiffness_n_per_m, corrected.least_stiffness_n_per_m) {
            (Some(before), Some(after)) => {
                let change = after / before - 1.0;
                let ends = if change.abs() < SMALL_CHANGE {
                    "the correction changes this stiffness by less than 5 %".to_owned()
                } else {
                    format!("{:+.0} %: design with the corrected model", 100.0 * change)
                };
                format!(
                    "{lead} the tool is {} stiff at least on the corrected model and {} on the given one, and the loop \
                     decays with {} and {} 1/s; {ends}.",
                    stiffness_words(after),
                    stiffness_words(before),
                    decay(corrected),
                    decay(given)
                )
            }
            (None, Some(after)) => format!(
                "{lead} the given model does not float; on the corrected one the tool is {} stiff at least.",
                stiffness_words(after)
            ),
            (_, None) => format!("{lead} the corrected model does not float."),
        }
    }
}
