//! Derivatives of the values of a [`Loss`], and the metric of a step.

use super::loss::{Evaluation, Loss, largest_singular};
use super::matrix2::{Matrix2, ZERO, outer, product, row_times, times};
use super::structure::Fixed;
use super::values::{Group, Value};
use crate::linalg::c64;
use rayon::prelude::*;

impl Loss {
    /// Derivative of a value by the parameters.
    pub(crate) fn gradient(&self, law: &dyn Fixed, found: &Evaluation, value: &Value) -> Vec<f64> {
        let mut out = vec![0.0; law.parameters()];
        if value.group == Group::NoiseCurrent {
            self.add_noise_gradient(law, found, value, &mut out);
        } else {
            let q = self.line_derivative(found, value);
            law.add_gradient(&self.lines[value.line], &q, &mut out);
        }
        out
    }

    /// Q of a value that belongs to one line.
    fn line_derivative(&self, found: &Evaluation, value: &Value) -> Matrix2 {
        let state = &found.lines[value.line];
        let mut q = [[ZERO; 2]; 2];
        let i = value.entry.0;
        match value.group {
            Group::HighGain => q = largest_singular(&state.gain).1,
            Group::Specification => {
                q = state.specification[i].q;
            }
            Group::Compliance | Group::Sensitivity | Group::Margin => {
                let sides = self.sides(value.rotor);
                let share = 1.0 / sides.len() as f64;
                let parts = state.loops[sides]
                    .iter()
                    .zip(&self.rotors[value.rotor].directions);
                let mut mean = ZERO;
                for (l, responses) in parts {
                    let g = &responses[value.line];
                    let term = if value.group == Group::Compliance {
                        mean += share * l.compliance;
                        outer(
                            &times(&l.s, &g.read),
                            &row_times(&g.drive, &l.input_sensitivity(&g.loops)),
                            share.into(),
                        )
                    } else {
                        mean += share * l.s[i][i];
                        let column = [l.s[0][i], l.s[1][i]];
                        let row = product(&l.s, &g.loops)[i];
                        outer(&column, &row, share.into())
                    };
                    add(&mut q, &term);
                }
                // d log|m| = Re(δm/m).
                let factor = mean.inv();
                q = q.map(|row| row.map(|v| v * factor));
            }
            Group::NoiseCurrent => {}
        }
        q
    }

    fn add_noise_gradient(
        &self,
        law: &dyn Fixed,
        found: &Evaluation,
        value: &Value,
        out: &mut [f64],
    ) {
        let i = value.entry.0;
        let sides = self.sides(value.rotor);
        let responses = &self.rotors[value.rotor].directions;
        let mut total = 0.0;
        let matrices: Vec<Matrix2> = found
            .lines
            .iter()
            .zip(&self.share)
            .enumerate()
            .map(|(line, (state, share))| {
                let mut q = [[ZERO; 2]; 2];
                for (l, g) in state.loops[sides.clone()].iter().zip(responses) {
                    let su = l.input_sensitivity(&g[line].loops);
                    for j in 0..2 {
                        total += share * l.r[i][j].norm_sqr();
                        let column = [l.s[0][j], l.s[1][j]];
                        add(&mut q, &outer(&column, &su[i], l.r[i][j].conj() * *share));
                    }
                }
                q
            })
            .collect();
        for (line, q) in self.lines.iter().zip(&matrices) {
            let scaled = q.map(|row| row.map(|v| v / total));
            law.add_gradient(line, &scaled, out);
        }
    }

    /// Rows whose squares sum to [`METRIC_LINES`] times the mean square change that a step makes in the loop at rest,
    /// relative: S_u δK G, and in the controller itself, δK/‖K‖ weighted by `own`. Every `stride`-th line.
    pub(crate) fn metric_rows(
        &self,
        law: &dyn Fixed,
        found: &Evaluation,
        (stride, own): (usize, f64),
    ) -> Vec<Vec<f64>> {
        let lines: Vec<usize> = (0..self.lines.len()).step_by(stride.max(1)).collect();
        let share = (METRIC_LINES / lines.len().max(1) as f64).sqrt();
        let rows: Vec<Vec<Vec<f64>>> = lines
            .par_iter()
            .map(|k| {
                let state = &found.lines[*k];
                let (l, g) = (&state.loops[0], &self.rotors[0].directions[0][*k]);
                let size = state
                    .gain
                    .iter()
                    .flatten()
                    .map(c64::norm_sqr)
                    .sum::<f64>()
                    .sqrt();
                let mut rows = vec![];
                let mut push = |q: &Matrix2| {
                    for turn in [c64::new(share, 0.0), c64::new(0.0, -share)] {
                        let mut row = vec![0.0; law.parameters()];
                        let q = q.map(|r| r.map(|v| v * turn));
                        law.add_gradient(&self.lines[*k], &q, &mut row);
                        rows.push(row);
                    }
                };
                let su = l.input_sensitivity(&g.loops);
                for (a, row) in su.iter().enumerate() {
                    for b in 0..2 {
                        let column = [g.loops[0][b], g.loops[1][b]];
                        push(&outer(&column, row, 1.0.into()));
                        let mut q = [[ZERO; 2]; 2];
                        q[b][a] = (own / size.max(f64::MIN_POSITIVE)).into();
                        push(&q);
                    }
                }
                rows
            })
            .collect();
        rows.into_iter().flatten().collect()
    }
}

/// Lines over which a change is taken to be spread.
const METRIC_LINES: f64 = 20.0;

fn add(sum: &mut Matrix2, term: &Matrix2) {
    for i in 0..2 {
        for j in 0..2 {
            sum[i][j] += term[i][j];
        }
    }
}
