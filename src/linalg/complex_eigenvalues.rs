//! Eigenvalues of complex matrices: Hessenberg form, then QR steps with Wilkinson's shift on the part that is not yet
//! deflated (Golub and Van Loan, sections 7.4 and 7.5). Without eigenvectors nothing outside that part is kept up to
//! date, and rotations take two neighbouring entries at a time: two thirds of the time of a general Schur form at order
//! 60.

use super::dense::{sort_eigenvalues, stuck, unit_of};
use super::error::NumericError;
use super::fused::multiply_add;
use super::hessenberg::{EXCEPTION, Hessenberg, MOST_STEPS, Stored};
use faer::{Mat, c64};

/// Eigenvalues of a complex square matrix, sorted like [`super::eigenvalues`].
///
/// # Errors
/// As [`super::eigenvalues`].
pub fn eigenvalues_complex(a: &Mat<c64>) -> Result<Vec<c64>, NumericError> {
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite { what: "eigenvalues" });
    }
    let n = a.nrows();
    // Products of entries stay in range.
    let unit = unit_of(a.norm_max());
    let mut form = Hessenberg::of(Mat::from_fn(n, n, |i, j| a[(i, j)] / unit), |z| [z.re, z.im]);
    let mut values = Vec::with_capacity(n);
    let mut end = n;
    let mut steps = 0;
    while end > 0 {
        let start = form.deflate_end(end);
        if start + 1 == end {
            values.push(form.value(start, start) * unit);
            (end, steps) = (start, 0);
            continue;
        }
        steps += 1;
        if steps > MOST_STEPS {
            return Err(stuck(n));
        }
        let shift = match steps % EXCEPTION {
            0 => form.value(end - 1, end - 1) + 0.75 * form.value(end - 1, end - 2).norm(),
            _ => form.wilkinson(end),
        };
        form.step(start, end, shift);
    }
    Ok(sort_eigenvalues(values))
}

/// A rotation [c, s; −s̄, c] of two rows.
struct Rotation {
    c: f64,
    s: c64,
}

impl Rotation {
    /// That which takes (f, g) to (r, 0), and r.
    #[inline]
    fn of(f: c64, g: c64) -> (Self, c64) {
        let own = f.norm_sqr();
        let both = own + g.norm_sqr();
        let product = own * both;
        // Outside this range squares lose digits.
        if !(1e-280..1e280).contains(&product) {
            return Self::of_any_size(f, g);
        }
        let unit = product.sqrt().recip();
        let rotation = Self { c: own * unit, s: f * g.conj() * unit };
        (rotation, f * (both * unit))
    }

    /// As [`Self::of`], one of the two zero or of any size.
    #[cold]
    fn of_any_size(f: c64, g: c64) -> (Self, c64) {
        let length = f.norm().hypot(g.norm());
        if length == 0.0 {
            let (c, s) = (1.0, c64::new(0.0, 0.0));
            return (Self { c, s }, f);
        }
        let own = f.norm();
        let phase = if own > 0.0 { f / own } else { c64::from(1.0) };
        let rotation = Self { c: own / length, s: phase * (g.conj() / length) };
        (rotation, phase * length)
    }

    /// Two entries of a column below each other.
    #[inline(always)]
    fn rotate_rows(&self, x: &mut [f64; 4]) {
        let (c, re, im) = (self.c, self.s.re, self.s.im);
        let y = [x[2], x[3], x[0], x[1]];
        let z = [x[3], x[2], x[1], x[0]];
        let (a, b) = ([re, re, -re, -re], [-im, im, -im, im]);
        *x = std::array::from_fn(|k| multiply_add(a[k], y[k], multiply_add(b[k], z[k], c * x[k])));
    }

