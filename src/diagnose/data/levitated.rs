//! A line of a sweep with the loop closed by a PD controller of the machine, for comparisons with models that are far
//! off.
//!
//! With u = K y + v the response is T = G (I − K G)⁻¹. Poles of G hardly have damping, at rest those of the rigid rotor
//! have none, so that a pole at another frequency is out of reach of a linear step. Poles of T are damped, and
//! T_m − T_f = (I − G_m K)⁻¹ (G_m − G_f) (I − K G_f)⁻¹ says the same of two responses. K need not be the controller of
//! the rig, nor stabilise it: it only has to move the poles off the axis.

use super::evidence::SweepEvidence;
use crate::linalg::c64;
use crate::linalg::fused::fused_complex;
use crate::linalg::small::eliminate;
use crate::spindle::Machine;
use crate::spindle::response::ZERO;
use std::f64::consts::TAU;

/// Least stiffness of the loop per mass of a bearing, rad/s: rotors hang this fast where the magnets have no negative
/// stiffness to speak of.
const SLOWEST_RAD_S: f64 = TAU * 30.0;
/// Damping ratio of a mass in the loop.
const DAMPING_RATIO: f64 = 0.7;

/// A PD controller, the same in x and y: −(A/m, A s/m), front and rear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Levitation([[f64; 2]; 2]);

impl Levitation {
    /// That gives each bearing the stiffness of its magnets with the other sign, and damps half of the rotor there.
    pub(crate) fn of(machine: &Machine, mass_kg: f64) -> Self {
        let bearings = [&machine.spindle.front, &machine.spindle.rear];
        Self(bearings.map(|b| {
            let mass = 0.5 * mass_kg;
            let stiffness = b.ks_n_per_m.max(mass * SLOWEST_RAD_S.powi(2));
            let damping = 2.0 * DAMPING_RATIO * (stiffness * mass).sqrt();
            let per_metre = (b.ki_n_per_a * b.sensor_gain).recip();
            [(b.ks_n_per_m + stiffness) * per_metre, damping * per_metre]
        }))
    }

    fn gain(&self, axis: usize, omega_rad_s: f64) -> c64 {
        let [stiff, damped] = self.0[axis / 2];
        -c64::new(stiff, damped * omega_rad_s)
    }
}

/// G with the loop closed.
pub(crate) struct ClosedResponse {
    /// G (I − K G)⁻¹.
    response: [c64; 16],
    /// (I − G K)⁻¹.
    left: [c64; 16],
    /// (I − K G)⁻¹.
    right: [c64; 16],
}

fn product(a: &[c64; 16], b: &[c64; 16]) -> [c64; 16] {
    let mut all = [ZERO; 16];
    for (i, row) in all.chunks_exact_mut(4).enumerate() {
        for (x, b) in a[4 * i..4 * i + 4].iter().zip(b.chunks_exact(4)) {
            // At rest x and y do not know of each other.
            if *x != ZERO {
                let sums = row.iter_mut().zip(b);
                sums.for_each(|(sum, y)| *sum = fused_complex(*x, *y, *sum));
            }
        }
    }
    all
}

fn one(n: usize) -> c64 {
    c64::new(f64::from(u8::from(n / 4 == n % 4)), 0.0)
}

impl ClosedResponse {
    /// Closes the loop round G at a frequency.
    pub(crate) fn new(levitation: &Levitation, omega_rad_s: f64, g: &[c64; 16]) -> Self {
        let k: [c64; 4] = std::array::from_fn(|i| levitation.gain(i, omega_rad_s));
        let mut open: [c64; 16] = std::array::from_fn(|n| one(n) - g[n] * k[n % 4]);
        let mut left: [c64; 16] = std::array::from_fn(one);
        eliminate(&mut open, &mut left, 4, 4);
        // G (I − K G)⁻¹ = (I − G K)⁻¹ G, and (I − K G)⁻¹ = I + K G (I − K G)⁻¹.
        let response = product(&left, g);
        Self { right: std::array::from_fn(|n| one(n) + k[n / 4] * response[n]), response, left }
    }

    /// What a change of G changes of the response, over the standard deviations of a line.
    pub(crate) fn change(&self, g: &[c64; 16], sd: &[f64; 16]) -> [c64; 16] {
        let changed = product(&product(&self.left, g), &self.right);
        std::array::from_fn(|n| changed[n] / sd[n])
    }

    /// What this response, as measured, is off a predicted one.
    pub(crate) fn off(&self, predicted: &Self, sd: &[f64; 16]) -> [c64; 16] {
        std::array::from_fn(|n| (self.response[n] - predicted.response[n]) / sd[n])
    }
}

impl SweepEvidence {
    /// A line with the loop closed, and its standard deviations with a model error: relative to the response and to
    /// those of the two axes that it connects, between which it may vanish.
    pub(crate) fn close_line(
        &self,
        line: usize,
        levitation: &Levitation,
        model_error: f64,
    ) -> (ClosedResponse, [f64; 16]) {
        let closed = ClosedResponse::new(levitation, self.omega_rad_s[line], &self.response[line]);
        let size = |i: usize, j: usize| closed.response[4 * i + j].norm();
        // ΔT = L ΔG R, and row k of ΔG has the covariance S_k times the spread.
        let spread = &self.spread[line];
        let column = |j: usize| -> f64 {
            let r = |l: usize| closed.right[4 * l + j];
            let pairs = (0..16).map(|n| r(n / 4) * r(n % 4).conj() * spread[n]);
            pairs.fold(ZERO, |s, v| s + v).re.max(0.0)
        };
        let columns: [f64; 4] = std::array::from_fn(column);
        let row = |i: usize| -> f64 {
            let noise = &self.noise[line];
            (0..4).map(|k| closed.left[4 * i + k].norm_sqr() * noise[k]).sum()
        };
        let rows: [f64; 4] = std::array::from_fn(row);
        let sd = std::array::from_fn(|n| {
            let (i, j) = (n / 4, n % 4);
            let own = 0.5 * (size(i, j).powi(2) + size(i, i) * size(j, j));
            let variance = rows[i] * columns[j] + model_error * model_error * own;
            variance.max(f64::MIN_POSITIVE).sqrt()
        });
        (closed, sd)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_with_the_loop_closed_solves_its_equations() {
        let levitation = Levitation([[3.0, 0.2], [5.0, 0.1]]);
        let entry = |n: usize| c64::from_polar(1.0 / (1.0 + n as f64), (3 * n) as f64);
        let g: [c64; 16] = std::array::from_fn(entry);
        let k: [c64; 4] = std::array::from_fn(|i| levitation.gain(i, 7.0));
        let closed = ClosedResponse::new(&levitation, 7.0, &g);
        let near = |a: [c64; 16], b: [c64; 16]| a.iter().zip(b).all(|(a, b)| (a - b).norm() < 1e-13);
        let identity: [c64; 16] = std::array::from_fn(one);
        let before = std::array::from_fn(|n| one(n) - g[n] * k[n % 4]);
        let after = std::array::from_fn(|n| one(n) - k[n / 4] * g[n]);
        assert!(near(product(&closed.left, &before), identity));
        assert!(near(product(&after, &closed.right), identity));
        assert!(near(product(&g, &closed.right), closed.response));
    }
}
