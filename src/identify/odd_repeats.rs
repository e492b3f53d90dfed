//! Repeats of a sweep that are none: copies of another one, one without numbers, and one that contradicts the others.
//!
//! A rotor that is levitated anew changes the gains of its sensor axes by some per cent from repeat to repeat
//! ([`super::repeat_scatter`]). A repeat with a gain further off is no repeat of the same experiment: in a mean it
//! would be hidden, as the scatter that it causes makes the record look noisy.

use super::frf::{AXES, AXIS_NAMES, SweepRecord, open_loop_columns};
use super::repeat_scatter::RepeatScatter;
use ndarray::Axis;

/// Least change of the gain of an axis that no levitation makes, several times what is customary.
const LEAST_ODD: f64 = 0.1;
/// The same as a multiple of the spread of the others.
const ODD_SPREADS: f64 = 5.0;
/// Fewest repeats of which one can be told to be the odd one.
const FEWEST: usize = 3;

impl SweepRecord {
    /// The record without repeats that are none; which these are is said in [`Self::left_out`].
    #[must_use]
    pub fn without_odd_repeats(mut self) -> Self {
        // Numbers of the file, which change no more when repeats go.
        let mut numbers: Vec<usize> = (1..=self.repeats()).collect();
        let empty: Vec<usize> = (0..self.repeats()).filter(|p| self.is_empty_repeat(*p)).collect();
        if empty.len() < self.repeats() {
            self.leave_out(&mut numbers, &empty, "without numbers");
        }
        let copies: Vec<usize> = (1..self.repeats()).filter(|p| (0..*p).any(|q| self.are_copies(q, *p))).collect();
        self.leave_out(&mut numbers, &copies, "the same numbers as an earlier one");
        while let Some((repeat, axis, ratio)) = self.odd_repeat() {
            let why = format!("it reads {ratio:.2} times what the others read in {}", AXIS_NAMES[axis]);
            self.leave_out(&mut numbers, &[repeat], &why);
        }
        self
    }

    fn is_empty_repeat(&self, repeat: usize) -> bool {
        [&self.current, &self.signal]
            .iter()
            .any(|data| data.index_axis(Axis(2), repeat).iter().all(|value| value.norm() == 0.0))
    }

    fn are_copies(&self, one: usize, other: usize) -> bool {
        [&self.current, &self.signal].iter().all(|d| d.index_axis(Axis(2), one) == d.index_axis(Axis(2), other))
    }

    /// The repeat whose gain of an axis is furthest from those of the others, the axis and the ratio, where that is no
    /// levitation anew.
    fn odd_repeat(&self) -> Option<(usize, usize, f64)> {
        let repeats = self.repeats();
        if repeats < FEWEST {
            return None;
        }
        let (frf, _) = open_loop_columns(self).ok()?;
        let gains = RepeatScatter::of(self, &frf, &|scatter| scatter.to_vec()).gains;
        let candidates = (0..repeats).flat_map(|p| (0..AXES).map(move |axis| (p, axis)));
        let odd = candidates.filter_map(|(p, axis)| {
            let others: Vec<f64> = (0..repeats).filter(|q| *q != p).map(|q| gains[q][axis]).collect();
            let (low, high) =
                others.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), g| (a.min(*g), b.max(*g)));
            let ratio = (1.0 + gains[p][axis]) / (1.0 + others.iter().sum::<f64>() / others.len() as f64);
            ((ratio - 1.0).abs() > LEAST_ODD.max(ODD_SPREADS * (high - low))).then_some((p, axis, ratio))
        });
        odd.max_by(|a, b| (a.2 - 1.0).abs().total_cmp(&(b.2 - 1.0).abs()))
    }

    fn leave_out(&mut self, numbers: &mut Vec<usize>, repeats: &[usize], why: &str) {
        let kept: Vec<usize> = (0..self.repeats()).filter(|p| !repeats.contains(p)).collect();
        for repeat in repeats {
            self.left_out.push(format!("repeat {} is left out: {why}", numbers[*repeat]));
        }
        *numbers = kept.iter().map(|p| numbers[*p]).collect();
        self.current = self.current.select(Axis(2), &kept);
        self.signal = self.signal.select(Axis(2), &kept);
    }
}
