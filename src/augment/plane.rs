//! One plane of the design model at standstill, in the w plane of synthesis.
//!
//! At rest the two planes are equal and independent: one is designed, the other gets a copy. Ports of a plane:
//! inputs (one modal port per uncertain mode; loads at tool, front and rear actuator, N; commands front, rear, A),
//! outputs (modal coordinates; displacements at tool, front and rear actuator, m; signals front, rear, m).
//! Direct design maps the sampled plant (hold, exact delay) by z = (1 + sT/2)/(1 − sT/2); nothing is lost on the way
//! back. Emulation takes the continuous plant with a Padé approximant of the delay.

use crate::lti::sample::inverse_tustin;
use crate::lti::structure;
use crate::lti::{Continuous, StateSpace, TimeBase};
use crate::rotor::modes::{PlanarModes, RIGID};
use crate::spindle::plant::CHANNELS;
use crate::spindle::{Effect, Location, Machine, ModelDetail, Plant, SpindleError};
use std::f64::consts::PI;

/// Places where forces act and displacements are predicted: tool, front actuator, rear actuator.
pub(crate) const LOADS: usize = 3;
/// Control channels of a plane: front, rear.
pub(crate) const LOOPS: usize = 2;

/// How the sampled loop enters the design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// Sampled plant with its true delay, mapped to the w plane.
    Direct,
    /// Continuous plant with a Padé approximant of this order for the delay; the controller is discretised afterwards.
    Emulation {
        /// Order of the approximant.
        pade_order: usize,
    },
}

/// The machine with x and y alike and without couplings between the planes other than gyroscopics (bearing coupling,
/// turned sensor axes, gains of one axis, springs in one plane).
pub(crate) fn isotropic(machine: &Machine) -> Machine {
    let mut isotropic = machine.clone();
    let effects = &mut isotropic.spindle.effects;
    let of_one_axis = |e: &Effect| matches!(e.location, Location::Axis(_) | Location::InPlane(..));
    effects.retain(|e| !e.kind.entry().couples_planes && !of_one_axis(e));
    if let Some(correction) = &mut isotropic.correction {
        correction.retain_alike();
    }
    isotropic
}

/// Natural frequencies of the flexible modes of the free shaft with its tool below half the sample rate, rad/s.
///
/// # Errors
/// [`SpindleError`] when the rotor or its eigenvalues fail.
pub fn modes_below_nyquist(machine: &Machine) -> Result<Vec<f64>, SpindleError> {
    let modes = PlanarModes::new(&machine.rotor()?).map_err(SpindleError::Shaft)?;
    let nyquist_rad_s = PI / machine.spindle.electronics.sample_period_s();
    let mut flexible = modes.omega_rad_s;
    flexible.retain(|w| *w < nyquist_rad_s);
    Ok(flexible.split_off(RIGID.min(flexible.len())))
}

/// One plane of the machine at rest with `flexible` modes, those numbered in `uncertain` (from 0) with modal ports.
/// What makes the planes differ or couples them (`isotropic`) is left out here and comes back in verification.
///
/// # Errors
/// [`SpindleError`] when the machine breaks a rule or a connection fails.
pub fn design_plane(
    machine: &Machine,
    flexible: usize,
    uncertain: &[usize],
    route: Route,
) -> Result<StateSpace<Continuous>, SpindleError> {
    let isotropic = isotropic(machine);
    let detail = ModelDetail::Modes { flexible, static_residual: true };
    let plant = Plant::new(&isotropic, 0.0, detail)?;
    let modes = uncertain.iter().map(|k| k + 1).max().unwrap_or(0);
    let ports: Vec<usize> = uncertain.iter().map(|mode| CHANNELS + 2 * mode).chain([4, 6, 8, 0, 2]).collect();
    Ok(match route {
        Route::Direct => {
            let sampled = plant.sampled_with_modal_ports(modes)?;
            inverse_tustin(&connected_part(&sampled.select(&ports, &ports)))?
        }
        Route::Emulation { pade_order } => {
            let continuous = plant.state_space_with_modal_ports(pade_order, modes)?;
            connected_part(&continuous.select(&ports, &ports))
        }
    })
}

/// One plane of four axes: front and rear of x, without the states that it does not use.
pub fn x_plane<T: TimeBase>(axes: &StateSpace<T>) -> StateSpace<T> {
    connected_part(&axes.select(&[0, 2], &[0, 2]))
}

/// The states that an input reaches and that reach an output, by the pattern of nonzeros: exact for decoupled planes.
pub fn connected_part<T: TimeBase>(system: &StateSpace<T>) -> StateSpace<T> {
    let inputs: Vec<usize> = (0..system.inputs()).collect();
    let outputs: Vec<usize> = (0..system.outputs()).collect();
    let driven = structure::driven_states(system, &inputs);
    let seen = structure::observed_states(system, &outputs);
    system.keep_states(|i| driven[i] && seen[i])
}
