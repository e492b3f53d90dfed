//! Scales of the modal channels at a line, and the Frobenius norm of the scaled specification for any loop.
//!
//! With D the scales, A = D E₁₁ D⁻¹, B = D E₁₂ and C = E₂₁ D⁻¹ of M = E₁₁ + E₁₂ R E₂₁:
//!   ‖D M D⁻¹‖² = ‖A‖² + 2 Re tr(C Aᴴ B R) + tr(Rᴴ BᴴB R C Cᴴ),
//! which needs three 2×2 matrices of a line and not its rows: most lines of a step are far below the limit, and what
//! their rows take is the way from memory.

use super::matrix2::{Matrix2, ZERO, product};
use super::responses::SpecificationLine;
use crate::linalg::c64;
use crate::linalg::lanes::{Lanes, Reals, groups, real_group};

/// Scales of the modal channels at a line, for a bound of its specification.
#[derive(Clone, Debug)]
pub(crate) struct LineScales {
    /// One per block, the last (performance) 1.
    d: Vec<f64>,
    /// ‖A‖².
    direct: f64,
    /// C Aᴴ B.
    cross: Matrix2,
    /// BᴴB.
    drive: Matrix2,
    /// C Cᴴ.
    read: Matrix2,
}

/// Rounding of the three terms relative to the squares of the norms of what they are products of: a few dozen sums of
/// double precision, with a factor of ten.
const ROUNDING: f64 = 1e-13;

impl LineScales {
    /// Of a line with a scale per block, the last (performance) 1; modal channels come first, one each.
    pub(super) fn new(line: &SpecificationLine, d: Vec<f64>) -> Self {
        let mut scales = Self {
            d,
            direct: 0.0,
            cross: [[ZERO; 2]; 2],
            drive: [[ZERO; 2]; 2],
            read: [[ZERO; 2]; 2],
        };
        let height = groups(line.rows);
        let scaled = |k: usize| -> Vec<Lanes> {
            let list = line.drive[k].iter().enumerate();
            list.map(|(g, group)| group.times(scales.group(g)))
                .collect()
        };
        let drive = [scaled(0), scaled(1)];
        let (mut direct, mut cross, mut read) = (0.0, [[ZERO; 2]; 2], [[ZERO; 2]; 2]);
        for (j, column) in line.direct.chunks_exact(height).enumerate() {
            let own = scales.of(j);
            let a: Vec<Lanes> = column
                .iter()
                .enumerate()
                .map(|(g, group)| group.times(scales.group(g) / own))
                .collect();
            let c = line.read[j].map(|c| c / own);
            direct += Lanes::sum_of_squares(&a);
            for i in 0..2 {
                for k in 0..2 {
                    cross[i][k] += c[i] * Lanes::inner(&a, &drive[k]);
                    read[i][k] += c[i] * c[k].conj();
                }
            }
        }
        let inner = |i: usize, k: usize| Lanes::inner(&drive[i], &drive[k]);
        scales.drive = [[inner(0, 0), inner(0, 1)], [inner(1, 0), inner(1, 1)]];
        (scales.direct, scales.cross, scales.read) = (direct, cross, read);
        scales
    }

    /// One per block.
    pub(super) fn list(&self) -> &[f64] {
        &self.d
    }

    /// Number of modal channels.
    pub(super) fn modal(&self) -> usize {
        self.d.len().saturating_sub(1)
    }

    /// Scale of a row or of a column.
    pub(super) fn of(&self, i: usize) -> f64 {
        if i < self.modal() { self.d[i] } else { 1.0 }
    }

    /// Scales of the rows in a group.
    pub(super) fn group(&self, g: usize) -> Reals {
        real_group(g, |i| self.of(i))
    }

    /// ‖D M D⁻¹‖² of a loop, or a little more: at least σ².
    pub(super) fn square_at_most(&self, r: &Matrix2) -> f64 {
        let sum = |m: &Matrix2| m.iter().flatten().map(c64::norm_sqr).sum::<f64>();
        let trace = |m: &Matrix2| m[0][0].re + m[1][1].re;
        let through = product(&product(&self.drive, r), &self.read);
        let (mut crossed, mut squared) = (0.0, 0.0);
        for i in 0..2 {
            for j in 0..2 {
                crossed += (self.cross[i][j] * r[j][i]).re;
                squared += (through[i][j] * r[i][j].conj()).re;
            }
        }
        let sizes = self.direct + trace(&self.drive) * sum(r) * trace(&self.read);
        (self.direct + 2.0 * crossed + squared).max(0.0) + ROUNDING * sizes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_norm_of_three_small_matrices_is_that_of_all_entries() {
        let entry = |i: usize, j: usize| {
            c64::from_polar(1.0 / (1.0 + (i * j) as f64), (3 * i + 7 * j) as f64)
        };
        for (rows, columns) in [(7, 6), (4, 9), (3, 2)] {
            let line = SpecificationLine {
                rows,
                direct: Lanes::columns(rows, columns, entry),
                drive: [0, 1].map(|k| Lanes::columns(rows, 1, |i, _| entry(i + 1, k + 5))),
                read: (0..columns)
                    .map(|j| [0, 1].map(|k| entry(k + 2, j)))
                    .collect(),
            };
            let scales = LineScales::new(&line, vec![0.5, 3.0, 1.0]);
            for size in [0.0, 1e-3, 1.0, 1e3] {
                let r = [[entry(1, 1), entry(2, 3)], [entry(0, 4), entry(5, 2)]]
                    .map(|row| row.map(|z| z * size));
                let mut square = 0.0;
                for i in 0..rows {
                    for j in 0..columns {
                        let mut m = entry(i, j);
                        for k in 0..2 {
                            for l in 0..2 {
                                m += entry(i + 1, k + 5) * r[k][l] * entry(l + 2, j);
                            }
                        }
                        square += (m * (scales.of(i) / scales.of(j))).norm_sqr();
                    }
                }
                let found = scales.square_at_most(&r);
                assert!(found >= square * (1.0 - 1e-14), "{found} and {square}");
                assert!(found <= square * (1.0 + 1e-9), "{found} and {square}");
            }
        }
    }
}
