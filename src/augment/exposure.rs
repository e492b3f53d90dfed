//! The open loop of a plane with every weighted signal at one frequency; the loss of a polish and μ over speed close it
//! with a controller.

use super::channels::{Channel, Wiring};
use super::plane::{LOADS, LOOPS};
use crate::linalg::{Mat, c64};

/// Rows (q of the modes, channels, displacements, currents, [signals y + n], signals y + n) and columns (v of the
/// modes, channels, loads, noise, currents) of a plane (v, loads, currents) → (q, displacements, signals).
pub(crate) struct Exposure {
    /// Modes and loads: rows of the plane above its signals, and its columns left of its currents.
    errors: usize,
    wiring: Wiring,
}

impl Exposure {
    /// For a plane with ports of so many modes; `integral` where the specification regulates the signals.
    pub(crate) fn new(modes: usize, channels: &[Channel], integral: bool) -> Self {
        let errors = modes + LOADS;
        let regulated = if integral { LOOPS } else { 0 };
        Self { errors, wiring: Wiring::new(modes, errors + LOOPS + regulated + LOOPS, channels) }
    }

    /// Rows that are weighted errors; the signals come after them.
    pub(crate) fn error_rows(&self) -> usize {
        self.wiring.rows.len() - LOOPS
    }

    /// Columns that are disturbances; the currents come after them.
    pub(crate) fn disturbance_columns(&self) -> usize {
        self.wiring.columns.len() - LOOPS
    }

    /// The matrix for the entries of the plane.
    pub(crate) fn matrix(&self, plane: impl Fn(usize, usize) -> c64) -> Mat<c64> {
        let (zero, one) = (c64::new(0.0, 0.0), c64::new(1.0, 0.0));
        let errors = self.errors;
        let unit = |here: bool| if here { one } else { zero };
        // Columns (v, loads, noise, currents).
        let entry = |row: usize, j: usize| match j {
            j if j < errors => plane(row, j),
            j if j < errors + LOOPS => zero,
            j => plane(row, j - LOOPS),
        };
        self.wiring.matrix(&zero, |i, j| match i {
            i if i < errors => entry(i, j),
            i if i < errors + LOOPS => unit(j == i + LOOPS),
            i => {
                let k = (i - errors) % LOOPS;
                entry(errors + k, j) + unit(j == errors + k)
            }
        })
    }
}
