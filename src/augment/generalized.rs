//! The generalized plant P of robust control: inputs (w, u), outputs (z, y), u = K y closes it.

use super::uncertainty::Block;
use crate::lti::{Continuous, StateSpace};

/// Generalized plant with the partition of its channels and the structure that closes z → w.
#[derive(Clone, Debug)]
pub struct GeneralizedPlant {
    /// ẋ = A x + B₁ w + B₂ u; z = C₁ x + D₁₁ w + D₁₂ u; y = C₂ x + D₂₁ w + D₂₂ u.
    pub system: StateSpace<Continuous>,
    /// Number of control inputs u (the last inputs).
    pub controls: usize,
    /// Number of measurements y (the last outputs).
    pub measurements: usize,
    /// Structure of Δ, performance block last; Σ rows = dim w, Σ cols = dim z. Empty: one full block (plain H∞).
    pub blocks: Vec<Block>,
}

impl GeneralizedPlant {
    /// Number of exogenous inputs w.
    pub fn disturbances(&self) -> usize {
        self.system.inputs() - self.controls
    }

    /// Number of error outputs z.
    pub fn errors(&self) -> usize {
        self.system.outputs() - self.measurements
    }
}
