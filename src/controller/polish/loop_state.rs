//! A closed loop at one line.

use super::matrix2::{Matrix2, ONE, ZERO, close_loop, product, times};
use super::responses::LoopResponse;
use crate::linalg::c64;

/// The loop of one rotor and direction at a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct LoopState {
    /// S = (I − G K)⁻¹.
    pub s: Matrix2,
    /// R = K S, A/m.
    pub r: Matrix2,
    /// Compliance of the tool, m/N.
    pub compliance: c64,
}

impl LoopState {
    pub(super) const NOTHING: Self = Self { s: [[ZERO; 2]; 2], r: [[ZERO; 2]; 2], compliance: ZERO };

    /// The loop of `g` with the controller K = `gain`.
    pub(super) fn new(g: &LoopResponse, gain: &Matrix2) -> Self {
        let (_, s) = close_loop(&product(&g.loops, gain));
        let r = product(gain, &s);
        let u = times(&r, &g.read);
        Self { s, r, compliance: g.tool + g.drive[0] * u[0] + g.drive[1] * u[1] }
    }

    /// S_u = (I − K G)⁻¹ = I + R G with the loop G that this is the state of.
    pub(super) fn input_sensitivity(&self, g: &Matrix2) -> Matrix2 {
        let mut su = product(&self.r, g);
        su[0][0] += ONE;
        su[1][1] += ONE;
        su
    }
}
