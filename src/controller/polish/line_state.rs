//! The loops of all rotors at a line, closed.

use super::loop_state::LoopState;
use super::matrix2::Matrix2;
use super::packed_loops::PackedState;
use super::phase_count::PhaseCount;
use super::specification_bound::Bound;
use crate::linalg::lanes::{Lanes, Reals, WIDTH};
use rayon::prelude::*;
use std::ops::Range;

/// All lines with a controller, a part of them after the other.
pub(super) struct ClosedLines(Vec<LinePart>);

/// Some neighbouring lines: of each the same number of loops.
pub(super) struct LinePart {
    pub first: usize,
    pub gains: Vec<Matrix2>,
    /// What det(I − G K) without integrators of packs of four loops gathers; none before the first line.
    phases: Vec<PhaseCount>,
    /// Of groups of four rotors.
    pub squares: Vec<PackedSquares>,
    /// Over the lines, of each group of rotors.
    pub largest: Vec<PackedLargest>,
    pub specification: Vec<Bound>,
    /// Loops of the specification at the line that is added.
    pub specified: Vec<LoopState>,
}

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
    pub compliance: Reals,
    /// S₁₁ and S₂₂.
    pub sensitivity: [Reals; 2],
}

/// Of each of four rotors what its lines come to.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedLargest {
    /// Largest square of the compliance in the band of the stiffness, (m/N)².
    pub compliance: Reals,
    /// Largest square of S₁₁ or S₂₂.
    pub sensitivity: Reals,
    /// Both currents by white noise of unit strength, squared, of nominal rotors.
    pub noise: [Reals; 2],
}

/// Sums over the directions of whirl of four rotors at a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct DirectionSums {
    compliance: Lanes,
    sensitivity: [Lanes; 2],
}

const PART: usize = 32;

impl DirectionSums {
    pub(super) const ZERO: Self = Self { compliance: Lanes::ZERO, sensitivity: [Lanes::ZERO; 2] };

    #[inline]
    pub(super) fn with(&self, loops: &PackedState) -> Self {
        Self {
            compliance: self.compliance.sum(&loops.compliance),
            sensitivity: [0, 1].map(|j| self.sensitivity[j].sum(&loops.sensitivity[j])),
        }
    }

    /// Of sums over so many directions.
    #[inline]
    pub(super) fn mean_squares(&self, directions: usize) -> PackedSquares {
        let share = 1.0 / (directions * directions) as f64;
        let mean = |sum: &Lanes| sum.squares() * share;
        PackedSquares { compliance: mean(&self.compliance), sensitivity: self.sensitivity.each_ref().map(mean) }
    }
}

impl PackedLargest {
    const NOTHING: Self =
        Self { compliance: Reals::splat(0.0), sensitivity: Reals::splat(0.0), noise: [Reals::splat(0.0); 2] };

    /// Adds a line, which may be in the band of the stiffness.
    #[inline]
    pub(super) fn add(&mut self, squares: &PackedSquares, is_in_band: bool) {
        let [front, rear] = squares.sensitivity;
        self.sensitivity = larger(larger(self.sensitivity, front), rear);
        if is_in_band {
            self.compliance = larger(self.compliance, squares.compliance);
        }
    }

    /// Adds the squares of the currents at a line to those by noise, with the share of the band that the line stands
    /// for.
    #[inline]
    pub(super) fn add_noise(&mut self, share: f64, currents: [Reals; 2]) {
        for (sum, own) in self.noise.iter_mut().zip(currents) {
            *sum += own * share;
        }
    }
}

/// The larger of four pairs; NaN in the second counts as infinite, as in [`super::values::nan_max`].
#[inline]
fn larger(a: Reals, b: Reals) -> Reals {
    // The first is never NaN.
    b.is_nan().select(Reals::INFINITY, a.fast_max(b))
}

impl ClosedLines {
    /// So many lines, each added to its part behind its gains; of `groups` of rotors with `packs` of loops, and
    /// `specified` loops.
    pub(super) fn collect(
        lines: usize,
        [groups, packs, specified]: [usize; 3],
        add_gains: impl Fn(Range<usize>, &mut Vec<Matrix2>) + Sync,
        add: impl Fn(&mut LinePart, usize) + Sync,
    ) -> Self {
        let parts = (0..lines.div_ceil(PART)).into_par_iter();
        let part = |number: usize| {
            let own = number * PART..lines.min((number + 1) * PART);
            let mut part = LinePart {
                first: own.start,
                gains: Vec::with_capacity(own.len()),
                phases: Vec::with_capacity(packs),
                squares: Vec::with_capacity(groups * own.len()),
                largest: vec![PackedLargest::NOTHING; groups],
                specification: Vec::with_capacity(specified * own.len()),
                specified: vec![LoopState::NOTHING; specified],
            };
            add_gains(own.clone(), &mut part.gains);
            for line in own {
                add(&mut part, line);
            }
            part
        };
        Self(parts.map(part).collect())
    }

    pub(super) fn line(&self, line: usize) -> LineState<'_> {
        self.0[line / PART].line(line % PART)
    }

    /// Squares at a line of the group of four rotors with a number, of so many groups.
    pub(super) fn squares(&self, line: usize, group: usize, groups: usize) -> &PackedSquares {
        &self.0[line / PART].squares[line % PART * groups + group]
    }

    pub(super) fn all(&self) -> impl Iterator<Item = LineState<'_>> {
        let parts = self.0.iter();
        parts.flat_map(|part| (0..part.gains.len()).map(|k| part.line(k)))
    }

    pub(super) fn parts(&self) -> &[LinePart] {
        &self.0
    }

    /// Phases that det(I − G K) of the loops of a pack gathers over all lines, rad.
    pub(super) fn phases(&self, pack: usize) -> [f64; WIDTH] {
        PhaseCount::phases(self.0.iter().map(|part| &part.phases[pack]))
    }

    pub(super) fn specification_mut(&mut self, line: usize, number: usize) -> &mut Bound {
        let part = &mut self.0[line / PART];
        let each = part.specification.len() / part.gains.len().max(1);
        &mut part.specification[line % PART * each + number]
    }
}

impl LinePart {
    /// Adds det(I − G K) of the loops of a pack at the next line.
    #[inline]
    pub(super) fn add_determinant(&mut self, pack: usize, determinant: &Lanes) {
        match self.phases.get_mut(pack) {
            Some(count) => count.add(determinant),
            None => self.phases.push(PhaseCount::new(determinant)),
        }
    }

    fn line(&self, k: usize) -> LineState<'_> {
        let each = self.specification.len() / self.gains.len().max(1);
        LineState { gain: &self.gains[k], specification: &self.specification[k * each..(k + 1) * each] }
    }
}
