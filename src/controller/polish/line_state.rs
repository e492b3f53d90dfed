//! The loops of all rotors at a line, closed.

use super::loop_state::LoopState;
use super::matrix2::Matrix2;
use super::packed_loops::PackedState;
use super::specification_bound::Bound;
use crate::linalg::c64;
use crate::linalg::lanes::{Lanes, place};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// All lines with a controller, a part of them after the other.
pub(super) struct ClosedLines(Vec<LinePart>);

/// Some neighbouring lines: of each the same number of loops.
#[derive(Default)]
pub(super) struct LinePart {
    pub gains: Vec<Matrix2>,
    pub nominal: Vec<LoopState>,
    /// The other loops, four in a group.
    pub others: Vec<PackedState>,
    pub specification: Vec<Bound>,
    pub squares: Vec<MeanSquares>,
    /// How many of each of the four lists above belong to a line.
    each: [usize; 4],
}

/// A line with a controller.
#[derive(Clone, Copy)]
pub(super) struct LineState<'a> {
    pub gain: &'a Matrix2,
    /// The nominal loops and those of the specification, which come first among rotors × directions.
    pub nominal: &'a [LoopState],
    /// One for each loop of the specification.
    pub specification: &'a [Bound],
    /// One for each rotor.
    pub squares: &'a [MeanSquares],
}

/// Of a rotor |mean over its directions of whirl|².
#[derive(Clone, Copy, Debug)]
pub(super) struct MeanSquares {
    /// Compliance of the tool, (m/N)².
    pub compliance: f64,
    /// S₁₁ and S₂₂.
    pub sensitivity: [f64; 2],
}

/// Lines of a part.
const PART: usize = 32;

impl LinePart {
    /// Adds what the last line, whose loops stand here already, comes to for rotors with these flat indices.
    pub(super) fn add_squares(&mut self, first: (usize, usize), sides: &[Range<usize>]) {
        let (nominal, others) = (&self.nominal[first.0..], &self.others[first.1..]);
        let squares = sides.iter().map(|sides| MeanSquares {
            compliance: mean_square(sides, |side| {
                of_loop((nominal, others), side, |l| l.compliance, |l| l.compliance)
            }),
            sensitivity: [0, 1].map(|j| {
                mean_square(sides, |side| {
                    of_loop((nominal, others), side, |l| l.s[j][j], |l| l.sensitivity[j])
                })
            }),
        });
        self.squares.extend(squares);
    }
}

/// Of the loop of a line with a flat index: that of a nominal loop, or one entry of a group of the others.
#[inline]
fn of_loop(
    (nominal, others): (&[LoopState], &[PackedState]),
    side: usize,
    own: impl Fn(&LoopState) -> c64,
    packed: impl Fn(&PackedState) -> Lanes,
) -> c64 {
    match nominal.get(side) {
        Some(state) => own(state),
        None => {
            let (group, lane) = place(side - nominal.len());
            packed(&others[group]).lane(lane)
        }
    }
}

/// |mean over some loops|².
#[inline]
fn mean_square(sides: &Range<usize>, of: impl Fn(usize) -> c64) -> f64 {
    let sum = sides
        .clone()
        .fold(c64::new(0.0, 0.0), |sum, side| sum + of(side));
    sum.norm_sqr() / (sides.len() * sides.len()) as f64
}

impl ClosedLines {
    /// So many lines, each added to its part.
    pub(super) fn collect(lines: usize, add: impl Fn(&mut LinePart, usize) + Sync) -> Self {
        let parts = (0..lines.div_ceil(PART)).into_par_iter();
        let part = |number: usize| {
            let mut part = LinePart::default();
            for line in number * PART..lines.min((number + 1) * PART) {
                add(&mut part, line);
            }
            part.counted()
        };
        Self(parts.map(part).collect())
    }

    /// A line.
    pub(super) fn line(&self, line: usize) -> LineState<'_> {
        self.0[line / PART].line(line % PART)
    }

    /// All lines in their order.
    pub(super) fn all(&self) -> impl Iterator<Item = LineState<'_>> {
        let parts = self.0.iter();
        parts.flat_map(|part| (0..part.gains.len()).map(|k| part.line(k)))
    }

    /// det(I − G K) of the loop with a flat index at all lines, without integrators.
    pub(super) fn determinants(&self, side: usize) -> impl Iterator<Item = c64> {
        let parts = self.0.iter();
        parts.flat_map(move |part| (0..part.gains.len()).map(move |k| part.determinant(k, side)))
    }

    /// A bound of the specification at a line.
    pub(super) fn specification_mut(&mut self, line: usize, number: usize) -> &mut Bound {
        let part = &mut self.0[line / PART];
        let [_, _, each, _] = part.each;
        &mut part.specification[line % PART * each + number]
    }
}

impl LinePart {
    fn line(&self, k: usize) -> LineState<'_> {
        let [nominal, _, specification, squares] = self.each;
        LineState {
            gain: &self.gains[k],
            nominal: &self.nominal[k * nominal..(k + 1) * nominal],
            specification: &self.specification[k * specification..(k + 1) * specification],
            squares: &self.squares[k * squares..(k + 1) * squares],
        }
    }

    /// With the numbers that belong to a line.
    fn counted(mut self) -> Self {
        let lines = self.gains.len().max(1);
        let (others, specification) = (self.others.len(), self.specification.len());
        self.each = [
            self.nominal.len(),
            others,
            specification,
            self.squares.len(),
        ];
        self.each = self.each.map(|all| all / lines);
        self
    }

    /// det(I − G K) of the loop with a flat index, without integrators.
    #[inline]
    fn determinant(&self, line: usize, side: usize) -> c64 {
        let [nominal, others, ..] = self.each;
        let loops = (
            &self.nominal[line * nominal..(line + 1) * nominal],
            &self.others[line * others..(line + 1) * others],
        );
        of_loop(loops, side, |l| l.determinant, |l| l.determinant)
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
        let (was_above, is_above) = (last.im >= 0.0, value.im >= 0.0);
        turns += i32::from(was_above & !is_above & (forwards > 0.0));
        turns -= i32::from(!was_above & is_above & (forwards < 0.0));
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
