//! The Frobenius norm of the scaled specification at a line, of four loops at a time.
//!
//! With D the scales, A = D E₁₁ D⁻¹, B = D E₁₂ and C = E₂₁ D⁻¹ of M = E₁₁ + E₁₂ R E₂₁:
//!   ‖D M D⁻¹‖² = ‖A‖² + 2 Re tr(C Aᴴ B R) + tr(Rᴴ BᴴB R C Cᴴ),
//! which needs three 2×2 matrices of a line and not its rows: most lines of a step are far below the limit, and what
//! their rows take is the way from memory.

use super::line_scales::LineScales;
use super::matrix2::{Matrix2, PackedMatrix, ZERO};
use super::responses::SpecificationLine;
use crate::linalg::lanes::{Lanes, Reals, groups};

/// The terms of four loops.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedNorms {
    /// ‖A‖².
    direct: Reals,
    /// C Aᴴ B.
    cross: PackedMatrix,
    /// BᴴB.
    drive: PackedMatrix,
    /// C Cᴴ.
    read: PackedMatrix,
}

/// Rounding of the three terms relative to the squares of the norms of what they are products of: a few dozen sums of
/// double precision, with a factor of ten.
const ROUNDING: f64 = 1e-13;

impl PackedNorms {
    pub(super) const NOTHING: Self = Self {
        direct: Reals::splat(0.0),
        cross: [[Lanes::ZERO; 2]; 2],
        drive: [[Lanes::ZERO; 2]; 2],
        read: [[Lanes::ZERO; 2]; 2],
    };

    /// Sets one of the four loops, of its line and scales.
    pub(super) fn set(&mut self, l: usize, line: &SpecificationLine, scales: &LineScales) {
        let height = groups(line.rows);
        let scaled = |k: usize| -> Vec<Lanes> {
            let list = line.drive[k].iter().enumerate();
            list.map(|(g, group)| group.times(scales.group(g))).collect()
        };
        let drive = [scaled(0), scaled(1)];
        let (mut direct, mut cross, mut read) = (0.0, [[ZERO; 2]; 2], [[ZERO; 2]; 2]);
        for (j, column) in line.direct.chunks_exact(height).enumerate() {
            let own = scales.of(j);
            let a: Vec<Lanes> =
                column.iter().enumerate().map(|(g, group)| group.times(scales.group(g) / own)).collect();
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
        let squares = [[inner(0, 0), inner(0, 1)], [inner(1, 0), inner(1, 1)]];
        self.direct.as_mut_array()[l] = direct;
        let all = [&mut self.cross, &mut self.drive, &mut self.read];
        for (packed, own) in all.into_iter().zip([cross, squares, read]) {
            set(packed, l, &own);
        }
    }

    /// ‖D M D⁻¹‖² of each loop with its R, or a little more: at least σ².
    pub(super) fn squares_at_most(&self, r: &PackedMatrix) -> Reals {
        let zero = Reals::splat(0.0);
        let sum = |m: &PackedMatrix| m.iter().flatten().fold(zero, |sum, z| sum + z.squares());
        let trace = |m: &PackedMatrix| m[0][0].reals().0 + m[1][1].reals().0;
        let through = product(&product(&self.drive, r), &self.read);
        let (mut crossed, mut squared) = (zero, zero);
        for i in 0..2 {
            for j in 0..2 {
                crossed += self.cross[i][j].real_product(&r[j][i]);
                squared += through[i][j].real_product(&r[i][j].conjugate());
            }
        }
        let sizes = self.direct + trace(&self.drive) * sum(r) * trace(&self.read);
        (self.direct + crossed * 2.0 + squared).max(zero) + sizes * ROUNDING
    }
}

/// Sets one of the four matrices.
pub(super) fn set(packed: &mut PackedMatrix, l: usize, own: &Matrix2) {
    for (packed, own) in packed.iter_mut().flatten().zip(own.iter().flatten()) {
        packed.set_lane(l, *own);
    }
}

fn product(a: &PackedMatrix, b: &PackedMatrix) -> PackedMatrix {
    let entry = |i: usize, j: usize| a[i][0].product(&b[0][j]).plus_product(&a[i][1], &b[1][j]);
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

#[cfg(test)]
mod tests {
    use super::super::specification_bound::tests::{entry, line};
    use super::*;
    use crate::linalg::lanes::WIDTH;

    #[test]
    fn the_norm_of_three_small_matrices_is_that_of_all_entries() {
        let sizes = [0.0, 1e-3, 1.0, 1e3];
        let r = [[entry(1, 1), entry(2, 3)], [entry(0, 4), entry(5, 2)]];
        for (rows, columns) in [(7, 6), (4, 9), (3, 2)] {
            let line = line(rows, columns);
            let scales = [0.5, 3.0, 1.0, 8.0].map(|d| LineScales::new(vec![d, 2.0, 1.0]));
            let (mut norms, mut loops) = (PackedNorms::NOTHING, [[Lanes::ZERO; 2]; 2]);
            for (l, size) in sizes.into_iter().enumerate() {
                norms.set(l, &line, &scales[l]);
                set(&mut loops, l, &r.map(|row| row.map(|z| z * size)));
            }
            let found = norms.squares_at_most(&loops).to_array();
            for l in 0..WIDTH {
                let mut square = 0.0;
                for i in 0..rows {
                    for j in 0..columns {
                        let mut m = entry(i, j);
                        for a in 0..2 {
                            for b in 0..2 {
                                m += entry(i + 1, a + 5) * (r[a][b] * sizes[l]) * entry(b + 2, j);
                            }
                        }
                        square += (m * (scales[l].of(i) / scales[l].of(j))).norm_sqr();
                    }
                }
                let found = found[l];
                assert!(found >= square * (1.0 - 1e-14), "{found} and {square}");
                assert!(found <= square * (1.0 + 1e-9), "{found} and {square}");
            }
        }
    }
}
