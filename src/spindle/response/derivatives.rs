//! Derivatives of a receptance to the parameters of a machine: moduli, negative stiffness, damping ratios, mesh.

use super::adjoint::Adjoint;
use super::assembled::{Assembled, PlanarLine};
use super::channels::{MAGNETS, ZERO};
use super::feedback::Feedback;
use super::parameters::{DAMPED_MODES, MachineParameters};
use crate::linalg::c64;
use crate::rotor::modes::RIGID;

impl Assembled {
    /// Coordinates behind the closed loops between outputs and inputs.
    pub(super) fn behind(&self, at: &PlanarLine, w: f64, outs: &[usize], ins: &[usize]) -> Adjoint {
        let (left, right) = self.forces(at, w, outs, ins);
        self.adjoint(at, outs.len(), left, right)
    }

    /// Forces at the ports of a force at each output, outputs × ports, and of each input, ports × inputs.
    pub(super) fn forces(&self, at: &PlanarLine, w: f64, outs: &[usize], ins: &[usize]) -> (Vec<c64>, Vec<c64>) {
        let (p, n) = (self.driven, outs.len());
        let gains = self.gains(w);
        let (mut left, mut right) = (vec![ZERO; n * p], vec![ZERO; p * n]);
        for (o, out) in outs.iter().enumerate() {
            left[o * p + out] += 1.0;
            for (Feedback { port, .. }, gain) in self.feedback.iter().zip(&gains) {
                left[o * p + port] += at.entry(*out, *port) * gain;
            }
        }
        for (i, input) in ins.iter().enumerate() {
            right[input * n + i] += 1.0;
            for (Feedback { port, .. }, gain) in self.feedback.iter().zip(&gains) {
                right[port * n + i] += gain * at.entry(*port, *input);
            }
        }
        (left, right)
    }

    /// Coordinates behind forces at the ports, `left` n × ports and `right` ports × n.
    pub(super) fn adjoint(&self, at: &PlanarLine, n: usize, left: Vec<c64>, right: Vec<c64>) -> Adjoint {
        let (p, d) = (self.driven, self.dynamic);
        let (mut xl, mut xr) = (vec![ZERO; n * d], vec![ZERO; d * n]);
        for k in 0..d {
            for o in 0..n {
                let mut sum = (ZERO, ZERO);
                for q in 0..p {
                    let x = at.x[k * p + q];
                    sum.0 += left[o * p + q] * x;
                    sum.1 += x * right[q * n + o];
                }
                xl[o * d + k] = sum.0;
                xr[k * n + o] = sum.1;
            }
        }
        Adjoint { n, left: xl, right: xr, left_ports: left, right_ports: right }
    }

    /// Derivatives to the logarithm of every modulus, then to the mesh, each n × n, one behind the other; none when the
    /// hypothesis was assembled without derivatives.
    pub(super) fn strains(&self, behind: &Adjoint, w: f64) -> Vec<c64> {
        let mut all = self.strain.as_ref().map_or(vec![], |s| s.slopes(behind));
        let mesh = all.len().saturating_sub(behind.n * behind.n);
        // Z − w⁴C where a stiffness is Z + K.
        for entry in &mut all[mesh..] {
            *entry *= -w.powi(4);
        }
        all
    }

    /// Closed receptances from each magnet, outputs × inputs: through its port.
    pub(super) fn through_magnets(&self, at: &PlanarLine, outs: &[usize], ins: &[usize]) -> [Vec<c64>; 2] {
        MAGNETS.map(|port| {
            let pairs = outs.iter().flat_map(|o| ins.iter().map(move |i| (*o, *i)));
            pairs.map(|(o, i)| at.entry(o, port) * at.entry(port, i)).collect()
        })
    }

    /// Derivatives to the nuisance parameters: moduli, ks, ln ζ and mesh, each n × n, one behind the other. The strains
    /// and what goes through the magnets are known.
    pub(super) fn small(
        &self,
        w: f64,
        behind: &Adjoint,
        strains: &[c64],
        through_magnets: &[Vec<c64>; 2],
        parameters: &MachineParameters,
    ) -> Vec<c64> {
        let (d, size) = (self.dynamic, behind.n * behind.n);
        let mut all = Vec::with_capacity(parameters.analytic() * size);
        let (moduli, mesh) = strains.split_at(strains.len().saturating_sub(size));
        all.extend_from_slice(moduli);
        for (through, ks) in through_magnets.iter().zip(self.negative_stiffness()) {
            all.extend(through.iter().map(|h| h * ks));
        }
        for mode in 0..DAMPED_MODES {
            let last = mode + 1 == DAMPED_MODES;
            let until = if last { d } else { RIGID + mode + 1 };
            let modes = (RIGID + mode).min(d)..until.min(d);
            all.extend(self.through(behind, modes, |k| c64::new(0.0, w * self.damping.modal[k])));
        }
        all.extend_from_slice(mesh);
        all
    }

    /// −X_l dZ X_r of a diagonal dZ, n × n.
    pub(super) fn through(
        &self,
        behind: &Adjoint,
        modes: std::ops::Range<usize>,
        change: impl Fn(usize) -> c64,
    ) -> Vec<c64> {
        let (n, d) = (behind.n, self.dynamic);
        let mut slope = vec![ZERO; n * n];
        for k in modes {
            let own = change(k);
            for o in 0..n {
                for i in 0..n {
                    slope[o * n + i] -= behind.left[o * d + k] * own * behind.right[k * n + i];
                }
            }
        }
        slope
    }
}
