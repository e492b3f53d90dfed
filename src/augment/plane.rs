//! Design model of one plane at standstill: free-free modes with the static residual of those left out, magnetic
//! stiffness, amplifiers, sensors, and ports for modal uncertainty.
//!
//! q̈ = −ω²q − 2ζωq̇ + Φₜᵀ Fₜ + Φ_bᵀ f_b − v,   f_b = F_b + k_i i + k_s x_b,   x = Φq + R f,   τ_a i̇ = u − i,   τ_s ẏ = x_s − y.
//! Inputs: v (one per mode listed), loads Fₜ, F_front, F_rear (N), commands u_front, u_rear (A, after the delay).
//! Outputs: q (one per mode listed), displacements x_t, x_front, x_rear (m), signals y_front, y_rear (m).
//! R is the static flexibility of the modes left out: without it the antiresonances move (design trap of truncation).

use crate::linalg::{Mat, NumericError, solve};
use crate::lti::connect::{block2, stack_cols, stack_rows};
use crate::lti::{Continuous, StateSpace};
use std::f64::consts::TAU;

/// Places where forces act and displacements are predicted, in this order.
pub const LOADS: usize = 3;
/// Control channels of a plane: front, rear.
pub const LOOPS: usize = 2;

/// One mass-normalised free-free mode as the plane's ports see it (1/√kg each).
#[derive(Clone, Debug)]
pub struct PortMode {
    /// Natural frequency, rad/s; 0 for a rigid-body mode.
    pub omega_rad_s: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Shape at tool, front actuator, rear actuator.
    pub load_shape: [f64; LOADS],
    /// Shape at front and rear sensor.
    pub sensor_shape: [f64; LOOPS],
}

/// Everything one plane of the design model needs.
#[derive(Clone, Debug)]
pub struct PlaneModel {
    /// Modes kept: rigid first, then flexible in ascending order.
    pub modes: Vec<PortMode>,
    /// Static flexibility of the modes left out, 5×3, m/N: rows tool, front and rear actuator, front and rear sensor;
    /// columns forces at tool, front, rear actuator.
    pub residual_m_per_n: Mat<f64>,
    /// Force constants front, rear, N/A.
    pub ki_n_per_a: [f64; LOOPS],
    /// Negative stiffnesses front, rear as positive numbers, N/m.
    pub ks_n_per_m: [f64; LOOPS],
    /// Sensor gains front, rear.
    pub sensor_gain: [f64; LOOPS],
    /// First-order amplifier corner, Hz.
    pub amplifier_bandwidth_hz: f64,
    /// First-order sensor corner, Hz.
    pub sensor_bandwidth_hz: f64,
    /// Delay from sampling to current, hold included, s.
    pub delay_s: f64,
    /// Sample period, s.
    pub sample_time_s: f64,
}

impl PlaneModel {
    /// State space without the delay; `uncertain` lists the modes (indices into `modes`) that get ports v and q.
    ///
    /// # Errors
    /// [`NumericError`] when the magnetic stiffness makes the residual loop singular.
    pub fn state_space(&self, uncertain: &[usize]) -> Result<StateSpace<Continuous>, NumericError> {
        let m = self.modes.len();
        let phi = Mat::from_fn(LOADS + LOOPS, m, |i, j| match i {
            0..LOADS => self.modes[j].load_shape[i],
            _ => self.modes[j].sensor_shape[i - LOADS],
        });
        let r = &self.residual_m_per_n;
        let ks = Mat::from_fn(LOADS, LOADS, |i, j| {
            if i == j && i > 0 {
                self.ks_n_per_m[i - 1]
            } else {
                0.0
            }
        });
        // x_f = Φ_f q + R_ff (F + k_i i + K_s x_f) ⇒ x_f = (I − R_ff K_s)⁻¹ (Φ_f q + R_ff F̃), F̃ = F + k_i i
        let phi_f = phi.submatrix(0, 0, LOADS, m).to_owned();
        let r_ff = r.submatrix(0, 0, LOADS, LOADS).to_owned();
        let loop_matrix = Mat::<f64>::identity(LOADS, LOADS) - &r_ff * &ks;
        let x_f = solve(&loop_matrix, &stack_cols(&phi_f, &r_ff))?;
        // Force f = F̃ + K_s x_f, all outputs x = Φ q + R f, both as [from q, from F̃]
        let force =
            &ks * &x_f + Mat::from_fn(LOADS, m + LOADS, |i, j| if j == m + i { 1.0 } else { 0.0 });
        let x = r * &force
            + Mat::from_fn(LOADS + LOOPS, m + LOADS, |i, j| {
                if j < m { phi[(i, j)] } else { 0.0 }
            });
        let acceleration = phi_f.transpose() * &force;
        self.assemble(&acceleration, &x, uncertain)
    }

