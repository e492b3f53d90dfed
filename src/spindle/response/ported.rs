//! The receptance between chosen places of the shaft, magnets closed, with its derivatives.
//!
//! A law Δ(jω) at places with displacements q changes the receptance to  H + B (Δ⁻¹ − G)⁻¹ C,  B = ∂x/∂f_q, C =
//! ∂x_q/∂f, G = ∂x_q/∂f_q: with the places among the ports, B, C and G are entries of one matrix, and so are their
//! derivatives  −L dK R.

use super::assembled::{Assembled, PlanarLine};
use super::channels::{IN, MAGNETS, OUT, SIDE, Square, ZERO};
use super::electronics::ElectronicsLine;
use super::parameters::MachineParameters;
use crate::linalg::c64;

/// Receptance between places at one signed frequency: rows front sensor, rear sensor, tool, then the further ones;
/// columns front bearing, rear bearing, tool, then the further ones.
pub(crate) struct Ported {
    /// Rows and columns.
    pub side: usize,
    /// Entries, row-major.
    pub response: Vec<c64>,
    at: PlanarLine,
    w: f64,
    outs: Vec<usize>,
    ins: Vec<usize>,
}

impl Assembled {
    pub(crate) fn electronics_line(&self, omega_rad_s: f64) -> ElectronicsLine {
        ElectronicsLine::new(&self.effective, omega_rad_s)
    }

    /// F of a receptance between sensors, tool and bearings.
    pub(crate) fn response(electronics: &ElectronicsLine, plus: &Ported, minus: Option<&Ported>) -> Square {
        let minus = minus.map(|m| m.block(&m.response));
        electronics.apply(&plus.block(&plus.response), minus.as_ref())
    }

    /// Receptance at a signed frequency with the further ports `extra`.
    pub(crate) fn reduce_to_ports(&self, w: f64, extra: &[usize]) -> Ported {
        let at = self.planar(w);
        let outs: Vec<usize> = OUT.iter().chain(extra).copied().collect();
        let ins: Vec<usize> = IN.iter().chain(extra).copied().collect();
        let side = outs.len();
        let mut response = Vec::with_capacity(side * side);
        for out in &outs {
            response.extend(ins.iter().map(|i| at.entry(*out, *i)));
        }
        Ported { side, response, at, w, outs, ins }
    }

    /// Derivatives of L H R of this receptance H, two rows by two columns, to moduli, ln ks front and rear, ln ζ and
    /// mesh in that order; L is 2 × side, R side × 2.
    pub(crate) fn ported_slopes(
        &self,
        ported: &Ported,
        left: &[c64],
        right: &[c64],
        parameters: &MachineParameters,
    ) -> Vec<[c64; 4]> {
        let Ported { side, at, w, outs, ins, .. } = ported;
        let (forces, reach) = self.forces(at, *w, outs, ins);
        let ports = reach.len() / side;
        let forces = product(left, &forces, 2, *side, ports);
        let reach = product(&reach, right, ports, *side, 2);
        let behind = self.adjoint(at, 2, forces, reach);
        let strains = self.strains(&behind, *w);
        let through_magnets = MAGNETS.map(|port| {
            let from = |o: usize| (0..*side).fold(ZERO, |s, a| s + left[o * side + a] * at.entry(outs[a], port));
            let to = |i: usize| (0..*side).fold(ZERO, |s, b| s + at.entry(port, ins[b]) * right[2 * b + i]);
            let (from, to) = ([from(0), from(1)], [to(0), to(1)]);
            (0..4).map(|n| from[n / 2] * to[n % 2]).collect()
        });
        let slopes = self.small(*w, &behind, &strains, &through_magnets, parameters);
        let each = slopes.chunks_exact(4);
        each.map(|s| std::array::from_fn(|n| s[n])).collect()
    }
}

/// Product of two row-major matrices, rows × inner and inner × columns.
pub(crate) fn product(a: &[c64], b: &[c64], rows: usize, inner: usize, columns: usize) -> Vec<c64> {
    let mut c = vec![ZERO; rows * columns];
    for i in 0..rows {
        for l in 0..inner {
            let factor = a[i * inner + l];
            if factor != ZERO {
                for j in 0..columns {
                    c[i * columns + j] += factor * b[l * columns + j];
                }
            }
        }
    }
    c
}

impl Ported {
    /// The 3×3 part between sensors, tool and bearings of a matrix of this shape.
    pub(crate) fn block(&self, of: &[c64]) -> [c64; 9] {
        std::array::from_fn(|n| of[n / 3 * self.side + n % 3])
    }

    pub(crate) fn at(&self, row: usize, column: usize) -> c64 {
        self.response[row * self.side + column]
    }
}

/// Derivative of F to ln ki or the logarithm of a sensor gain, a factor on columns or rows.
pub(crate) fn factor(f: &Square, of_rows: bool, bearing: usize) -> Square {
    std::array::from_fn(|n| {
        let index = if of_rows { n / SIDE } else { n % SIDE };
        if index / 2 == bearing { f[n] } else { ZERO }
    })
}
