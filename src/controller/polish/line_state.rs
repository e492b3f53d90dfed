//! The loops of all rotors at a line, closed.

use super::matrix2::{Matrix2, ONE};
use super::packed_loops::PackedState;
use super::specification_bound::Bound;
use super::values::nan_max;
use crate::linalg::c64;
use crate::linalg::lanes::{Lanes, WIDTH};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// All lines with a controller, a part of them after the other.
pub(super) struct ClosedLines(Vec<LinePart>);

/// Some neighbouring lines: of each the same number of loops.
pub(super) struct LinePart {
    /// Number of the first line.
    pub first: usize,
    pub gains: Vec<Matrix2>,
    /// det(I − G K) without integrators, of packs of four loops.
    pub determinants: Vec<Lanes>,
    /// Of groups of four rotors.
    pub squares: Vec<PackedSquares>,
    /// Over the lines, of each group of rotors.
    pub largest: Vec<PackedLargest>,
    pub specification: Vec<Bound>,
}

/// A line with a controller.
#[derive(Clone, Copy)]
pub(super) struct LineState<'a> {
    pub gain: &'a Matrix2,
    /// One for each loop of the specification.
    pub specification: &'a [Bound],
}

/// Of each of four rotors |mean over its directions of whirl|².
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedSquares {
    /// Compliance of the tool, (m/N)².
    pub compliance: [f64; WIDTH],
    /// S₁₁ and S₂₂.
    pub sensitivity: [[f64; WIDTH]; 2],
}

/// Of each of four rotors what its lines come to.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedLargest {
    /// Largest square of the compliance in the band of the stiffness, (m/N)².
    pub compliance: [f64; WIDTH],
    /// Largest square of S₁₁ or S₂₂.
    pub sensitivity: [f64; WIDTH],
    /// Both currents by white noise of unit strength, squared, of nominal rotors.
    pub noise: [[f64; WIDTH]; 2],
}

/// Sums over the directions of whirl of four rotors at a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct DirectionSums {
    compliance: Lanes,
    sensitivity: [Lanes; 2],
}

/// Lines of a part.
const PART: usize = 32;

impl DirectionSums {
    pub(super) const ZERO: Self = Self {
        compliance: Lanes::ZERO,
        sensitivity: [Lanes::ZERO; 2],
    };

    #[inline]
    pub(super) fn with(&self, loops: &PackedState) -> Self {
        let sum = |a: &Lanes, b: &Lanes| a.plus(ONE, b);
        Self {
            compliance: sum(&self.compliance, &loops.compliance),
            sensitivity: [0, 1].map(|j| sum(&self.sensitivity[j], &loops.sensitivity[j])),
        }
    }

    /// Of sums over so many directions.
    #[inline]
    pub(super) fn mean_squares(&self, directions: usize) -> PackedSquares {
        let share = 1.0 / (directions * directions) as f64;
        let mean = |sum: &Lanes| sum.squares().map(|square| share * square);
        PackedSquares {
            compliance: mean(&self.compliance),
            sensitivity: self.sensitivity.each_ref().map(mean),
        }
    }
}

impl PackedLargest {
    const NOTHING: Self = Self {
        compliance: [0.0; WIDTH],
        sensitivity: [0.0; WIDTH],
        noise: [[0.0; WIDTH]; 2],
    };

    /// Adds a line, which may be in the band of the stiffness.
    #[inline]
    pub(super) fn add(&mut self, squares: &PackedSquares, is_in_band: bool) {
        let [front, rear] = &squares.sensitivity;
        self.sensitivity = larger(&larger(&self.sensitivity, front), rear);
        if is_in_band {
            self.compliance = larger(&self.compliance, &squares.compliance);
        }
    }

    /// Adds the squares of the currents at a line to those by noise, with the share of the band that the line stands
    /// for.
    #[inline]
    pub(super) fn add_noise(&mut self, share: f64, currents: &[[f64; WIDTH]; 2]) {
        for (sum, own) in self.noise.iter_mut().zip(currents) {
            *sum = std::array::from_fn(|l| sum[l] + share * own[l]);
        }
    }
}

/// The larger of four pairs.
#[inline]
fn larger(a: &[f64; WIDTH], b: &[f64; WIDTH]) -> [f64; WIDTH] {
    std::array::from_fn(|l| nan_max(a[l], b[l]))
}

