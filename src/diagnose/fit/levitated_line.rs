//! Comparison of a line of a sweep in a closed loop, while a model may be far off.

use super::super::data::levitated::{ClosedResponse, Levitation};
use super::columns::PredictedLine;
use super::linearise::{ResidualRows, push};
use super::problem::Problem;
use crate::linalg::c64;
use crate::spindle::response::{SIDE, Square};

/// Model errors from which on responses are compared in a closed loop.
pub(crate) const LEVITATED_FROM: f64 = 0.03;

impl Problem<'_> {
    /// The loop in which responses are compared, if any. That mixes channels, of which some may be held out.
    pub(super) fn find_levitation(&self, model_error: f64) -> Option<&Levitation> {
        let closed = model_error >= LEVITATED_FROM && self.usage.off_diagonal;
        self.model.levitation.as_ref().filter(|_| closed)
    }

    /// Appends the residual of a line of a sweep in a closed loop, and its derivatives.
    pub(super) fn compare_levitated(
        &self,
        s: usize,
        line: usize,
        levitation: &Levitation,
        predicted: &PredictedLine,
        rows: &mut ResidualRows,
    ) {
        let (f, p) = (&predicted.line.response, predicted.p);
        let (first, sweep) = (rows.residual.len(), &self.evidence.sweeps[s]);
        let (measured, sd) = sweep.close_line(line, levitation, predicted.model_error);
        let gain: [f64; 4] = std::array::from_fn(|i| 1.0 + p[self.model.layout.axis(s, i)]);
        let with = |f: &Square, gain: &[f64; 4]| -> [c64; 16] {
            std::array::from_fn(|n| f[SIDE * (n / 4) + n % 4] * gain[n / 4])
        };
        let closed = ClosedResponse::new(levitation, sweep.omega_rad_s[line], &with(f, &gain));
        push(rows.residual, &measured.off(&closed, &sd));
        let seen = |change: &Square, gain: &[f64; 4]| closed.change(&with(change, gain), &sd);
        predicted.write(Some(s), &gain, seen, rows.block, first);
    }
}
