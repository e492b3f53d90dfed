//! Scales of the modal channels at a line.

use crate::linalg::lanes::{Reals, real_group};

/// Scales of the modal channels at a line, for a bound of its specification.
#[derive(Clone, Debug)]
pub(crate) struct LineScales {
    /// One per block, the last (performance) 1.
    d: Vec<f64>,
}

impl LineScales {
    /// A scale per block, the last (performance) 1; modal channels come first, one each.
    pub(super) fn new(d: Vec<f64>) -> Self {
        Self { d }
    }

    /// One per block.
    pub(super) fn list(&self) -> &[f64] {
        &self.d
    }

    pub(super) fn modal(&self) -> usize {
        self.d.len().saturating_sub(1)
    }

    /// Scale of a row or of a column.
    pub(super) fn of(&self, i: usize) -> f64 {
        if i < self.modal() { self.d[i] } else { 1.0 }
    }

    /// Scales of the rows in a group.
    pub(super) fn group(&self, g: usize) -> Reals {
        real_group(g, |i| self.of(i))
    }
}
