//! The loops of all rotors at a line, closed.

use super::loop_state::LoopState;
use super::matrix2::Matrix2;
use super::packed_loops::PackedState;
use super::specification_bound::Bound;
use crate::linalg::c64;
use crate::linalg::lanes::{Lanes, place};
use std::f64::consts::TAU;

/// A line with a controller.
pub(super) struct LineState {
    pub gain: Matrix2,
    /// The nominal loops and those of the specification, which come first among rotors × directions.
    pub nominal: Vec<LoopState>,
    /// The others.
    pub others: Vec<PackedState>,
    /// One for each loop of the specification.
    pub specification: Vec<Bound>,
}

impl LineState {
    /// Of the loop with a flat index: what one entry of a group is, or that of a nominal loop.
    #[inline]
    fn of(
        &self,
        side: usize,
        nominal: impl Fn(&LoopState) -> c64,
        packed: impl Fn(&PackedState) -> Lanes,
    ) -> c64 {
        match self.nominal.get(side) {
            Some(state) => nominal(state),
            None => {
                let (group, lane) = place(side - self.nominal.len());
                packed(&self.others[group]).lane(lane)
            }
        }
    }

    pub(super) fn determinant(&self, side: usize) -> c64 {
        self.of(side, |l| l.determinant, |l| l.determinant)
    }

    pub(super) fn compliance(&self, side: usize) -> c64 {
        self.of(side, |l| l.compliance, |l| l.compliance)
    }

    /// S_jj.
    pub(super) fn sensitivity(&self, side: usize, j: usize) -> c64 {
        self.of(side, |l| l.s[j][j], |l| l.sensitivity[j])
    }
}

/// Phase of det(I − G K) gathered over the lines, rad: that between the first and the last, and a turn for each time
/// that it passes the negative real axis.
pub(super) fn gathered_phase(lines: &[LineState], side: usize) -> f64 {
    let at = |line: &LineState| line.determinant(side);
    if !lines.iter().all(|line| at(line).is_finite()) {
        return f64::NAN;
    }
    let turns: i32 = lines
        .windows(2)
        .map(|pair| {
            let (a, b) = (at(&pair[0]), at(&pair[1]));
            let forwards = a.re * b.im - a.im * b.re;
            match (a.im >= 0.0, b.im >= 0.0) {
                (true, false) if forwards > 0.0 => 1,
                (false, true) if forwards < 0.0 => -1,
                _ => 0,
            }
        })
        .sum();
    // Minus zero counts as zero above.
    let phase = |line: Option<&LineState>| line.map_or(0.0, |l| (at(l).im + 0.0).atan2(at(l).re));
    TAU * f64::from(turns) + phase(lines.last()) - phase(lines.first())
}
