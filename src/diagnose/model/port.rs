//! What further ports see: the receptance between chosen places of the shaft, magnets closed, with its derivatives.
//!
//! A law Δ(jω) at places with displacements q changes the receptance to  H + B (Δ⁻¹ − G)⁻¹ C,  B = ∂x/∂f_q, C = ∂x_q/∂f, G = ∂x_q/∂f_q: with the
//! places among the ports, B, C and G are entries of one matrix, and so are their derivatives  −L dK R.

use super::super::DiagnoseError;
use super::super::chain::Chain;
use super::super::nuisance::Layout;
use super::super::skeleton::Skeleton;
use super::{Assembled, IN, OUT, SIDE, Square, ZERO};
use crate::linalg::c64;

/// A further port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Probe {
    /// Displacement at a position, m.
    Station(f64),
    /// Slope of the shaft at a position.
    Slope(f64),
    /// Curvature of the shaft at a position.
    Curvature(f64),
    /// What another mesh may read more at a position.
    Misread(f64),
    /// Tool against nose, across.
    JointAcross,
    /// Tool against nose, turning.
    JointTurning,
}

impl Probe {
    pub(super) fn row(self, skeleton: &Skeleton) -> Result<Vec<f64>, DiagnoseError> {
        let joint = |i: usize| {
            skeleton
                .joint
                .as_ref()
                .and_then(|rows| rows.get(i).cloned())
                .unwrap_or_else(|| vec![0.0; skeleton.len()])
        };
        Ok(match self {
            Self::Station(z) => skeleton.row(z)?,
            Self::Misread(z) => skeleton
                .misread(z)?
                .unwrap_or_else(|| vec![0.0; skeleton.len()]),
            Self::JointAcross => joint(0),
            Self::JointTurning => joint(1),
            Self::Slope(z) => skeleton.slope_row(z)?,
            Self::Curvature(z) => skeleton.curvature_row(z)?,
        })
    }
}

/// Receptance between places at one signed frequency: rows front sensor, rear sensor, tool, then the further ones; columns front
/// bearing, rear bearing, tool, then the further ones.
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
    /// Number of ports; those of the probes are the last.
    pub fn ports(&self) -> usize {
        self.ports.len()
    }

    /// Ports of the two magnets.
    pub const MAGNETS: [usize; 2] = [1, 2];

    /// Negative stiffness, front and rear, N/m.
    pub fn negative_stiffness(&self) -> [f64; 2] {
        [0, 1].map(|b| self.electronics.effective.bearings[b].ks_n_per_m)
    }

    /// Whether x and y are coupled.
    pub fn coupled(&self) -> bool {
        self.coupled
    }

    /// The electronics at a line.
    pub fn chain(&self, omega_rad_s: f64) -> Chain {
        self.electronics.chain(omega_rad_s)
    }

    /// F of a receptance between sensors, tool and bearings.
    pub fn response(chain: &Chain, plus: &Ported, minus: Option<&Ported>) -> Square {
        let minus = minus.map(|m| m.block(&m.response));
        chain.apply(&plus.block(&plus.response), minus.as_ref())
    }

    /// Receptance at a signed frequency with the further ports `extra`; with derivatives when there is a layout.
    pub fn ported(&self, w: f64, extra: &[usize], layout: Option<&Layout>) -> Ported {
        let at = self.planar(w);
        let outs: Vec<usize> = OUT.iter().chain(extra).copied().collect();
        let ins: Vec<usize> = IN.iter().chain(extra).copied().collect();
        let (p, side) = (self.ports.len(), outs.len());
        let mut response = Vec::with_capacity(side * side);
        for out in &outs {
            response.extend(ins.iter().map(|i| at.closed[out * p + i]));
        }
        let slopes = layout.map_or(vec![], |layout| {
            let behind = self.behind(&at, w, &outs, &ins);
            let strains = self.strains(&behind, w);
            self.small(&at, w, (&outs, &ins), &behind, &strains, layout)
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
    pub fn block(&self, of: &[c64]) -> [c64; 9] {
        std::array::from_fn(|n| of[n / 3 * self.side + n % 3])
    }

    /// An entry.
    pub fn at(&self, row: usize, column: usize) -> c64 {
        self.response[row * self.side + column]
    }
}

/// Derivative of F to ln ki or the logarithm of a sensor gain, a factor on columns or rows.
pub fn factor(f: &Square, of_rows: bool, bearing: usize) -> Square {
    std::array::from_fn(|n| {
        let index = if of_rows { n / SIDE } else { n % SIDE };
        if index / 2 == bearing { f[n] } else { ZERO }
    })
}
