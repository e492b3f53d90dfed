//! Double QR steps of Francis on a real Hessenberg matrix, until it falls apart into blocks of one and two rows (Golub
//! and Van Loan, section 7.5).

use super::dense::{NEGLIGIBLE, stuck};
use super::error::NumericError;
use super::fused::multiply_add;
use super::hessenberg::{EXCEPTION, Hessenberg, MOST_STEPS};
use faer::{Mat, c64};
use std::ops::Range;

/// A Hessenberg matrix on its way to blocks.
pub(super) struct Francis {
    form: Hessenberg<f64>,
    /// Q, column by column, where A = Q T Qᵀ is the matrix before. Empty where eigenvalues alone are asked: then
    /// nothing outside the part that is not yet deflated is kept up to date.
    basis: Vec<f64>,
}

impl Francis {
    /// For the eigenvalues of a matrix of norm one.
    pub(super) fn of_values(a: Mat<f64>) -> Self {
        let (form, basis) = (Hessenberg::of(a, |x| *x), Vec::new());
        Self { form, basis }
    }

    /// For the Schur form of a matrix of norm one.
    pub(super) fn of_schur_form(a: Mat<f64>) -> Self {
        let (form, basis) = Hessenberg::with_basis(a);
        Self { form, basis }
    }

    /// Takes steps until all is deflated.
    pub(super) fn check_finished(mut self) -> Result<Self, NumericError> {
        let mut end = self.form.order;
        let mut steps = 0;
        while end > 0 {
            let start = self.form.deflate_end(end);
            if end - start <= 2 {
                (end, steps) = (start, 0);
                continue;
            }
            steps += 1;
            if steps > MOST_STEPS {
                return Err(stuck(self.form.order));
            }
            let shifts = self.form.shifts(start, end, steps);
            self.step(start, end, shifts);
        }
        Ok(self)
    }

    /// Eigenvalues of the blocks, from the last one up.
    pub(super) fn values(&self) -> Vec<c64> {
        let mut values = Vec::with_capacity(self.form.order);
        let mut end = self.form.order;
        while end > 0 {
            if end > 1 && self.form.at(end - 1, end - 2) != 0.0 {
                values.extend(self.form.last_pair(end));
                end -= 2;
            } else {
                values.push(c64::from(self.form.at(end - 1, end - 1)));
                end -= 1;
            }
        }
        values
    }

    /// Q and T of a Schur form.
    pub(super) fn basis_and_form(&self) -> [Mat<f64>; 2] {
        let n = self.form.order;
        [&self.basis, &self.form.entries].map(|entries| Mat::from_fn(n, n, |i, j| entries[j * n + i]))
    }

    /// A step on the rows and columns from `start` to before `end`, three of them at least.
    fn step(&mut self, start: usize, end: usize, shifts: (f64, f64)) {
        let form = &mut self.form;
        let (first, mut column) = form.begun(start, end, shifts.0, shifts.1);
        for k in first..end - 1 {
            let three = k + 2 < end;
            if k > first {
                let third = if three { form.at(k + 2, k - 1) } else { 0.0 };
                column = [form.at(k, k - 1), form.at(k + 1, k - 1), third];
            }
            let (reflection, beta) = Reflection::of(column);
            if k > first {
                form.set(k, k - 1, beta);
                form.set(k + 1, k - 1, 0.0);
                if three {
                    form.set(k + 2, k - 1, 0.0);
                }
            } else if k > start {
                // What the reflection fills in further down is negligible.
                form.set(k, k - 1, form.at(k, k - 1) * (1.0 - reflection.tau));
            }
            let n = form.order;
            let values_alone = self.basis.is_empty();
            let part = if values_alone { start..end } else { 0..n };
            let columns = |entries: &mut [f64], rows| {
                if three {
                    reflection.reflect_three_columns(entries, n, k, rows)
                } else {
                    reflection.reflect_two_columns(entries, n, k, rows)
                }
            };
            if three {
                form.reflect_three_rows(&reflection, k, part.end)
            } else {
                form.reflect_two_rows(&reflection, k, part.end)
            }
            columns(&mut form.entries, part.start..(k + 4).min(end));
            if !values_alone {
                columns(&mut self.basis, 0..n);
            }
        }
    }
}

