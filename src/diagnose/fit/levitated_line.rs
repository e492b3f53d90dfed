//! Comparison of a line of a sweep in a closed loop, while a model may be far off.

use super::super::data::levitated::{Closed, Levitation};
use super::columns::Prediction;
use super::linearise::push;
use super::problem::Problem;
use crate::linalg::{Mat, c64};
use crate::spindle::response::{SIDE, Square};

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
        let (f, p) = (&predicted.line.response, predicted.p);
        let (first, sweep) = (r.len(), &self.evidence.sweeps[s]);
        let (measured, sd) = sweep.levitated(line, levitation, predicted.model_error);
        let gain: [f64; 4] = std::array::from_fn(|i| 1.0 + p[self.model.layout.axis(s, i)]);
        let with = |f: &Square, gain: &[f64; 4]| -> [c64; 16] {
            std::array::from_fn(|n| f[SIDE * (n / 4) + n % 4] * gain[n / 4])
        };
        let closed = Closed::new(levitation, sweep.omega_rad_s[line], &with(f, &gain));
        push(r, &measured.off(&closed, &sd));
        let seen = |change: &Square, gain: &[f64; 4]| closed.change(&with(change, gain), &sd);
        predicted.write(Some(s), &gain, seen, (block, first));
    }
}