    /// The entries of K/2 rows in two neighbouring columns, from the right with the adjoint.
    #[inline(always)]
    fn rotate_columns<const K: usize>(&self, x: &mut [f64; K], y: &mut [f64; K]) {
        let (c, re, im) = (self.c, self.s.re, self.s.im);
        let swapped = |v: &[f64; K]| -> [f64; K] { std::array::from_fn(|k| v[k ^ 1]) };
        let sign: [f64; K] = std::array::from_fn(|k| if k % 2 == 0 { im } else { -im });
        let (old_x, old_y) = (*x, *y);
        let (u, v) = (swapped(&old_x), swapped(&old_y));
        *x = std::array::from_fn(|k| multiply_add(re, old_y[k], multiply_add(sign[k], v[k], c * old_x[k])));
        *y = std::array::from_fn(|k| multiply_add(-re, old_x[k], multiply_add(sign[k], u[k], c * old_y[k])));
    }
}

/// Real and imaginary parts of an entry beside each other.
impl Hessenberg<[f64; 2]> {
    fn value(&self, i: usize, j: usize) -> c64 {
        let [re, im] = self.at(i, j);
        c64::new(re, im)
    }

    fn set_value(&mut self, i: usize, j: usize, value: c64) {
        self.set(i, j, [value.re, value.im]);
    }

    /// The eigenvalue of the last two rows before `end` that is nearer to the last diagonal entry.
    fn wilkinson(&self, end: usize) -> c64 {
        let (i, j) = (end - 2, end - 1);
        let (a, d) = (self.value(i, i), self.value(j, j));
        let beside = self.value(i, j) * self.value(j, i);
        let half = (a - d) * 0.5;
        let root = (half * half + beside).sqrt();
        // The two differ from d by half ± root, whose product is −beside.
        let far = if (half.conj() * root).re >= 0.0 { half + root } else { half - root };
        if far.norm_sqr() > 0.0 { d - beside / far } else { d }
    }

    /// Where a step begins: as far down as what its first rotation fills in before is negligible. A shift that passes
    /// small entries below the diagonal is lost on the way.
    fn begun(&self, start: usize, end: usize, shift: c64) -> usize {
        let size = |z: c64| [z.re, z.im].size();
        let begins = |k: &usize| {
            let k = *k;
            let (own, next) = (self.value(k, k), self.value(k + 1, k + 1));
            let (from, below) = (size(own - shift), size(self.value(k + 1, k)));
            let near = size(own) + size(next);
            size(self.value(k, k - 1)) * below <= f64::EPSILON * from * near
        };
        (start + 1..end - 1).rev().find(begins).unwrap_or(start)
    }

    /// A QR step on the rows and columns from `start` to before `end`.
    fn step(&mut self, start: usize, end: usize, shift: c64) {
        let n = self.order;
        let first = self.begun(start, end, shift);
        for i in first..end - 1 {
            let rotation = if i > first {
                let pair = (self.value(i, i - 1), self.value(i + 1, i - 1));
                let (rotation, r) = Rotation::of(pair.0, pair.1);
                self.set_value(i, i - 1, r);
                self.set_value(i + 1, i - 1, c64::new(0.0, 0.0));
                rotation
            } else {
                let rotation = Rotation::of(self.value(i, i) - shift, self.value(i + 1, i)).0;
                if i > start {
                    // What the rotation fills in further down is negligible.
                    self.set_value(i, i - 1, self.value(i, i - 1) * rotation.c);
                }
                rotation
            };
            for column in self.entries[i * n..end * n].chunks_exact_mut(n) {
                let pair = column[i..i + 2].as_flattened_mut();
                if let Some(pair) = pair.first_chunk_mut::<4>() {
                    rotation.rotate_rows(pair);
                }
            }
            let last = (i + 3).min(end);
            let (before, after) = self.entries.split_at_mut((i + 1) * n);
            let x = before[i * n + start..i * n + last].as_flattened_mut();
            let y = after[start..last].as_flattened_mut();
            let (x, x_rest) = x.as_chunks_mut::<8>();
            let (y, y_rest) = y.as_chunks_mut::<8>();
            for (x, y) in x.iter_mut().zip(y) {
                rotation.rotate_columns(x, y);
            }
            let (x, y) = (x_rest.as_chunks_mut::<2>().0, y_rest.as_chunks_mut::<2>().0);
            for (x, y) in x.iter_mut().zip(y) {
                rotation.rotate_columns(x, y);
            }
        }
    }
}
