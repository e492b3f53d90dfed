//! Fast evaluation of C(ζI − A)⁻¹B + D on many points: one orthogonal reduction of A to Hessenberg form, then a
//! Hessenberg solve of O(n²) a point (Laub 1981). States are balanced first.

use super::response::Response;
use super::scale::balancing;
use super::state_space::{StateSpace, TimeBase};
use crate::linalg::fused::multiply_add;
use crate::linalg::gram::dot_in_lanes;
use crate::linalg::lanes::{Lanes, WIDTH};
use crate::linalg::planar::add_fused;
use crate::linalg::{Mat, c64};

/// A system prepared for evaluation on a grid.
#[derive(Clone, Debug)]
pub struct FrequencyResponder<T: TimeBase> {
    /// Hessenberg matrix, column after column.
    h: Vec<f64>,
    n: usize,
    /// Row after row.
    b: Vec<f64>,
    /// Column after column.
    c: Vec<f64>,
    d: Mat<f64>,
    time: T,
}

impl<T: TimeBase> FrequencyResponder<T> {
    /// Prepares a system; O(n³).
    pub fn new(system: &StateSpace<T>) -> Self {
        let s = system.scale_states(&balancing(system));
        let (n, inputs) = (s.order(), s.inputs());
        let rows = |m: &Mat<f64>| -> Vec<f64> {
            let width = m.ncols();
            let entries = 0..m.nrows() * width;
            entries.map(|k| m[(k / width, k % width)]).collect()
        };
        let (mut h, mut b, mut c) = (rows(&s.a), rows(&s.b), rows(&s.c));
        for k in 0..n.saturating_sub(2) {
            // Householder vector that annihilates column k below the subdiagonal.
            let mut v: Vec<f64> = (k + 1..n).map(|i| h[i * n + k]).collect();
            let tail = v[1..].iter().map(|x| x * x).sum::<f64>();
            if tail == 0.0 {
                continue;
            }
            let norm = (v[0] * v[0] + tail).sqrt();
            v[0] += norm.copysign(v[0]);
            let beta = 2.0 / (v[0] * v[0] + tail);
            // What is left of column k is zero.
            reflect_rows(&mut h[(k + 1) * n..], n, k, &v, beta);
            reflect_rows(&mut b[(k + 1) * inputs..], inputs, 0, &v, beta);
            for matrix in [&mut h, &mut c] {
                for row in matrix.chunks_exact_mut(n) {
                    let own = &mut row[k + 1..];
                    let share = beta * dot_in_lanes(&v, own);
                    for (own, x) in own.iter_mut().zip(&v) {
                        *own -= share * x;
                    }
                }
            }
            for i in k + 2..n {
                h[i * n + k] = 0.0;
            }
        }
        let p = s.outputs();
        Self {
            h: (0..n * n).map(|k| h[k % n * n + k / n]).collect(),
            n,
            b,
            c: (0..n * p).map(|k| c[k % p * n + k / p]).collect(),
            d: s.d,
            time: s.time,
        }
    }

    /// C(ζI − A)⁻¹B + D, p×m; entries are infinite or NaN on a pole.
    pub fn transfer(&self, point: c64) -> Mat<c64> {
        match self.d.ncols() {
            0..=WIDTH => self.transfer_in_blocks::<1>(point),
            _ => self.transfer_in_blocks::<2>(point),
        }
    }

    /// [`Self::transfer`] with so many groups of columns of B in a block.
    ///
    /// Columns of [ζI − H; C] are combined from the last one on, the larger of two at the diagonal as pivot, until the
    /// upper part is a triangle R: with x = E y, where E holds the combinations, R y = B and C x = (C E) y. A column of
    /// R is done with as soon as it is found.
    fn transfer_in_blocks<const K: usize>(&self, point: c64) -> Mat<c64> {
        let (n, p, m) = (self.n, self.d.nrows(), self.d.ncols());
        let blocks = m.div_ceil(K * WIDTH);
        let mut b: Vec<EntryGroup<K>> = (0..blocks * n).map(|k| self.block(k / n, k % n)).collect();
        let mut sum: Vec<EntryGroup<K>> = vec![EntryGroup::ZERO; blocks * p];
        let (mut column, mut pivot) = (CombinedColumn::zeros(n, p), CombinedColumn::zeros(n, p));
        if n > 0 {
            self.shift_column(&mut column, n - 1, n, point);
        }
        for i in (1..n).rev() {
            let next = i - 1;
            let own = column.at(i);
            // Of the column before it the entry in this row.
            let beside = -self.column(next)[i];
            if own.norm_sqr() >= beside * beside {
                column.solve(&mut b, n, &mut sum, i);
                column.add(-(beside / own), self.column(next), self.read(next), i);
                column.shift(next, point);
            } else {
                self.shift_column(&mut pivot, next, i + 1, point);
                pivot.solve(&mut b, n, &mut sum, i);
                column.subtract(own / beside, &pivot, i);
            }
        }
        if n > 0 {
            column.solve(&mut b, n, &mut sum, 0);
        }
        Mat::from_fn(p, m, |i, j| {
            let own = &sum[j / (K * WIDTH) * p + i];
            Lanes::at(&own.0, j % (K * WIDTH)) + self.d[(i, j)]
        })
    }

    /// Makes `column` of the first rows of a column of ζI − H, with that of C.
    fn shift_column(&self, column: &mut CombinedColumn, j: usize, rows: usize, point: c64) {
        for (own, h) in column.re.iter_mut().zip(&self.column(j)[..rows]) {
            *own = -h;
        }
        column.im[..rows].fill(0.0);
        for (own, c) in column.read.iter_mut().zip(self.read(j)) {
            *own = c64::from(*c);
        }
        column.shift(j, point);
    }

