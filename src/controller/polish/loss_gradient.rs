//! Derivatives of the values of a [`Loss`], and the metric of a step.

use super::loop_state::LoopState;
use super::loss::{Evaluation, Loss, largest_singular};
use super::matrix2::{Matrix2, ZERO, adjoint, conjugate_square, hermitian_eigen, outer, product, row_times, times};
use super::structure::{FixedLaw, LoopLine};
use super::values::{Value, ValueGroup};
use crate::linalg::gram::{add_gram, mirror_lower};
use crate::linalg::{Mat, c64};
use rayon::prelude::*;

impl Loss {
    /// Derivatives of some values by the parameters.
    pub(crate) fn gradients(&self, law: &dyn FixedLaw, found: &Evaluation, values: &[Value]) -> Vec<Vec<f64>> {
        let is_noise = |value: &&Value| value.group == ValueGroup::NoiseCurrent;
        let noise: Vec<&Value> = values.iter().filter(is_noise).collect();
        let mut of_noise = self.noise_gradients(law, found, &noise).into_iter();
        let mut numbers: Vec<usize> = (0..values.len()).filter(|k| !is_noise(&&values[*k])).collect();
        // Values of one line share the derivatives of the controller there.
        numbers.sort_by_key(|k| values[*k].line);
        let lines: Vec<&[usize]> = numbers.chunk_by(|a, b| values[*a].line == values[*b].line).collect();
        let of_lines: Vec<Vec<(Matrix2, Vec<f64>)>> = lines
            .par_iter()
            .map(|numbers| {
                let part = |k: &usize| {
                    let q = self.line_derivative(found, &values[*k]);
                    (q, vec![0.0; law.parameters()])
                };
                let mut parts: Vec<(Matrix2, Vec<f64>)> = numbers.iter().map(part).collect();
                if let Some(first) = numbers.first() {
                    let (line, gain) = self.at(found, values[*first].line);
                    law.add_gradients(line, gain, &mut parts);
                }
                parts
            })
            .collect();
        let mut gradients = vec![vec![]; values.len()];
        for (number, (_, gradient)) in numbers.iter().zip(of_lines.into_iter().flatten()) {
            gradients[*number] = gradient;
        }
        let of_values = values.iter().zip(&mut gradients);
        for (_, gradient) in of_values.filter(|(value, _)| is_noise(value)) {
            *gradient = of_noise.next().unwrap_or_default();
        }
        gradients
    }

