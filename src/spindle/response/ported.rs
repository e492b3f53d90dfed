//! The receptance between chosen places of the shaft, magnets closed, with its derivatives.
//!
//! A law Δ(jω) at places with displacements q changes the receptance to  H + B (Δ⁻¹ − G)⁻¹ C,  B = ∂x/∂f_q, C =
//! ∂x_q/∂f, G = ∂x_q/∂f_q: with the places among the ports, B, C and G are entries of one matrix, and so are their
//! derivatives  −L dK R.

use super::assembled::Assembled;
use super::channels::{IN, OUT, SIDE, Square, ZERO};
use super::electronics::ElectronicsLine;
use super::parameters::MachineParameters;
use crate::linalg::c64;

/// Receptance between places at one signed frequency: rows front sensor, rear sensor, tool, then the further ones;
/// columns front bearing, rear bearing, tool, then the further ones.
#[derive(Clone, Debug)]
pub struct Ported {
    /// Rows and columns.
    pub side: usize,
    /// Entries, row-major.
    pub response: Vec<c64>,
    /// Derivatives to moduli, to ln ks front and rear, to ln ζ, and to the mesh, in that order.
    pub slopes: Vec<Vec<c64>>,
}

impl Assembled {
    /// The electronics at a line.
    pub(crate) fn electronics_line(&self, omega_rad_s: f64) -> ElectronicsLine {
        ElectronicsLine::new(&self.effective, omega_rad_s)
    }

    /// F of a receptance between sensors, tool and bearings.
    pub fn response(
        electronics: &ElectronicsLine,
        plus: &Ported,
        minus: Option<&Ported>,
    ) -> Square {
        let minus = minus.map(|m| m.block(&m.response));
        electronics.apply(&plus.block(&plus.response), minus.as_ref())
    }

    /// Receptance at a signed frequency with the further ports `extra`; with derivatives when there are parameters.
    pub(crate) fn ported(
        &self,
        w: f64,
        extra: &[usize],
        parameters: Option<&MachineParameters>,
    ) -> Ported {
        let at = self.planar(w);
        let outs: Vec<usize> = OUT.iter().chain(extra).copied().collect();
        let ins: Vec<usize> = IN.iter().chain(extra).copied().collect();
        let side = outs.len();
        let mut response = Vec::with_capacity(side * side);
        for out in &outs {
            response.extend(ins.iter().map(|i| at.entry(*out, *i)));
        }
        let slopes = parameters.map_or(vec![], |parameters| {
            let behind = self.behind(&at, w, &outs, &ins);
            let strains = self.strains(&behind, w);
            self.small(&at, w, (&outs, &ins), &behind, &strains, parameters)
        });
        Ported {
            side,
            response,
            slopes,
        }
    }
}

impl Ported {
    /// The 3×3 part between sensors, tool and bearings of a matrix of this shape.
    pub(crate) fn block(&self, of: &[c64]) -> [c64; 9] {
        std::array::from_fn(|n| of[n / 3 * self.side + n % 3])
    }

    /// An entry.
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
