//! Double QR steps of Francis on a real Hessenberg matrix (Golub and Van Loan, section 7.5). With a basis they lead to
//! a real Schur form; without one to the eigenvalues alone, and nothing outside the part that is not yet deflated is
//! kept up to date.

use super::dense::stuck;
use super::error::NumericError;
use super::hessenberg::{EXCEPTION, Hessenberg, MOST_STEPS, SMALLEST};
use faer::c64;

/// A Hessenberg matrix on its way to blocks of order one and two.
pub(super) struct Francis {
    pub form: Hessenberg<f64>,
    /// Orthogonal matrix that the steps are multiplied to, column by column; absent where eigenvalues are enough.
    pub basis: Option<Vec<f64>>,
}

/// A reflection I − τ v vᵀ with v = (1, v₁, v₂).
struct Reflection {
    tau: f64,
    v: [f64; 2],
}

impl Reflection {
    /// That which takes x to (β, 0, 0), and β.
    fn of([x, y, z]: [f64; 3]) -> (Self, f64) {
        let rest = y.hypot(z);
        let size = x.hypot(rest);
        if rest == 0.0 || size < SMALLEST {
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
    fn reflect_entries<const K: usize>(&self, [x, y, z]: [&mut [f64; K]; 3]) {
        let [a, b] = self.v;
        let sum: [f64; K] = std::array::from_fn(|k| self.tau * (x[k] + a * y[k] + b * z[k]));
        *x = std::array::from_fn(|k| x[k] - sum[k]);
        *y = std::array::from_fn(|k| y[k] - sum[k] * a);
        *z = std::array::from_fn(|k| z[k] - sum[k] * b);
    }

    /// Three neighbouring columns from the right.
    #[inline(always)]
    fn reflect_three_columns(&self, [x, y, z]: [&mut [f64]; 3]) {
        let (x, x_rest) = x.as_chunks_mut::<4>();
        let (y, y_rest) = y.as_chunks_mut::<4>();
        let (z, z_rest) = z.as_chunks_mut::<4>();
        for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
            self.reflect_entries([x, y, z]);
        }
        for ((x, y), z) in x_rest.iter_mut().zip(y_rest).zip(z_rest) {
            let [x, y, z] = [x, y, z].map(std::array::from_mut);
            self.reflect_entries([x, y, z]);
        }
    }

    /// Rows `from` to before `to` of columns k, k + 1 and k + 2 of a matrix of `n` rows, from the right.
    fn reflect_columns(&self, entries: &mut [f64], n: usize, k: usize, (from, to): (usize, usize)) {
        let mut columns = entries[k * n..(k + 3) * n].chunks_exact_mut(n);
        if let (Some(x), Some(y), Some(z)) = (columns.next(), columns.next(), columns.next()) {
            self.reflect_three_columns([&mut x[from..to], &mut y[from..to], &mut z[from..to]]);
        }
    }

    /// Rows `from` to before `to` of columns k and k + 1 of a matrix of `n` rows, from the right.
    fn reflect_pair(&self, entries: &mut [f64], n: usize, k: usize, (from, to): (usize, usize)) {
        let a = self.v[0];
        let (x, y) = entries[k * n..(k + 2) * n].split_at_mut(n);
        for (x, y) in x[from..to].iter_mut().zip(&mut y[from..to]) {
            let sum = self.tau * (*x + a * *y);
            *x -= sum;
            *y -= sum * a;
        }
    }
}

impl Francis {
    /// Steps until nothing is left but blocks of order one and two on the diagonal.
    ///
    /// # Errors
    /// [`NumericError::NoConvergence`] when a part does not fall into such blocks.
    pub(super) fn run(&mut self) -> Result<(), NumericError> {
        let (mut end, mut steps) = (self.form.order, 0);
        while end > 0 {
            let start = self.form.deflated(end);
            if end - start <= 2 {
                (end, steps) = (start, 0);
                continue;
            }
            steps += 1;
            if steps > MOST_STEPS {
                return Err(stuck(self.form.order));
            }
            let shifts = self.shifts((start, end), steps);
            self.step((start, end), shifts);
        }
        Ok(())
    }

    /// Eigenvalues of the blocks on the diagonal, from the lower end.
    pub(super) fn eigenvalues(&self) -> Vec<c64> {
        let h = &self.form;
        let mut values = Vec::with_capacity(h.order);
        let mut end = h.order;
        while end > 0 {
            if end >= 2 && h.at(end - 1, end - 2) != 0.0 {
                values.extend(self.last_pair(end));
                end -= 2;
            } else {
                values.push(c64::from(h.at(end - 1, end - 1)));
                end -= 1;
            }
        }
        values
    }

    /// Eigenvalues of the last two rows before `end`.
    fn last_pair(&self, end: usize) -> [c64; 2] {
        let (i, j, h) = (end - 2, end - 1, &self.form);
        pair([h.at(i, i), h.at(i, j)], [h.at(j, i), h.at(j, j)])
    }

