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

/// Turns of both directions of whirl, of which one may stand for both, by the numbers of each in their order; NaN where
/// one is not finite.
pub(crate) fn turns_of<T: Iterator<Item = c64>>(
    directions: impl ExactSizeIterator<Item = T>,
) -> f64 {
    let share = 2.0 / directions.len() as f64;
    let phase: f64 = directions.map(gathered_phase).sum();
    (share * phase / TAU).round()
}

/// Phase that complex numbers gather in their order, rad: that between the first and the last, and a turn for each time
/// that they pass the negative real axis. NaN where one is not finite.
fn gathered_phase(mut values: impl Iterator<Item = c64>) -> f64 {
    let Some(first) = values.next() else {
        return 0.0;
    };
    let (mut last, mut turns, mut finite) = (first, 0, first.is_finite());
    for value in values {
        let forwards = last.re * value.im - last.im * value.re;
        turns += match (last.im >= 0.0, value.im >= 0.0) {
            (true, false) if forwards > 0.0 => 1,
            (false, true) if forwards < 0.0 => -1,
            _ => 0,
        };
        finite &= value.is_finite();
        last = value;
    }
    if !finite {
        return f64::NAN;
    }
    // Minus zero counts as zero above.
    let phase = |z: c64| (z.im + 0.0).atan2(z.re);
    TAU * f64::from(turns) + phase(last) - phase(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phase_gathered_is_the_sum_of_the_angles_between_neighbours() {
        for (turns, count) in [(0.3, 7), (-2.4, 40), (5.0, 64), (1.0, 9), (-0.5, 5)] {
            let at = |k: usize| {
                c64::from_polar(
                    1.0 + k as f64,
                    0.7 + TAU * turns * k as f64 / (count - 1) as f64,
                )
            };
            let found = gathered_phase((0..count).map(at));
            let exact: f64 = (1..count).map(|k| (at(k) / at(k - 1)).arg()).sum();
            assert!((found - exact).abs() < 1e-12, "{found} and {exact}");
        }
        assert_eq!(gathered_phase(std::iter::empty()), 0.0);
        assert!(gathered_phase([c64::new(1.0, f64::NAN)].into_iter()).is_nan());
    }
}
