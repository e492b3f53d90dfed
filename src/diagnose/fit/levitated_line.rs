//! Comparison of a line of a sweep in a closed loop, while a model may be far off.

use super::super::data::levitated::{Closed, Levitation};
use super::linearise::{Column, Prediction, push, write};
use super::problem::Problem;
use crate::linalg::Mat;
use crate::spindle::response::SIDE;

/// Model errors from which on responses are compared in a closed loop.
pub(crate) const LEVITATED_FROM: f64 = 0.03;

impl Problem<'_> {
    /// The loop in which responses are compared, if any. That mixes channels, of which some may be held out.
    pub(super) fn levitated(&self, model_error: f64) -> Option<&Levitation> {
        let closed = model_error >= LEVITATED_FROM && self.usage.off_diagonal;
        self.model.levitation.as_ref().filter(|_| closed)
    }

    /// Appends the residual of a line of a sweep in a closed loop to `r`, and writes its derivatives into `block`.
    pub(super) fn compare_levitated(
        &self,
        (s, line, levitation): (usize, usize, &Levitation),
        predicted: &Prediction,
        (r, block): (&mut Vec<f64>, &mut Mat<f64>),
    ) {
        let (f, p) = (predicted.f, predicted.p);
        let (first, sweep) = (r.len(), &self.evidence.sweeps[s]);
        let (measured, sd) = sweep.levitated(line, levitation, predicted.model_error);
        let gain: [f64; 4] = std::array::from_fn(|i| 1.0 + p[self.model.layout.axis(s, i)]);
        let g = std::array::from_fn(|n| f[SIDE * (n / 4) + n % 4] * gain[n / 4]);
        let closed = Closed::new(levitation, sweep.omega_rad_s[line], &g);
        push(r, &measured.off(&closed, &sd));
        for (c, column) in predicted.order.iter().enumerate() {
            let change = |i: usize, j: usize| match *column {
                Column::Axis(record, axis) if (record, axis) == (s, i) => f[SIDE * i + j],
                _ => column.entry(f, predicted.derivatives, i, j) * gain[i],
            };
            if !matches!(column, Column::Nothing) {
                let change = std::array::from_fn(|n| change(n / 4, n % 4));
                write(block, first, c, &closed.change(&change, &sd));
            }
        }
    }
}
