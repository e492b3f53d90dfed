//! Phases that det(I − G K) of four loops gathers from line to line, which count unstable poles.

use crate::linalg::c64;
use crate::linalg::lanes::{Lanes, Reals, WIDTH};
use std::f64::consts::TAU;

/// Phases that four sequences of complex numbers gather in their order: that between the first and the last, and a turn
/// for each time that they pass the negative real axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PhaseCount {
    first: Lanes,
    last: Lanes,
    turns: Reals,
    /// Zero, or not a number where one of those after the first is not finite.
    unbounded: Reals,
}

impl PhaseCount {
    /// Of sequences that begin.
    #[inline]
    pub(crate) fn new(first: &Lanes) -> Self {
        Self { first: *first, last: *first, turns: Reals::splat(0.0), unbounded: Reals::splat(0.0) }
    }

    /// The next number of each.
    #[inline]
    pub(crate) fn add(&mut self, next: &Lanes) {
        let (zero, one) = (Reals::splat(0.0), Reals::splat(1.0));
        let ((x, y), (re, im)) = (self.last.reals(), next.reals());
        let forwards = x * im - y * re;
        let up = y.simd_lt(zero) & im.simd_ge(zero) & forwards.simd_lt(zero);
        let down = y.simd_ge(zero) & im.simd_lt(zero) & forwards.simd_gt(zero);
        self.turns += down.select(one, zero) - up.select(one, zero);
        self.unbounded += (re + im) * zero;
        self.last = *next;
    }

    /// What follows, counted by itself.
    fn join(&mut self, later: &Self) {
        self.add(&later.first);
        self.turns += later.turns;
        self.unbounded += later.unbounded;
        self.last = later.last;
    }

    /// Phases gathered over parts that follow each other, rad; zero without any, NaN where a number is not finite.
    pub(crate) fn phases<'a>(mut parts: impl Iterator<Item = &'a Self>) -> [f64; WIDTH] {
        let Some(mut all) = parts.next().copied() else {
            return [0.0; WIDTH];
        };
        for part in parts {
            all.join(part);
        }
        let (turns, unbounded) = (all.turns.to_array(), all.unbounded.to_array());
        std::array::from_fn(|l| {
            let ends = [all.first.lane(l), all.last.lane(l)];
            if unbounded[l] != 0.0 || !ends[0].is_finite() {
                return f64::NAN;
            }
            TAU * turns[l] + phase(ends[1]) - phase(ends[0])
        })
    }
}

/// Turns of both directions of whirl, of which one may stand for both, by the phase that each gathers;
/// [`NO_TURNS`] where one is not a number.
pub(crate) fn turns_of(directions: impl ExactSizeIterator<Item = f64>) -> i64 {
    let share = 2.0 / directions.len() as f64;
    let phase: f64 = directions.sum();
    if phase.is_finite() { (share * phase / TAU).round() as i64 } else { NO_TURNS }
}

/// Further from every count of turns than these are from each other.
const NO_TURNS: i64 = i64::MIN / 4;

/// Angle of a number, which is not negative where its imaginary part is zero.
fn phase(z: c64) -> f64 {
    (z.im + 0.0).atan2(z.re)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counted in parts of so many numbers.
    fn phases(list: &[Lanes], part: usize) -> [f64; WIDTH] {
        let count = |own: &[Lanes]| {
            let mut count = PhaseCount::new(&own[0]);
            own[1..].iter().for_each(|next| count.add(next));
            count
        };
        let parts: Vec<PhaseCount> = list.chunks(part).map(count).collect();
        PhaseCount::phases(parts.iter())
    }

    #[test]
    fn the_phase_gathered_is_the_sum_of_the_angles_between_neighbours() {
        for (turns, count) in [(0.3, 7), (-2.4, 40), (5.0, 64), (1.0, 9), (-0.5, 5)] {
            let at = |k: usize| c64::from_polar(1.0 + k as f64, 0.7 + TAU * turns * k as f64 / (count - 1) as f64);
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
            for part in [1, 2, 3, 8, 64] {
                let phases = phases(&list, part);
                for (found, exact) in phases.iter().zip([exact, -exact, -exact]) {
                    assert!((found - exact).abs() < 1e-12, "{found} and {exact}");
                }
                assert!(phases[3].is_nan());
            }
        }
        assert_eq!(PhaseCount::phases(std::iter::empty()), [0.0; WIDTH]);
        let infinite = Lanes::from_fn(|_| c64::new(1.0, f64::INFINITY));
        assert!(phases(&[infinite], 1).into_iter().all(f64::is_nan));
    }
}
