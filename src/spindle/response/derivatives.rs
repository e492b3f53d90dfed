//! Derivatives of a receptance to the parameters of a machine: moduli, negative stiffness, damping ratios, mesh.

use super::adjoint::Adjoint;
use super::assembled::{Assembled, Planar};
use super::channels::{MAGNETS, ZERO};
use super::feedback::Feedback;
use super::parameters::{DAMPED_MODES, MachineParameters};
use crate::linalg::c64;
use crate::rotor::modes::RIGID;

impl Assembled {
    /// Coordinates behind the closed loops between outputs and inputs.
    pub(super) fn behind(&self, at: &Planar, w: f64, outs: &[usize], ins: &[usize]) -> Adjoint {
        let (p, d, n) = (self.driven, self.dynamic, outs.len());
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
        Adjoint {
            n,
            left: xl,
            right: xr,
            left_ports: left,
            right_ports: right,
        }
    }

    /// Derivatives to the logarithm of every modulus, then to the mesh; none when the hypothesis was assembled without
    /// derivatives.
    pub(super) fn strains(&self, behind: &Adjoint, w: f64) -> Vec<Vec<c64>> {
        let mut all = self.strain.as_ref().map_or(vec![], |s| s.slopes(behind));
        // Z − w⁴C where a stiffness is Z + K.
        for entry in all.last_mut().into_iter().flatten() {
            *entry *= -w.powi(4);
        }
        all
    }

    /// Derivatives to the nuisance parameters: moduli, ks, ln ζ and mesh, of which the strains are known.
    pub(super) fn small(
        &self,
        at: &Planar,
        w: f64,
        (outs, ins): (&[usize], &[usize]),
        behind: &Adjoint,
        strains: &[Vec<c64>],
        parameters: &MachineParameters,
    ) -> Vec<Vec<c64>> {
        let d = self.dynamic;
        let mut all = Vec::with_capacity(parameters.analytic());
        let (mesh, moduli) = strains.split_last().unzip();
        all.extend_from_slice(moduli.unwrap_or_default());
        for (port, ks) in MAGNETS.into_iter().zip(self.negative_stiffness()) {
            let entry = |o: usize, i: usize| at.entry(o, port) * at.entry(port, i) * ks;
            let pairs = outs.iter().flat_map(|o| ins.iter().map(move |i| (*o, *i)));
            all.push(pairs.map(|(o, i)| entry(o, i)).collect());
        }
        for mode in 0..DAMPED_MODES {
            let last = mode + 1 == DAMPED_MODES;
            let until = if last { d } else { RIGID + mode + 1 };
            let modes = (RIGID + mode).min(d)..until.min(d);
            all.push(self.through(behind, modes, |k| c64::new(0.0, w * self.damping.modal[k])));
        }
        all.extend(mesh.cloned());
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
