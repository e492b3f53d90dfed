//! What a corrected machine changes for the controller that levitated it: decay of the loop, stiffness at the tool.

use super::PipelineError;
use super::loop_stability::loop_poles;
use crate::controller::Controller;
use crate::controller::verification::rate_words;
use crate::lti::FrequencyGrid;
use crate::predict::stiffness::{dynamic_stiffness, stiffness_words};
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// Lowest line, Hz, and highest as part of the sample rate.
const BAND: (f64, f64) = (5.0, 0.45);
/// Lines, and lines on either side of a resonance.
const LINES: (usize, usize) = (300, 4);
/// Change of the stiffness within which a design on either model is the same for its user.
const SMALL_CHANGE: f64 = 0.05;

/// A loop at one speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoopState {
    /// Largest growth rate, 1/s; negative: stable.
    pub growth_rate_per_s: f64,
    /// Least dynamic stiffness at the tool in x and y, N/m; none of an unstable loop.
    pub least_stiffness_n_per_m: Option<f64>,
}

/// The loop that a record was taken in, with the given and with the corrected machine.
#[derive(Clone, Debug)]
pub(crate) struct Consequence {
    /// The record that names the controller.
    pub record: String,
    /// Its speed, rpm.
    pub speed_rpm: f64,
    pub given: LoopState,
    pub corrected: LoopState,
}

impl LoopState {
    /// The loop of a machine with a controller.
    pub(crate) fn of(machine: &Machine, controller: &Controller, speed_rpm: f64) -> Result<Self, PipelineError> {
        let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
        let poles = loop_poles(&plant, controller)?;
        let top_hz = BAND.1 / plant.sample_period_s();
        let grid = FrequencyGrid::log_hz(BAND.0, top_hz, LINES.0).refine_round_poles(&poles.poles_rad_s, LINES.1);
        let least = |axis: usize| dynamic_stiffness(&plant, controller, axis, &grid).minimum().map(|(k, _)| k);
        let both = || [0, 1].into_iter().filter_map(least).reduce(f64::min);
        let is_stable = poles.growth_rate_per_s < 0.0;
        Ok(Self { growth_rate_per_s: poles.growth_rate_per_s, least_stiffness_n_per_m: is_stable.then(both).flatten() })
    }
}

impl Consequence {
    /// As a sentence.
    pub(crate) fn words(&self) -> String {
        let Self { record, speed_rpm, given, corrected } = self;
        let lead = format!("With the controller of {record} at {speed_rpm:.0} rpm");
        let decay = |state: &LoopState| rate_words(-state.growth_rate_per_s, 1);
        match (given.least_stiffness_n_per_m, corrected.least_stiffness_n_per_m) {
            (Some(before), Some(after)) => {
                let change = after / before - 1.0;
                let ends = if change.abs() < SMALL_CHANGE {
                    "a design on either model is the same within 5 %".to_owned()
                } else {
                    format!("{:+.0} %: design with the corrected files", 100.0 * change)
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
