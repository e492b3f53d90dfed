//! Poles, zeros and gain of one axis, K = gain z^−delay Π(1 − zeroₖ z⁻¹)/Π(1 − poleₖ z⁻¹).
//! Zeros come from the resolvent at a real point z₀ where the axis responds, so zeros at infinity need no care:
//! with w = 1/(z − z₀) and M = (z₀I − A)⁻¹, K = D′ − cM(wI + M)⁻¹Mb, D′ = d + cMb, zeros w = eig(−M + Mb·cM/D′).

use crate::controller::{ControllerError, in_step};
use crate::linalg::{Mat, c64, eigenvalues, solve};
use crate::lti::{Discrete, StateSpace, scale, structure};

const STEP: &str = "second-order sections";
/// Largest part that roots taken as infinite, or as zero, have in the response: rounding of a few products. (A k-fold
/// root comes out as a ring of k roots at the k-th root of rounding, whose product is right all the same.)
const NEGLIGIBLE_PART: f64 = 1e-12;
/// Real points outside the circle where the numerator is taken: one of them is no zero.
const REAL_POINTS: [f64; 4] = [3.0, -3.0, 7.0, -7.0];

/// An axis by its roots.
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
///
/// # Errors
/// [`ControllerError::NotDecentralised`] when another input drives the output.
pub(super) fn axis_system(system: &StateSpace<Discrete>, axis: usize) -> Result<StateSpace<Discrete>, ControllerError> {
    let n = system.order();
    let seen = structure::seen(system, &[axis]);
    for input in (0..system.inputs()).filter(|j| *j != axis) {
        let other = structure::driven(system, &[input]);
        if system.d[(axis, input)] != 0.0 || (0..n).any(|i| other[i] && seen[i]) {
            return Err(ControllerError::NotDecentralised { output: axis, input });
        }
    }
    let own = structure::driven(system, &[axis]);
    let axis = system.select(&[axis], &[axis]).keep_states(|i| own[i] && seen[i]);
    Ok(axis.scale_states(&scale::balancing(&axis)))
}

impl AxisRoots {
    /// Roots of an axis, one input to one output.
    ///
    /// # Errors
    /// [`ControllerError::Numeric`] from the eigenvalue iterations.
    pub(super) fn of(axis: &StateSpace<Discrete>) -> Result<Self, ControllerError> {
        let poles = axis.poles().map_err(in_step(STEP))?;
        let values = REAL_POINTS.map(|z| (z, axis.transfer(c64::new(z, 0.0))[(0, 0)].re));
        let finite = values.into_iter().filter(|(_, value)| value.is_finite());
        let (z0, value) = finite.max_by(|x, y| x.1.abs().total_cmp(&y.1.abs())).unwrap_or((REAL_POINTS[0], 0.0));
        if value == 0.0 || poles.is_empty() {
            return Ok(Self { gain: axis.d[(0, 0)], delay: 0, poles: vec![], zeros: vec![] });
        }
        let n = axis.order();
        let shifted = Mat::from_fn(n, n, |i, j| -axis.a[(i, j)] + if i == j { z0 } else { 0.0 });
        let m = solve(&shifted, &Mat::identity(n, n)).map_err(in_step(STEP))?;
        let (mb, cm) = (&m * &axis.b, &axis.c * &m);
        let pencil = Mat::from_fn(n, n, |i, j| -m[(i, j)] + mb[(i, 0)] * cm[(0, j)] / value);
        let inverse = eigenvalues(&pencil).map_err(in_step(STEP))?;
        let zeros: Vec<c64> = finite_zeros(inverse, z0);
        let kept_poles = roots_off_zero(poles);
        let kept_zeros = roots_off_zero(zeros.clone());
        // z^zeros/z^poles, of which the roots at zero are z as they stand.
        let delay = n - zeros.len();
        let q = 1.0 / z0;
        let product = |roots: &[c64]| roots.iter().fold(c64::new(1.0, 0.0), |p, r| p * (1.0 - r * q)).re;
        let gain = value * product(&kept_poles) / product(&kept_zeros) / q.powi(delay as i32);
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

/// Zeros z₀ + 1/w without those at infinity: as many of the smallest w as have no part in the response.
fn finite_zeros(mut inverse: Vec<c64>, z0: f64) -> Vec<c64> {
    inverse.sort_by(|v, w| v.norm().total_cmp(&w.norm()));
    let part = |far: &[c64]| {
        let factor = |z: c64| far.iter().fold(c64::new(1.0, 0.0), |p, w| p * (1.0 - w * (z - z0)));
        on_circle().map(|z| (factor(z) / factor(c64::new(z0, 0.0)) - 1.0).norm()).fold(0.0, f64::max)
    };
    let count = (0..=inverse.len()).rev().find(|k| part(&inverse[..*k]) <= NEGLIGIBLE_PART).unwrap_or(0);
    inverse[count..].iter().map(|w| w.inv() + z0).collect()
}

/// Roots without those at zero.
fn roots_off_zero(mut roots: Vec<c64>) -> Vec<c64> {
    roots.sort_by(|p, q| p.norm().total_cmp(&q.norm()));
    let part = |near: &[c64]| {
        let factor = |z: c64| near.iter().fold(c64::new(1.0, 0.0), |p, r| p * (1.0 - r / z));
        on_circle().map(|z| (factor(z) - 1.0).norm()).fold(0.0, f64::max)
    };
    let count = (0..=roots.len()).rev().find(|k| part(&roots[..*k]) <= NEGLIGIBLE_PART).unwrap_or(0);
    roots.split_off(count)
}

/// Points of the unit circle that no small number of roots repeats on.
fn on_circle() -> impl Iterator<Item = c64> {
    (0..17).map(|k| c64::from_polar(1.0, std::f64::consts::PI * k as f64 / 16.0))
}
