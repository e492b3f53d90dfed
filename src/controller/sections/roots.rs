//! Poles, zeros and gain of one axis, K = gain z^−delay Π(1 − zeroₖ z⁻¹)/Π(1 − poleₖ z⁻¹).

use crate::controller::{ControllerError, in_step};
use crate::linalg::c64;
use crate::lti::zeros::{roots_off_zero, siso_zeros};
use crate::lti::{Discrete, StateSpace, scale, structure};

const STEP: &str = "second-order sections";
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AxisRoots {
    /// Leading coefficient in powers of z⁻¹.
    pub gain: f64,
    /// Whole samples of delay.
    pub delay: usize,
    /// Poles, those at zero left out; conjugate pairs are exact.
    pub poles: Vec<c64>,
    /// Finite zeros, those at zero left out; conjugate pairs are exact.
    pub zeros: Vec<c64>,
}

/// The part of the controller that axis `axis` reads and drives: states both reached from its input and seen at
/// its output through the pattern of A, in units that even out rows and columns.
pub(super) fn axis_system(system: &StateSpace<Discrete>, axis: usize) -> Result<StateSpace<Discrete>, ControllerError> {
    let n = system.order();
    let seen = structure::observed_states(system, &[axis]);
    for input in (0..system.inputs()).filter(|j| *j != axis) {
        let other = structure::driven_states(system, &[input]);
        if system.d[(axis, input)] != 0.0 || (0..n).any(|i| other[i] && seen[i]) {
            return Err(ControllerError::NotDecentralised { output: axis, input });
        }
    }
    let own = structure::driven_states(system, &[axis]);
    let axis = system.select(&[axis], &[axis]).keep_states(|i| own[i] && seen[i]);
    Ok(axis.scale_states(&scale::balancing(&axis)))
}

impl AxisRoots {
    /// Roots of an axis, one input to one output.
    pub(super) fn of(axis: &StateSpace<Discrete>) -> Result<Self, ControllerError> {
        let poles = axis.poles().map_err(in_step(STEP))?;
        let found = siso_zeros(axis, 1.0).map_err(in_step(STEP))?;
        if found.value == 0.0 || poles.is_empty() {
            return Ok(Self { gain: axis.d[(0, 0)], delay: 0, poles: vec![], zeros: vec![] });
        }
        // z^zeros/z^poles, of which the roots at zero are z as they stand.
        let delay = axis.order() - found.zeros.len();
        let (kept_poles, kept_zeros) = (roots_off_zero(poles, 1.0), roots_off_zero(found.zeros, 1.0));
        let q = 1.0 / found.point;
        let product = |roots: &[c64]| roots.iter().fold(c64::new(1.0, 0.0), |p, r| p * (1.0 - r * q)).re;
        let gain = found.value * product(&kept_poles) / product(&kept_zeros) / q.powi(delay as i32);
        Ok(Self { gain, delay, poles: kept_poles, zeros: kept_zeros })
    }

    /// The same with (nearly) double real roots where a pair is closer to them than `share` of its distance from ±1
    /// in the square: a double root splits into a pair by rounding, and two real ones need less precision.
    pub(super) fn with_double_reals(&self, share: f64) -> Self {
        let settle = |roots: &[c64]| {
            let real = |r: &c64| {
                let distance = (1.0 - r.re).abs().min((1.0 + r.re).abs());
                if r.im * r.im < share * distance * distance { c64::new(r.re, 0.0) } else { *r }
            };
            roots.iter().map(real).collect()
        };
        Self { poles: settle(&self.poles), zeros: settle(&self.zeros), ..self.clone() }
    }
}
