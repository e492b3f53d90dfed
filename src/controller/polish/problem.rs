//! The loss of a polish built for one machine and its specification: by the stage that descends on it, and by the check
//! of its derivatives.

use super::limits::LoopLimits;
use super::line_scales::LineScales;
use super::loss::{Loss, Specification, SpecifiedLoop};
use super::responses::{Known, Plants};
use super::structure::LoopLine;
use crate::augment::assembly::UncertainMode;
use crate::augment::channels::{channels, problem_blocks};
use crate::augment::plane::{LOADS, LOOPS};
use crate::augment::weights::{StiffnessFloor, Weights};
use crate::controller::verification_error::VerificationError;
use crate::controller::{ControllerError, in_step};
use crate::robust::structure::Structure as Blocks;

/// What a controller is polished for.
#[derive(Clone, Copy, Debug)]
pub struct PolishTask<'a> {
    /// The specification.
    pub weights: &'a Weights,
    /// Its uncertain modes.
    pub modes: &'a [UncertainMode],
    /// Bands in which the tool has to be stiff, at rest and at top speed.
    pub floors: &'a [StiffnessFloor],
    /// Factors on the natural frequencies with which the loop has to stay stable, at rest and at top speed.
    pub shifts: &'a [Vec<f64>],
    /// Least decay of the controller's own poles, 1/s: a slow pole of the loop, by which it creeps to rest after a
    /// load, comes with one of the controller beside it. Zero: none is asked.
    pub least_decay_per_s: f64,
    /// Limits.
    pub limits: LoopLimits,
}

impl PolishTask<'_> {
    /// Largest radius of the controller's own poles in the z plane.
    pub(super) fn largest_radius(&self, period_s: f64) -> f64 {
        (-self.least_decay_per_s * period_s).exp()
    }
}

/// The loss on `lines`; `earlier` is a loss for the same task on other lines, whose responses are taken where both have
/// a line, and whose scales of the modal channels at the nearest line; without it they are one.
pub(super) fn loss_on(
    plants: &Plants,
    task: &PolishTask<'_>,
    lines: Vec<LoopLine>,
    earlier: Option<&Loss>,
) -> Result<Loss, VerificationError> {
    let integral = match task.weights.integral_corner_hz {
        Some(_) => LOOPS,
        None => 0,
    };
    let extra = channels(task.weights).map_err(in_step("uncertainty of the polish"))?;
    let performance = (LOADS + LOOPS, LOADS + LOOPS + integral);
    let blocks = problem_blocks(task.modes.len(), &extra, performance.0, performance.1);
    let (rotors, rows) = earlier.map_or((vec![], vec![]), Loss::responses);
    let known = Known { lines: earlier.map_or(&[], |loss| &loss.lines), list: &rows };
    let loops =
        plants.specification(&lines, (task.modes, task.weights), &known).map_err(in_step("weights of the polish"))?;
    let loops = loops.into_iter().enumerate().map(|(side, rows)| {
        let scales = match earlier {
            Some(earlier) => earlier.scales_near(&lines, side, blocks.len()),
            None => vec![vec![1.0; blocks.len()]; rows.len()],
        };
        // The machine at the speeds of the specification comes first among the rotors.
        SpecifiedLoop { side, scales: scales.into_iter().map(LineScales::new).collect(), lines: rows }
    });
    let blocks = Blocks::new(&blocks).map_err(|_| infeasible("the specification has no channels"))?;
    let specification = Specification::new(loops.collect(), blocks);
    let known = Known { list: &rotors, lines: known.lines };
    let rotors = plants.on(&lines, &known);
    let period_s = plants.period_s();
    Ok(Loss::new(lines, rotors, Some(specification), task.limits, period_s).with_floors(task.floors))
}

pub(super) fn infeasible(reason: &str) -> ControllerError {
    ControllerError::Infeasible {
        step: "polish",
        reason: reason.to_owned(),
        advice: "a polish needs a start that levitates the machine at rest, and a specification with loads",
    }
}