/// A reflection I − τ v vᵀ with v = (1, v₁, v₂).
struct Reflection {
    tau: f64,
    v: [f64; 2],
}

impl Reflection {
    /// That which takes x to (β, 0, 0), and β.
    fn of([x, y, z]: [f64; 3]) -> (Self, f64) {
        let rest = y * y + z * z;
        let square = x * x + rest;
        // Outside this range squares lose digits.
        let size = if rest > 1e-280 && square < 1e280 { square.sqrt() } else { x.hypot(y.hypot(z)) };
        // The reciprocal of a smaller size could be infinite.
        if (y, z) == (0.0, 0.0) || size < NEGLIGIBLE {
            let (tau, v) = (0.0, [0.0; 2]);
            return (Self { tau, v }, x);
        }
        let beta = -size.copysign(x);
        let (tau, unit) = ((beta - x) / beta, (x - beta).recip());
        let v = [y * unit, z * unit];
        (Self { tau, v }, beta)
    }

    /// K entries in each of three neighbouring columns, from the right.
    #[inline(always)]
    fn reflect_columns<const K: usize>(&self, [x, y, z]: [&mut [f64; K]; 3]) {
        let [a, b] = self.v;
        let sum: [f64; K] = std::array::from_fn(|k| self.tau * multiply_add(b, z[k], multiply_add(a, y[k], x[k])));
        *x = std::array::from_fn(|k| x[k] - sum[k]);
        *y = std::array::from_fn(|k| multiply_add(-sum[k], a, y[k]));
        *z = std::array::from_fn(|k| multiply_add(-sum[k], b, z[k]));
    }

    /// Columns k, k + 1, k + 2 of a matrix of `n` rows from the right, in some rows.
    fn reflect_three_columns(&self, entries: &mut [f64], n: usize, k: usize, rows: Range<usize>) {
        let mut columns = entries[k * n..(k + 3) * n].chunks_exact_mut(n);
        let (Some(x), Some(y), Some(z)) = (columns.next(), columns.next(), columns.next()) else {
            return;
        };
        let (x, x_rest) = x[rows.clone()].as_chunks_mut::<4>();
        let (y, y_rest) = y[rows.clone()].as_chunks_mut::<4>();
        let (z, z_rest) = z[rows].as_chunks_mut::<4>();
        for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
            self.reflect_columns([x, y, z]);
        }
        for ((x, y), z) in x_rest.iter_mut().zip(y_rest).zip(z_rest) {
            let [x, y, z] = [x, y, z].map(std::array::from_mut);
            self.reflect_columns([x, y, z]);
        }
    }

    /// Columns k and k + 1, the same way.
    fn reflect_two_columns(&self, entries: &mut [f64], n: usize, k: usize, rows: Range<usize>) {
        let (tau, a) = (self.tau, self.v[0]);
        let (before, after) = entries.split_at_mut((k + 1) * n);
        let pairs = before[k * n..][rows.clone()].iter_mut().zip(&mut after[rows]);
        for (x, y) in pairs {
            let sum = tau * (*x + a * *y);
            *x -= sum;
            *y -= sum * a;
        }
    }
}

impl Hessenberg<f64> {
    /// Eigenvalues of the last two rows before `end`.
    fn last_pair(&self, end: usize) -> [c64; 2] {
        let (i, j) = (end - 2, end - 1);
        pair([self.at(i, i), self.at(i, j)], [self.at(j, i), self.at(j, j)])
    }

