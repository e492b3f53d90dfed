//! The sampled loop of a controller on the full plant at one speed, its largest sensitivity and its noise current: the
//! rms of the current from white sensor noise.
//!
//! Both are sums over the modes of the loop where its planes are equal or apart and its eigenvectors accurate.
//! Elsewhere the sensitivity comes from level sets, and the noise from a Lyapunov equation.

use super::in_step;
use super::modal_loop::ModalLoop;
use super::verification_error::VerificationError;
use crate::augment::plane::connected_part;
use crate::linalg::equal_planes::EqualPlanes;
use crate::linalg::lyapunov::discrete_lyapunov;
use crate::linalg::{Mat, NumericError, c64};
use crate::lti::connect::lower_lft;
use crate::lti::norm::{HinfNorm, NormError, hinf_norm_with_poles};
use crate::lti::scale::balancing;
use crate::lti::{Discrete, Response, StateSpace, TimeBase};
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// The loop of one plane where the planes are apart, else of both, on the full plant at one speed.
pub(crate) struct FullLoop {
    pub plant: Plant,
    /// Noise at the sensors → (currents, signals).
    pub loops: StateSpace<Discrete>,
    /// Axes in the loop.
    axes: usize,
    /// Planes of the states of `loops`, where they are known.
    planes: Option<EqualPlanes>,
    /// Modes of `loops`, where they are accurate.
    modes: Option<ModalLoop>,
}

/// Relative error of the sum over modes, at its largest value, at which it is used: a hundredth of the tolerance of a
/// sensitivity peak.
const SAME: f64 = 1e-6;

impl FullLoop {
    /// The loop of a sampled controller.
    pub(crate) fn new(
        machine: &Machine,
        law: &StateSpace<Discrete>,
        speed_rad_s: f64,
    ) -> Result<Self, VerificationError> {
        let plant = Plant::new(machine, speed_rad_s, ModelDetail::Full)?;
        let sampled = plant.sample_plant()?;
        let numeric = in_step("loop on the full plant");
        // Only a law that keeps the planes apart leaves them apart; x axes come first in pairs.
        let across = |m: &Mat<c64>| (0..16).any(|k| (k / 4 + k % 4) % 2 == 1 && m[(k / 4, k % 4)].norm() > 0.0);
        let apart = speed_rad_s == 0.0 && plant.planes_are_alike() && !across(&law.at(TAU * 100.0));
        let axes: &[usize] = if apart { &[0, 2] } else { &[0, 1, 2, 3] };
        let own = connected_part(&law.select(axes, axes));
        let part = connected_part(&sampled.select(axes, axes));
        let planes = if part.order() == sampled.order() {
            plant.planes_of_loop(part.order(), &own).map_err(&numeric)?
        } else {
            None
        };
        let loops = noisy_loops(&part, &own).map_err(&numeric)?;
        let modes = if apart || planes.is_some() { ModalLoop::new(&loops, planes.as_ref()) } else { None };
        Ok(Self { planes, plant, loops, axes: axes.len(), modes })
    }

    pub(crate) fn poles(&self) -> Result<Vec<c64>, NumericError> {
        match &self.modes {
            Some(modes) => Ok(modes.poles()),
            None => EqualPlanes::eigenvalues_on(self.planes.as_ref(), &self.loops.a),
        }
    }

    /// First axis of bearing 0 or 1.
    fn bearing(&self, j: usize) -> usize {
        j * self.axes / 2
    }

    /// Largest |S_jj| of an axis of bearing 0 or 1; `poles` are those of the loop.
    pub(crate) fn sensitivity_peak(&self, j: usize, poles: &[c64], rel_tol: f64) -> Result<HinfNorm, NormError> {
        let axis = self.bearing(j);
        let own = self.loops.select(&[self.axes + axis], &[axis]);
        Ok(match self.by_modes(j, &own, rel_tol) {
            Some(found) => found,
            None => hinf_norm_with_poles(&own, poles, rel_tol)?,
        })
    }

    /// [`Self::sensitivity_peak`] over the modes, where these are accurate, and where the response at the peak is that
    /// of `own`.
    fn by_modes(&self, j: usize, own: &StateSpace<Discrete>, rel_tol: f64) -> Option<HinfNorm> {
        // Of two planes the x axes come first in pairs; the modes know one plane.
        let entry = self.modes.as_ref()?.entry(2 + j, j);
        let found = entry.largest(own.time.period_s, rel_tol)?;
        let exact = own.at(found.peak_omega_rad_s)[(0, 0)].norm();
        ((found.norm - exact).abs() <= SAME * exact).then_some(found)
    }

    /// Largest rms current per unit of rms noise over the bearings; the loop is stable.
    pub(crate) fn noise_gain(&self) -> Result<f64, NumericError> {
        let by_modes = |j: usize| self.modes.as_ref()?.variance(j);
        if let Some((front, rear)) = by_modes(0).zip(by_modes(1)) {
            return Ok(front.max(rear).max(0.0).sqrt());
        }
        self.noise_gain_by_covariance()
    }

    /// [`Self::noise_gain`] by a Lyapunov equation.
    fn noise_gain_by_covariance(&self) -> Result<f64, NumericError> {
        // As the states come, the equation of a loop with a slender tool loses all but two digits.
        let loops = self.loops.scale_states(&balancing(&self.loops));
        let n = loops.order();
        let noise = loops.b.submatrix(0, 0, n, self.axes);
        // Covariance of the states: A P Aᵀ − P + BBᵀ = 0.
        let p = discrete_lyapunov(&loops.a.transpose().to_owned(), &(noise * noise.transpose()))?;
        let variance = |j: usize| {
            let row = self.bearing(j);
            let c = loops.c.submatrix(row, 0, 1, n);
            let direct = (0..self.axes).map(|k| loops.d[(row, k)].powi(2));
            (c * &p * c.transpose())[(0, 0)] + direct.sum::<f64>()
        };
        Ok(variance(0).max(variance(1)).max(0.0).sqrt())
    }
}

/// Largest rms current of an axis from white sensor noise on the full sampled plant at a speed, A; infinite when
/// unstable.
pub(crate) fn noise_current_a(
    machine: &Machine,
    law: &StateSpace<Discrete>,
    speed_rad_s: f64,
) -> Result<f64, VerificationError> {
    let numeric = in_step("noise current");
    let full = FullLoop::new(machine, law, speed_rad_s)?;
    let poles = full.poles().map_err(&numeric)?;
    if full.loops.time.largest_growth_rate(&poles) >= 0.0 {
        return Ok(f64::INFINITY);
    }
    let gain = full.noise_gain().map_err(&numeric)?;
    Ok(gain * machine.spindle.electronics.sensor_noise_m)
}

/// Noise at the sensors → (currents u, signals y): S and K S of the loop u = K y, y = G u + n.
fn noisy_loops(plant: &StateSpace<Discrete>, law: &StateSpace<Discrete>) -> Result<StateSpace<Discrete>, NumericError> {
    let (n, states) = (plant.inputs(), plant.order());
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    let b = Mat::from_fn(states, 2 * n, |i, j| if j < n { 0.0 } else { plant.b[(i, j - n)] });
    let c = Mat::from_fn(3 * n, states, |i, j| if i < n { 0.0 } else { plant.c[(i % n, j)] });
    let d = Mat::from_fn(3 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => unit(i, j - n),
        (false, true) => unit(i % n, j),
        (false, false) => plant.d[(i % n, j - n)],
    });
    let open = StateSpace::new(plant.a.clone(), b, c, d, plant.time)?;
    lower_lft(&open, law)
}
