//! The sampled loop of a controller on the full plant at one speed, and its noise current.
//!
//! Noise: rms of the current from white sensor noise, by a Lyapunov equation.

use super::in_step;
use super::verification_error::VerificationError;
use crate::augment::plane::connected_part;
use crate::linalg::equal_planes::EqualPlanes;
use crate::linalg::lyapunov::discrete_lyapunov;
use crate::linalg::{Mat, NumericError, c64};
use crate::lti::connect::lower_lft;
use crate::lti::{Discrete, Response, StateSpace, TimeBase};
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// The loop of one plane where the planes are apart, else of both, on the full plant at one speed.
pub(crate) struct FullLoop {
    /// The plant.
    pub plant: Plant,
    /// Noise at the sensors → (currents, signals).
    pub loops: StateSpace<Discrete>,
    /// Axes in the loop.
    pub axes: usize,
    /// Planes of the states of `loops`, where they are known.
    planes: Option<EqualPlanes>,
}

impl FullLoop {
    /// The loop of a sampled controller.
    ///
    /// # Errors
    /// [`VerificationError`] from the plant or the connection.
    pub(crate) fn new(
        machine: &Machine,
        law: &StateSpace<Discrete>,
        speed_rad_s: f64,
    ) -> Result<Self, VerificationError> {
        let plant = Plant::new(machine, speed_rad_s, ModelDetail::Full)?;
        let sampled = plant.sampled()?;
        let numeric = in_step("loop on the full plant");
        // Only a law that keeps the planes apart leaves them apart; x axes come first in pairs.
        let across = |m: &Mat<c64>| {
            (0..16).any(|k| (k / 4 + k % 4) % 2 == 1 && m[(k / 4, k % 4)].norm() > 0.0)
        };
        let apart = speed_rad_s == 0.0 && plant.planes_are_alike() && !across(&law.at(TAU * 100.0));
        let axes: &[usize] = if apart { &[0, 2] } else { &[0, 1, 2, 3] };
        let own = connected_part(&law.select(axes, axes));
        let part = connected_part(&sampled.select(axes, axes));
        let planes = match part.order() == sampled.order() {
            true => plant.planes_of_loop(part.order(), &own).map_err(&numeric)?,
            false => None,
        };
        Ok(Self {
            planes,
            plant,
            loops: noisy_loops(&part, &own).map_err(&numeric)?,
            axes: axes.len(),
        })
    }

    /// Poles of the loop.
    ///
    /// # Errors
    /// [`NumericError`] when the eigenvalue iteration fails.
    pub(crate) fn poles(&self) -> Result<Vec<c64>, NumericError> {
        EqualPlanes::eigenvalues_on(self.planes.as_ref(), &self.loops.a)
    }

    /// First axis of bearing 0 or 1.
    pub(crate) fn bearing(&self, j: usize) -> usize {
        j * self.axes / 2
    }

    /// Largest rms current per unit of rms noise over the bearings; the loop is stable.
    ///
    /// # Errors
    /// [`NumericError`] from the Lyapunov equation.
    pub(crate) fn noise_gain(&self) -> Result<f64, NumericError> {
        let (loops, n) = (&self.loops, self.loops.order());
        let noise = loops.b.submatrix(0, 0, n, self.axes);
        // Covariance of the states: A P Aᵀ − P + BBᵀ = 0.
        let p = discrete_lyapunov(
            &loops.a.transpose().to_owned(),
            &(noise * noise.transpose()),
        )?;
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
///
/// # Errors
/// [`VerificationError`] from the plant, the poles or the Lyapunov equation.
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
fn noisy_loops(
    plant: &StateSpace<Discrete>,
    law: &StateSpace<Discrete>,
) -> Result<StateSpace<Discrete>, NumericError> {
    let (n, states) = (plant.inputs(), plant.order());
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    let b = Mat::from_fn(
        states,
        2 * n,
        |i, j| if j < n { 0.0 } else { plant.b[(i, j - n)] },
    );
    let c = Mat::from_fn(
        3 * n,
        states,
        |i, j| if i < n { 0.0 } else { plant.c[(i % n, j)] },
    );
    let d = Mat::from_fn(3 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => unit(i, j - n),
        (false, true) => unit(i % n, j),
        (false, false) => plant.d[(i % n, j - n)],
    });
    let open = StateSpace::new(plant.a.clone(), b, c, d, plant.time)?;
    lower_lft(&open, law)
}
