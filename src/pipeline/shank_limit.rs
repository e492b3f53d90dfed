//! What a tool gives at rest under its largest load, whatever the controller does.
//!
//! Static forces act at the tool and at the two magnets, so that the equilibrium sets them and the bend of the shaft is
//! that of a beam on two supports. A controller can only move the shaft as a rigid body, which the displacements that
//! the specification allows at the bearings limit:
//!
//! u ≥ F c − |a| d_front − |b| d_rear, a = (z − z_rear)/(z_front − z_rear), b = 1 − a,
//!
//! with the load F at the tool plane z and the compliance c there on the supports. Where this is more than the
//! specification allows at the tool, μ exceeds one at zero frequency with every controller.

use super::PipelineError;
use crate::augment::weights::Weights;
use crate::rotor::supported::supported_compliance;
use crate::spindle::{Machine, SpindleError};

/// A tool that gives more than its specification allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShankLimit {
    /// Static load at the tool, N.
    pub load_n: f64,
    /// The least that the tool plane moves, m.
    pub least_m: f64,
    /// What it may move, m.
    pub allowed_m: f64,
}

impl ShankLimit {
    /// The limit that a machine breaks; none where the bend alone breaks none, where a weight over frequency takes the
    /// place of a level, or where springs besides the magnets hold the shaft.
    ///
    /// # Errors
    /// [`PipelineError`] when the shaft cannot be built.
    pub fn of(machine: &Machine, weights: &Weights) -> Result<Option<Self>, PipelineError> {
        let curves = &weights.curves;
        let given = curves.load.iter().chain(&curves.displacement).any(Option::is_some);
        if given || !machine.spindle.effects.is_empty() {
            return Ok(None);
        }
        let planes = &machine.spindle.planes;
        let [at, front, rear] = [machine.tool_plane_m(), planes.front_actuator_m, planes.rear_actuator_m];
        let compliance = supported_compliance(&machine.rotor()?, at, [front, rear]).map_err(SpindleError::Shaft)?;
        let share = (at - rear) / (front - rear);
        let moved_m = share.abs() * weights.front.max_dc_displacement_m
            + (1.0 - share).abs() * weights.rear.max_dc_displacement_m;
        let load_n = weights.tool.max_dc_load_n;
        let allowed_m = weights.tool.max_dc_displacement_m / weights.tool_tightening;
        let least_m = compliance * load_n - moved_m;
        Ok((least_m > allowed_m).then_some(Self { load_n, least_m, allowed_m }))
    }

    /// The limit in a sentence.
    pub fn sentence(&self) -> String {
        format!(
            "No controller can: at {} N the shank alone lets the tool give {:.3} µm, and {:.3} µm are allowed.",
            self.load_n,
            1e6 * self.least_m,
            1e6 * self.allowed_m
        )
    }
}
