//! A closed loop at one line.

use super::matrix2::Matrix2;
use crate::linalg::c64;

/// The loop of one rotor and direction at a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct LoopState {
    /// det(I − G K) without integrators.
    pub determinant: c64,
    /// S = (I − G K)⁻¹.
    pub s: Matrix2,
    /// S_u = (I − K G)⁻¹.
    pub su: Matrix2,
    /// Compliance of the tool, m/N.
    pub compliance: c64,
}
