//! What stands round the shaft at one line: amplifiers, delay and eddy currents before it, sensors behind it; and a small solver.
//!
//! Force per current  e^{-sT} k_i /((1 + s/ω_a)(1 + √(s/ω_e))) [1 κ; κ 1],  signal per displacement  g R(α)/((1 + s/ω_s) L(s)),
//! L the second-order low-pass. From the receptance H(ω), H(−ω) of r = x + jy follow the planar entries
//! a = (H(ω) + H(−ω)*)/2 on the diagonal and b = (H(ω) − H(−ω)*)/2j across.

use super::model::{SIDE, Square, ZERO};
use crate::linalg::c64;
use crate::spindle::Effective;
use crate::spindle::plant::LOWPASS_DAMPING;
use std::f64::consts::TAU;

/// Electronics round the shaft at one line.
pub struct Chain {
    force: [[c64; 4]; 2],
    axes: [[c64; 4]; 2],
}

impl Chain {
    /// The electronics of a machine at angular frequency `w`, rad/s.
    pub fn new(effective: &Effective, sensor_bandwidth_hz: f64, w: f64) -> Self {
        let s = c64::new(0.0, w);
        let one = c64::new(1.0, 0.0);
        let delay = (-s * effective.delay_s).exp();
        let mut chain = Self {
            force: [[ZERO; 4]; 2],
            axes: [[ZERO; 4]; 2],
        };
        for (i, b) in effective.bearings.iter().enumerate() {
            let mut gain = delay / (one + s / (TAU * b.amplifier_bandwidth_hz)) * b.ki_n_per_a;
            if let Some(corner) = b.eddy_corner_hz {
                gain /= one + (s / (TAU * corner)).sqrt();
            }
            let cross = gain * b.coupling_ratio;
            chain.force[i] = [gain, cross, cross, gain];
            let mut sense = one / (one + s / (TAU * sensor_bandwidth_hz)) * b.sensor_gain;
            if let Some(bandwidth) = b.sensor_lowpass_hz {
                let q = s / (TAU * bandwidth);
                sense /= one + q * (2.0 * LOWPASS_DAMPING) + q * q;
            }
            let (sin, cos) = b.sensor_angle_rad.sin_cos();
            chain.axes[i] = [sense * cos, sense * sin, -sense * sin, sense * cos];
        }
        chain
    }

    /// F from the closed receptance forwards and backwards (3×3: sensors and tool from bearings and tool).
    pub fn apply(&self, plus: &[c64; 9], minus: Option<&[c64; 9]>) -> Square {
        let mut f = [ZERO; SIDE * SIDE];
        for o in 0..3 {
            for i in 0..3 {
                let h = plus[3 * o + i];
                let (a, b) = match minus {
                    None => (h, ZERO),
                    Some(minus) => {
                        let back = minus[3 * o + i].conj();
                        ((h + back) * 0.5, (h - back) * c64::new(0.0, -0.5))
                    }
                };
                f[2 * o * SIDE + 2 * i] = a;
                f[(2 * o + 1) * SIDE + 2 * i + 1] = a;
                f[(2 * o + 1) * SIDE + 2 * i] = b;
                f[2 * o * SIDE + 2 * i + 1] = -b;
            }
        }
        for (i, m) in self.force.iter().enumerate() {
            // Without coupling across a bearing, the usual case, both axes are only scaled.
            if m[1] == ZERO && m[2] == ZERO {
                for row in f.chunks_mut(SIDE) {
                    row[2 * i] *= m[0];
                    row[2 * i + 1] *= m[3];
                }
                continue;
            }
            for row in 0..SIDE {
                let (x, y) = (f[row * SIDE + 2 * i], f[row * SIDE + 2 * i + 1]);
                f[row * SIDE + 2 * i] = x * m[0] + y * m[2];
                f[row * SIDE + 2 * i + 1] = x * m[1] + y * m[3];
            }
        }
        for (i, m) in self.axes.iter().enumerate() {
            if m[1] == ZERO && m[2] == ZERO {
                for col in 0..SIDE {
                    f[2 * i * SIDE + col] *= m[0];
                    f[(2 * i + 1) * SIDE + col] *= m[3];
                }
                continue;
            }
            for col in 0..SIDE {
                let (x, y) = (f[2 * i * SIDE + col], f[(2 * i + 1) * SIDE + col]);
                f[2 * i * SIDE + col] = m[0] * x + m[1] * y;
                f[(2 * i + 1) * SIDE + col] = m[2] * x + m[3] * y;
            }
        }
        f
    }
}

/// Solves A X = B in place (B becomes X), A n×n and B n×p row-major, partial pivoting: matrices too small for a blocked solver.
/// A singular A leaves infinities.
pub fn eliminate(a: &mut [c64], b: &mut [c64], n: usize, p: usize) {
    for k in 0..n {
        let size = |i: usize| a[i * n + k].re.abs() + a[i * n + k].im.abs();
        let mut best = k;
        for i in k + 1..n {
            if size(i) > size(best) {
                best = i;
            }
        }
        if best != k {
            for j in 0..n {
                a.swap(k * n + j, best * n + j);
            }
            for j in 0..p {
                b.swap(k * p + j, best * p + j);
            }
        }
        let pivot = a[k * n + k].inv();
        for i in k + 1..n {
            let factor = a[i * n + k] * pivot;
            if factor == ZERO {
                continue;
            }
            for j in k + 1..n {
                let v = a[k * n + j];
                a[i * n + j] -= factor * v;
            }
            for j in 0..p {
                let v = b[k * p + j];
                b[i * p + j] -= factor * v;
            }
        }
    }
    for k in (0..n).rev() {
        let pivot = a[k * n + k].inv();
        for j in 0..p {
            let mut sum = b[k * p + j];
            for l in k + 1..n {
                sum -= a[k * n + l] * b[l * p + j];
            }
            b[k * p + j] = sum * pivot;
        }
    }
}