    /// Real part and square of the imaginary part of the two shifts of a step.
    fn shifts(&self, start: usize, end: usize, steps: usize) -> (f64, f64) {
        let last = end - 1;
        if steps.is_multiple_of(EXCEPTION) {
            // At the lower end and at the upper end in turn.
            let (at, size) = if (steps / EXCEPTION).is_multiple_of(2) {
                (self.at(start, start), self.at(start + 1, start).abs() + self.at(start + 2, start + 1).abs())
            } else {
                (self.at(last, last), self.at(last, last - 1).abs() + self.at(last - 1, last - 2).abs())
            };
            // The shifts of EISPACK's hqr.
            let own = at + 0.75 * size;
            return (own, 0.4375 * size * size);
        }
        let [a, b] = self.last_pair(end);
        if a.im != 0.0 {
            return (a.re, a.im * a.im);
        }
        // Of two real ones the nearer to the last entry, twice.
        let own = self.at(last, last);
        let nearer = if (a.re - own).abs() <= (b.re - own).abs() { a.re } else { b.re };
        (nearer, 0.0)
    }

    /// Where a step begins, and the direction that its first reflection turns into the first axis: as far down as what
    /// that fills in before is negligible. Shifts that pass small entries below the diagonal are lost on the way.
    fn begun(&self, start: usize, end: usize, re: f64, im_squared: f64) -> (usize, [f64; 3]) {
        let mut first = end - 3;
        loop {
            // First column of (H − s)(H − s̄) from here on, divided by the first entry below the diagonal.
            let (own, below) = (self.at(first, first), self.at(first + 1, first));
            let next = self.at(first + 1, first + 1);
            let column = [
                ((own - re).powi(2) + im_squared) / below + self.at(first, first + 1),
                (own - re) + (next - re),
                self.at(first + 2, first + 1),
            ];
            // Only its direction counts, and a small entry below the diagonal makes it long.
            let size = column.iter().map(|x| x.abs()).fold(0.0, f64::max);
            let column = if size > 0.0 { column.map(|x| x / size) } else { column };
            if first == start {
                return (first, column);
            }
            let [x, y, z] = column.map(f64::abs);
            let near = self.at(first - 1, first - 1).abs() + own.abs() + next.abs();
            if self.at(first, first - 1).abs() * (y + z) <= f64::EPSILON * x * near {
                return (first, column);
            }
            first -= 1;
        }
    }

    /// Rows k, k + 1, k + 2 from the left, in the columns from k to before `end`.
    fn reflect_three_rows(&mut self, reflection: &Reflection, k: usize, end: usize) {
        let n = self.order;
        let (tau, [a, b]) = (reflection.tau, reflection.v);
        for column in self.entries[k * n..end * n].chunks_exact_mut(n) {
            if let Some([x, y, z]) = column[k..].first_chunk_mut::<3>() {
                let sum = tau * multiply_add(b, *z, multiply_add(a, *y, *x));
                *x -= sum;
                *y = multiply_add(-sum, a, *y);
                *z = multiply_add(-sum, b, *z);
            }
        }
    }

    /// Rows k and k + 1, the same way.
    fn reflect_two_rows(&mut self, reflection: &Reflection, k: usize, end: usize) {
        let (tau, a) = (reflection.tau, reflection.v[0]);
        for j in k..end {
            let sum = tau * (self.at(k, j) + a * self.at(k + 1, j));
            self.set(k, j, self.at(k, j) - sum);
            self.set(k + 1, j, self.at(k + 1, j) - sum * a);
        }
    }
}

/// Eigenvalues of [a, b; c, d].
fn pair([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [c64; 2] {
    let half = 0.5 * (a - d);
    let beside = b * c;
    let square = half * half + beside;
    if square < 0.0 {
        let (re, im) = (d + half, (-square).sqrt());
        return [c64::new(re, im), c64::new(re, -im)];
    }
    // The two differ from d by half ± root, whose product is −beside: the larger without cancellation.
    let far = half + square.sqrt().copysign(half);
    let near = if far == 0.0 { 0.0 } else { -beside / far };
    [c64::from(d + far), c64::from(d + near)]
}
