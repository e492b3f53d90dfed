//! Where the loop with real parameters at a vertex has a real eigenvalue.

use crate::linalg::{Mat, c64};

/// A frequency where an eigenvalue of ΔM(jω) is real for Δ at a vertex of the real parameters.
#[derive(Clone, Debug)]
pub(super) struct RealCrossing {
    /// rad/s.
    pub omega_rad_s: f64,
    /// ±1 for real parameters, 0 elsewhere, w×z.
    pub delta: Mat<c64>,
    pub value: c64,
}