impl ClosedLines {
    /// So many lines, each added to its part; of `groups` of rotors with `packs` of loops.
    pub(super) fn collect(
        lines: usize,
        (groups, packs): (usize, usize),
        add: impl Fn(&mut LinePart, usize) + Sync,
    ) -> Self {
        let parts = (0..lines.div_ceil(PART)).into_par_iter();
        let part = |number: usize| {
            let own = number * PART..lines.min((number + 1) * PART);
            let mut part = LinePart {
                first: own.start,
                gains: Vec::with_capacity(own.len()),
                determinants: Vec::with_capacity(packs * own.len()),
                squares: Vec::with_capacity(groups * own.len()),
                largest: vec![PackedLargest::NOTHING; groups],
                specification: vec![],
            };
            for line in own {
                add(&mut part, line);
            }
            part
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

    /// The parts in their order.
    pub(super) fn parts(&self) -> &[LinePart] {
        &self.0
    }

    /// Phases that det(I − G K) of the loops of a pack gathers over all lines, rad.
    pub(super) fn phases(&self, pack: usize) -> [f64; WIDTH] {
        let parts = self.0.iter();
        gathered_phases(parts.flat_map(|part| {
            let packs = part.determinants.len() / part.gains.len().max(1);
            let own = part.determinants.iter().skip(pack);
            own.step_by(packs.max(1))
        }))
    }

    /// A bound of the specification at a line.
    pub(super) fn specification_mut(&mut self, line: usize, number: usize) -> &mut Bound {
        let part = &mut self.0[line / PART];
        let each = part.specification.len() / part.gains.len().max(1);
        &mut part.specification[line % PART * each + number]
    }
}

impl LinePart {
    fn line(&self, k: usize) -> LineState<'_> {
        let each = self.specification.len() / self.gains.len().max(1);
        LineState {
            gain: &self.gains[k],
            specification: &self.specification[k * each..(k + 1) * each],
        }
    }
}

/// Turns of both directions of whirl, of which one may stand for both, by the phase that each gathers; NaN where one is
/// not a number.
pub(crate) fn turns_of(directions: impl ExactSizeIterator<Item = f64>) -> f64 {
    let share = 2.0 / directions.len() as f64;
    let phase: f64 = directions.sum();
    (share * phase / TAU).round()
}

/// Phases that four sequences of complex numbers gather in their order, rad: that between the first and the last, and a
/// turn for each time that they pass the negative real axis. NaN where one is not finite.
pub(crate) fn gathered_phases<'a>(mut values: impl Iterator<Item = &'a Lanes>) -> [f64; WIDTH] {
    let Some(first) = values.next() else {
        return [0.0; WIDTH];
    };
    let (mut last, mut turns, mut unbounded) = (first, [0.0; WIDTH], [0.0; WIDTH]);
    for value in values {
        let ((x, y), (re, im)) = (last.parts(), value.parts());
        for l in 0..WIDTH {
            let forwards = x[l] * im[l] - y[l] * re[l];
            let up = f64::from(u8::from((y[l] < 0.0) & (im[l] >= 0.0) & (forwards < 0.0)));
            let down = f64::from(u8::from((y[l] >= 0.0) & (im[l] < 0.0) & (forwards > 0.0)));
            turns[l] += down - up;
            // Zero, or not a number.
            unbounded[l] += 0.0 * (re[l] + im[l]);
        }
        last = value;
    }
    std::array::from_fn(|l| {
        let ends = [first.lane(l), last.lane(l)];
        if unbounded[l] != 0.0 || !ends[0].is_finite() {
            return f64::NAN;
        }
        TAU * turns[l] + phase(ends[1]) - phase(ends[0])
    })
}

/// Angle of a number, which is not negative where its imaginary part is zero.
fn phase(z: c64) -> f64 {
    (z.im + 0.0).atan2(z.re)
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
            let exact: f64 = (1..count).map(|k| (at(k) / at(k - 1)).arg()).sum();
            let backwards = |k: usize| at(count - 1 - k);
            let four = |k: usize| {
                Lanes::from_fn(|l| match l {
                    0 => at(k),
                    1 => backwards(k),
                    2 => at(k).conj(),
                    _ => c64::new(1.0, if k == 3 { f64::NAN } else { 0.0 }),
                })
            };
            let list: Vec<Lanes> = (0..count).map(four).collect();
            let phases = gathered_phases(list.iter());
            for (found, exact) in phases.iter().zip([exact, -exact, -exact]) {
                assert!((found - exact).abs() < 1e-12, "{found} and {exact}");
            }
            assert!(phases[3].is_nan());
        }
        assert_eq!(gathered_phases(std::iter::empty()), [0.0; WIDTH]);
        let infinite = Lanes::from_fn(|_| c64::new(1.0, f64::INFINITY));
        let phases = gathered_phases([infinite].iter());
        assert!(phases.into_iter().all(f64::is_nan));
    }
}