    /// Column of H, from the top.
    fn column(&self, j: usize) -> &[f64] {
        &self.h[j * self.n..(j + 1) * self.n]
    }

    /// Column of C.
    fn read(&self, j: usize) -> &[f64] {
        let p = self.d.nrows();
        &self.c[j * p..(j + 1) * p]
    }

    /// Row of B in columns from a block's first one on; zeros behind the last.
    fn block<const K: usize>(&self, number: usize, row: usize) -> EntryGroup<K> {
        let m = self.d.ncols();
        let own = &self.b[row * m..(row + 1) * m];
        let entry = |k: usize| own.get(k).copied().unwrap_or(0.0).into();
        let first = |g: usize| WIDTH * (number * K + g);
        EntryGroup(std::array::from_fn(|g| Lanes::from_fn(|l| entry(first(g) + l))))
    }

    pub(crate) fn time(&self) -> T {
        self.time
    }

    /// Response at an angular frequency; D at infinity (continuous time).
    pub(crate) fn at_or_infinity(&self, omega_rad_s: f64) -> Mat<c64> {
        if omega_rad_s.is_infinite() {
            return Mat::from_fn(self.d.nrows(), self.d.ncols(), |i, j| c64::new(self.d[(i, j)], 0.0));
        }
        self.transfer(self.time.point(omega_rad_s))
    }
}

/// (I − βvvᵀ) M for rows of a width, from a column on: those before it are zero.
fn reflect_rows(m: &mut [f64], width: usize, from: usize, v: &[f64], beta: f64) {
    let mut sums = vec![0.0; width - from];
    for (row, x) in m.chunks_exact(width.max(1)).zip(v) {
        for (sum, entry) in sums.iter_mut().zip(&row[from..]) {
            *sum += x * entry;
        }
    }
    for (row, x) in m.chunks_exact_mut(width.max(1)).zip(v) {
        let share = beta * x;
        for (entry, sum) in row[from..].iter_mut().zip(&sums) {
            *entry -= share * sum;
        }
    }
}

impl<T: TimeBase> Response for FrequencyResponder<T> {
    fn at(&self, omega_rad_s: f64) -> Mat<c64> {
        self.transfer(self.time.point(omega_rad_s))
    }
}

/// Entries of a row in a few groups of columns.
#[derive(Clone, Copy, Debug)]
struct EntryGroup<const K: usize>([Lanes; K]);

impl<const K: usize> EntryGroup<K> {
    const ZERO: Self = Self([Lanes::ZERO; K]);

    fn times(&self, factor: c64) -> Self {
        let mut product = Self::ZERO;
        product.add(factor, self);
        product
    }

    /// Adds another one times a factor.
    #[inline(always)]
    fn add(&mut self, factor: c64, other: &Self) {
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            *own = own.plus(factor, other);
        }
    }
}

/// A column of [ζI − H; C] after some combinations, real and imaginary parts of the upper part apart. Rows below those
/// that are combined are left of columns before it.
struct CombinedColumn {
    re: Vec<f64>,
    im: Vec<f64>,
    read: Vec<c64>,
}

impl CombinedColumn {
    fn zeros(n: usize, outputs: usize) -> Self {
        Self { re: vec![0.0; n], im: vec![0.0; n], read: vec![c64::new(0.0, 0.0); outputs] }
    }

    fn at(&self, i: usize) -> c64 {
        c64::new(self.re[i], self.im[i])
    }

    /// Becomes `factor` times itself plus a column of [−H; C] in its first `rows` rows.
    #[inline]
    fn add(&mut self, factor: c64, upper: &[f64], read: &[f64], rows: usize) {
        let own = self.re[..rows].iter_mut().zip(&mut self.im[..rows]);
        for ((re, im), h) in own.zip(upper) {
            let before = (*re, *im);
            *re = multiply_add(factor.re, before.0, multiply_add(-factor.im, before.1, -h));
            *im = multiply_add(factor.re, before.1, factor.im * before.0);
        }
        for (own, c) in self.read.iter_mut().zip(read) {
            *own = *own * factor + c;
        }
    }

    /// Takes off `factor` times another column in the first `rows` rows.
    fn subtract(&mut self, factor: c64, other: &Self, rows: usize) {
        let own = (&mut self.re[..rows], &mut self.im[..rows]);
        add_fused(own, (-factor.re, -factor.im), (&other.re[..rows], &other.im[..rows]));
        for (own, other) in self.read.iter_mut().zip(&other.read) {
            *own -= factor * other;
        }
    }

    fn shift(&mut self, i: usize, point: c64) {
        self.re[i] += point.re;
        self.im[i] += point.im;
    }

    /// As column `i` of R: row `i` of y by that of `b`, which the rows above lose; what is read of it goes to `sum`.
    #[inline]
    fn solve<const K: usize>(&self, b: &mut [EntryGroup<K>], n: usize, sum: &mut [EntryGroup<K>], i: usize) {
        let inverse = c64::new(1.0, 0.0) / self.at(i);
        let p = self.read.len();
        for (number, b) in b.chunks_exact_mut(n).enumerate() {
            let y = b[i].times(inverse);
            for ((re, im), b) in self.re.iter().zip(&self.im).zip(&mut b[..i]) {
                b.add(c64::new(-re, -im), &y);
            }
            for (read, sum) in self.read.iter().zip(&mut sum[number * p..(number + 1) * p]) {
                sum.add(*read, &y);
            }
        }
    }
}