    /// Joins modal dynamics, amplifiers and sensors. `acceleration` and `x` map (q, F̃) to q̈ and to displacements.
    fn assemble(
        &self,
        acceleration: &Mat<f64>,
        x: &Mat<f64>,
        uncertain: &[usize],
    ) -> Result<StateSpace<Continuous>, NumericError> {
        let (m, nv) = (self.modes.len(), uncertain.len());
        let (amp, sens) = (
            TAU * self.amplifier_bandwidth_hz,
            TAU * self.sensor_bandwidth_hz,
        );
        let n = 2 * m + 2 * LOOPS;
        let (i0, s0) = (2 * m, 2 * m + LOOPS);
        let (nw, load0, u0) = (nv + LOADS + LOOPS, nv, nv + LOADS);
        let mut a = Mat::zeros(n, n);
        let mut b = Mat::zeros(n, nw);
        let mut c = Mat::zeros(nv + LOADS + LOOPS, n);
        let mut d = Mat::zeros(nv + LOADS + LOOPS, nw);
        for (k, mode) in self.modes.iter().enumerate() {
            a[(k, m + k)] = 1.0;
            a[(m + k, m + k)] = -2.0 * mode.damping_ratio * mode.omega_rad_s;
            for j in 0..m {
                a[(m + k, j)] = acceleration[(k, j)];
            }
            a[(m + k, k)] -= mode.omega_rad_s * mode.omega_rad_s;
            for load in 0..LOADS {
                b[(m + k, load0 + load)] = acceleration[(k, m + load)];
            }
            for axis in 0..LOOPS {
                a[(m + k, i0 + axis)] = acceleration[(k, m + 1 + axis)] * self.ki_n_per_a[axis];
            }
        }
        for axis in 0..LOOPS {
            a[(i0 + axis, i0 + axis)] = -amp;
            b[(i0 + axis, u0 + axis)] = amp;
            let gain = sens * self.sensor_gain[axis];
            let row = LOADS + axis;
            a[(s0 + axis, s0 + axis)] = -sens;
            for j in 0..m {
                a[(s0 + axis, j)] = gain * x[(row, j)];
            }
            for load in 0..LOADS {
                b[(s0 + axis, load0 + load)] = gain * x[(row, m + load)];
            }
            for from in 0..LOOPS {
                a[(s0 + axis, i0 + from)] = gain * x[(row, m + 1 + from)] * self.ki_n_per_a[from];
            }
            c[(nv + LOADS + axis, s0 + axis)] = 1.0;
        }
        for (port, mode) in uncertain.iter().enumerate() {
            b[(m + mode, port)] = -1.0;
            c[(port, *mode)] = 1.0;
        }
        for p in 0..LOADS {
            for j in 0..m {
                c[(nv + p, j)] = x[(p, j)];
            }
            for load in 0..LOADS {
                d[(nv + p, load0 + load)] = x[(p, m + load)];
            }
            for axis in 0..LOOPS {
                c[(nv + p, i0 + axis)] = x[(p, m + 1 + axis)] * self.ki_n_per_a[axis];
            }
        }
        StateSpace::new(a, b, c, d, Continuous)
    }
}

/// Puts `extra` (2×2, commands to delayed commands) before the last two inputs of a plane.
pub(super) fn before_commands<T: crate::lti::TimeBase>(
    plane: &StateSpace<T>,
    extra: &StateSpace<T>,
) -> Result<StateSpace<T>, NumericError> {
    let n = plane.order();
    let others = plane.inputs() - LOOPS;
    let bu = plane.b.submatrix(0, others, n, LOOPS).to_owned();
    let du = plane
        .d
        .submatrix(0, others, plane.outputs(), LOOPS)
        .to_owned();
    let zero = Mat::zeros(extra.order(), n);
    let a = block2(&plane.a, &(&bu * &extra.c), &zero, &extra.a);
    let b_others = plane.b.submatrix(0, 0, n, others).to_owned();
    let d_others = plane.d.submatrix(0, 0, plane.outputs(), others).to_owned();
    let b = stack_rows(
        &stack_cols(&b_others, &(&bu * &extra.d)),
        &stack_cols(&Mat::zeros(extra.order(), others), &extra.b),
    );
    let c = stack_cols(&plane.c, &(&du * &extra.c));
    let d = stack_cols(&d_others, &(&du * &extra.d));
    StateSpace::new(a, b, c, d, plane.time)
}