    fn at<'a>(&'a self, found: &'a Evaluation, line: usize) -> (&'a LoopLine, &'a Matrix2) {
        (&self.lines[line], found.lines.line(line).gain)
    }

    /// Q of a value that belongs to one line.
    fn line_derivative(&self, found: &Evaluation, value: &Value) -> Matrix2 {
        let state = found.lines.line(value.line);
        let mut q = [[ZERO; 2]; 2];
        let i = value.entry.0;
        match value.group {
            ValueGroup::HighGain => q = largest_singular(state.gain).1,
            ValueGroup::Specification => {
                q = state.specification[i].q;
            }
            ValueGroup::Compliance | ValueGroup::ToolStiffness | ValueGroup::Sensitivity | ValueGroup::Margin => {
                let sides = self.sides(value.rotor);
                let share = 1.0 / sides.len() as f64;
                let parts = sides.zip(&self.rotors[value.rotor].directions);
                let mut mean = ZERO;
                for (side, responses) in parts {
                    let l = self.loop_state(found, value.line, side);
                    let g = &responses[value.line];
                    let term = if matches!(value.group, ValueGroup::Compliance | ValueGroup::ToolStiffness) {
                        mean += share * l.compliance;
                        outer(&times(&l.s, &g.read), &row_times(&g.drive, &l.input_sensitivity(&g.loops)), share.into())
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
            ValueGroup::NoiseCurrent => {}
        }
        q
    }

    /// Derivatives of noise currents, each a sum over all lines.
    fn noise_gradients(&self, law: &dyn FixedLaw, found: &Evaluation, values: &[&Value]) -> Vec<Vec<f64>> {
        if values.is_empty() {
            return vec![];
        }
        let sums = || vec![([[ZERO; 2]; 2], vec![0.0; law.parameters()]); values.len()];
        let shares: Vec<(usize, f64)> = self.share.iter().copied().enumerate().collect();
        // Of each value its square and the derivative of that, over a part of the lines. Parts have the same lines
        // whatever the number of threads.
        let parts: Vec<(Vec<f64>, Vec<(Matrix2, Vec<f64>)>)> = shares
            .par_chunks(CHUNK)
            .map(|chunk| {
                let (mut squares, mut slopes) = (vec![0.0; values.len()], sums());
                for (line, share) in chunk {
                    let mut sums = squares.iter_mut().zip(&mut slopes);
                    // Values of one rotor are neighbours, and share its loops.
                    for same in values.chunk_by(|a, b| a.rotor == b.rotor) {
                        let loops = self.closed_loops(found, same[0].rotor, *line);
                        let loops = loops.iter().flatten();
                        for (value, (square, (q, _))) in same.iter().zip(&mut sums) {
                            let (own, added) = noise_derivative(loops.clone(), value.entry.0);
                            *q = own.map(|row| row.map(|v| v * *share));
                            *square += share * added;
                        }
                    }
                    let (line, gain) = self.at(found, *line);
                    law.add_gradients(line, gain, &mut slopes);
                }
                (squares, slopes)
            })
            .collect();
        let of = |k: usize| {
            let total: f64 = parts.iter().map(|(squares, _)| squares[k]).sum();
            let sum = |p: usize| parts.iter().map(|(_, slopes)| slopes[k].1[p]).sum::<f64>();
            (0..law.parameters()).map(|p| sum(p) / total).collect()
        };
        (0..values.len()).map(of).collect()
    }

    /// The loops of a rotor at a line, one for each direction of whirl, with S_u.
    fn closed_loops(&self, found: &Evaluation, rotor: usize, line: usize) -> [Option<(LoopState, Matrix2)>; 2] {
        let gain = found.lines.line(line).gain;
        let directions = &self.rotors[rotor].directions;
        [0, 1].map(|direction| {
            let g = &directions.get(direction)?[line];
            let l = LoopState::new(g, gain);
            let su = l.input_sensitivity(&g.loops);
            Some((l, su))
        })
    }

    /// [`METRIC_LINES`] times the mean square change that a step makes in the loop at rest, relative: S_u δK G, and in
    /// the controller itself, δK/‖K‖ weighted by `own`; a quadratic form of the step. Every `stride`-th line.
    pub(crate) fn metric(&self, law: &dyn FixedLaw, found: &Evaluation, stride: usize, own: f64) -> Mat<f64> {
        let lines: Vec<usize> = (0..self.lines.len()).step_by(stride.max(1)).collect();
        let share = (METRIC_LINES / lines.len().max(1) as f64).sqrt();
        let n = law.parameters();
        let rows = |k: usize| {
            let state = found.lines.line(k);
            let l = self.loop_state(found, k, 0);
            let g = &self.rotors[0].directions[0][k];
            let gain = state.gain.iter().flatten().map(c64::norm_sqr).sum::<f64>();
            let relative = own * own / gain.max(f64::MIN_POSITIVE);
            let mut rows = vec![];
            for q in change_rows(&l.input_sensitivity(&g.loops), &g.loops, relative) {
                for turn in [c64::new(share, 0.0), c64::new(0.0, -share)] {
                    let q = q.map(|row| row.map(|v| v * turn));
                    rows.push((q, vec![0.0; n]));
                }
            }
            let (line, gain) = self.at(found, k);
            law.add_gradients(line, gain, &mut rows);
            rows
        };
        let parts: Vec<Mat<f64>> = lines
            .par_chunks(CHUNK)
            .map(|chunk| {
                let rows: Vec<(Matrix2, Vec<f64>)> = chunk.iter().flat_map(|k| rows(*k)).collect();
                let mut lower = Mat::zeros(n, n);
                add_gram(&mut lower, Mat::from_fn(rows.len(), n, |i, j| rows[i].1[j]).as_ref());
                lower
            })
            .collect();
        let sum = parts.iter().fold(Mat::zeros(n, n), |sum: Mat<f64>, part| sum + part);
        mirror_lower(sum)
    }
}

/// Matrices Q for which Σ |tr(Q δK)|² = ‖S_u δK G‖² + `relative` ‖δK‖² for any δK.
///
/// With S_uᴴS_u = Σ α_a u_a u_aᴴ and G Gᴴ = Σ β_b v_b v_bᴴ their sum is that of (α_a β_b + relative) |u_aᴴ δK v_b|².
fn change_rows(su: &Matrix2, g: &Matrix2, relative: f64) -> [Matrix2; 4] {
    let (alpha, u) = hermitian_eigen(&conjugate_square(&adjoint(su)));
    let (beta, v) = hermitian_eigen(&conjugate_square(g));
    [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(a, b)| {
        let weight = (alpha[a] * beta[b] + relative).sqrt();
        outer(&v[b], &u[a].map(|z| z.conj()), weight.into())
    })
}

/// Q of the square of a noise current at one line, and that square.
fn noise_derivative<'a>(loops: impl Iterator<Item = &'a (LoopState, Matrix2)>, i: usize) -> (Matrix2, f64) {
    let (mut q, mut square) = ([[ZERO; 2]; 2], 0.0);
    for (l, su) in loops {
        for j in 0..2 {
            square += l.r[i][j].norm_sqr();
            let column = [l.s[0][j], l.s[1][j]];
            add(&mut q, &outer(&column, &su[i], l.r[i][j].conj()));
        }
    }
    (q, square)
}

/// Lines that one task sums over.
const CHUNK: usize = 64;
/// Lines over which a change is taken to be spread.
const METRIC_LINES: f64 = 20.0;

fn add(sum: &mut Matrix2, term: &Matrix2) {
    for i in 0..2 {
        for j in 0..2 {
            sum[i][j] += term[i][j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::matrix2::entry;
    use super::*;

    #[test]
    fn four_rows_hold_the_change_of_the_loop_and_of_the_controller() {
        let matrix = |k: usize| [[entry(k, 0), entry(k, 1)], [entry(k, 2), entry(k, 3)]];
        let (su, g, relative) = (matrix(1), matrix(4), 0.3);
        let square = |m: &Matrix2| m.iter().flatten().map(c64::norm_sqr).sum::<f64>();
        for k in 0..5 {
            let change = matrix(10 + k);
            let exact = square(&product(&product(&su, &change), &g)) + relative * square(&change);
            let rows = change_rows(&su, &g, relative);
            let found: f64 = rows
                .iter()
                .map(|q| {
                    let through = product(q, &change);
                    (through[0][0] + through[1][1]).norm_sqr()
                })
                .sum();
            assert!((found / exact - 1.0).abs() < 1e-12, "{found} and {exact}");
        }
    }
}