    /// Real part and square of the imaginary part of the two shifts of a step.
    fn shifts(&self, (start, end): (usize, usize), steps: usize) -> (f64, f64) {
        let (last, h) = (end - 1, &self.form);
        if steps.is_multiple_of(EXCEPTION) {
            // At the lower end and at the upper end in turn.
            let (at, size) = match (steps / EXCEPTION).is_multiple_of(2) {
                false => (
                    h.at(last, last),
                    h.at(last, last - 1).abs() + h.at(last - 1, last - 2).abs(),
                ),
                true => (
                    h.at(start, start),
                    h.at(start + 1, start).abs() + h.at(start + 2, start + 1).abs(),
                ),
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
        let own = h.at(last, last);
        let nearer = match (a.re - own).abs() <= (b.re - own).abs() {
            true => a.re,
            false => b.re,
        };
        (nearer, 0.0)
    }

    /// A double QR step on the rows and columns from `start` to before `end`, three of them at least.
    fn step(&mut self, (start, end): (usize, usize), shifts: (f64, f64)) {
        let (first, mut column) = self.begun((start, end), shifts);
        let n = self.form.order;
        for k in first..end - 1 {
            let three = k + 2 < end;
            let h = &mut self.form;
            if k > first {
                let third = if three { h.at(k + 2, k - 1) } else { 0.0 };
                column = [h.at(k, k - 1), h.at(k + 1, k - 1), third];
            }
            let (reflection, beta) = Reflection::of(column);
            if k > first {
                h.set(k, k - 1, beta);
                h.set(k + 1, k - 1, 0.0);
                if three {
                    h.set(k + 2, k - 1, 0.0);
                }
            } else if k > start {
                // What the reflection fills in further down is negligible.
                h.set(k, k - 1, h.at(k, k - 1) * (1.0 - reflection.tau));
            }
            // A Schur form is kept whole.
            let (top, right) = match self.basis {
                Some(_) => (0, n),
                None => (start, end),
            };
            let rows = (top, (k + 4).min(end));
            let entries = &mut self.form.entries;
            match three {
                true => {
                    reflect_three_rows(&reflection, &mut entries[k * n..right * n], n, k);
                    reflection.reflect_columns(entries, n, k, rows);
                }
                false => {
                    reflect_two_rows(&reflection, &mut entries[k * n..right * n], n, k);
                    reflection.reflect_pair(entries, n, k, rows);
                }
            }
            match (&mut self.basis, three) {
                (Some(basis), true) => reflection.reflect_columns(basis, n, k, (0, n)),
                (Some(basis), false) => reflection.reflect_pair(basis, n, k, (0, n)),
                (None, _) => {}
            }
        }
    }

    /// Where a step begins, and the direction that its first reflection turns into the first axis: as far down as what
    /// that fills in before is negligible. Shifts that pass small entries below the diagonal are lost on the way.
    fn begun(
        &self,
        (start, end): (usize, usize),
        (re, im_squared): (f64, f64),
    ) -> (usize, [f64; 3]) {
        let h = &self.form;
        let mut first = end - 3;
        loop {
            // First column of (H − s)(H − s̄) from here on, divided by the first entry below the diagonal.
            let (own, below) = (h.at(first, first), h.at(first + 1, first));
            let next = h.at(first + 1, first + 1);
            let column = [
                ((own - re).powi(2) + im_squared) / below + h.at(first, first + 1),
                (own - re) + (next - re),
                h.at(first + 2, first + 1),
            ];
            // Only its direction counts, and a small entry below the diagonal makes it long.
            let size = column.iter().map(|x| x.abs()).fold(0.0, f64::max);
            let column = match size > 0.0 {
                true => column.map(|x| x / size),
                false => column,
            };
            if first == start {
                return (first, column);
            }
            let [x, y, z] = column.map(f64::abs);
            let near = h.at(first - 1, first - 1).abs() + own.abs() + next.abs();
            if h.at(first, first - 1).abs() * (y + z) <= f64::EPSILON * x * near {
                return (first, column);
            }
            first -= 1;
        }
    }
}

/// Rows k, k + 1 and k + 2 of neighbouring columns of `n` entries, from the left.
fn reflect_three_rows(reflection: &Reflection, columns: &mut [f64], n: usize, k: usize) {
    let (tau, [a, b]) = (reflection.tau, reflection.v);
    for column in columns.chunks_exact_mut(n) {
        if let Some([x, y, z]) = column[k..].first_chunk_mut::<3>() {
            let sum = tau * (*x + a * *y + b * *z);
            *x -= sum;
            *y -= sum * a;
            *z -= sum * b;
        }
    }
}

/// Rows k and k + 1 of neighbouring columns of `n` entries, from the left.
fn reflect_two_rows(reflection: &Reflection, columns: &mut [f64], n: usize, k: usize) {
    let (tau, a) = (reflection.tau, reflection.v[0]);
    for column in columns.chunks_exact_mut(n) {
        if let Some([x, y]) = column[k..].first_chunk_mut::<2>() {
            let sum = tau * (*x + a * *y);
            *x -= sum;
            *y -= sum * a;
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
