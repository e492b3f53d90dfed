//! Fast evaluation of C(ζI − A)⁻¹B + D on many points: one orthogonal reduction of A to Hessenberg form, then a
//! Hessenberg solve of O(n²) a point (Laub 1981). States are balanced first.

use super::response::Response;
use super::scale::balancing;
use super::state_space::{StateSpace, TimeBase};
use crate::linalg::fused::fused;
use crate::linalg::gram::dot_in_lanes;
use crate::linalg::planar::{Part, PartMut, add_fused};
use crate::linalg::{Mat, c64};

/// A system prepared for evaluation on a grid.
#[derive(Clone, Debug)]
pub struct FrequencyResponder<T: TimeBase> {
    /// Hessenberg matrix, row after row.
    h: Vec<f64>,
    n: usize,
    /// Row after row, as is `c`.
    b: Vec<f64>,
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
            reflect_rows(&mut h[(k + 1) * n..], (n, k), (&v, beta));
            reflect_rows(&mut b[(k + 1) * inputs..], (inputs, 0), (&v, beta));
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
        Self {
            h,
            n,
            b,
            c,
            d: s.d,
            time: s.time,
        }
    }

    /// C(ζI − A)⁻¹B + D, p×m; entries are infinite or NaN on a pole.
    pub fn transfer(&self, point: c64) -> Mat<c64> {
        let (n, p, m) = (self.n, self.d.nrows(), self.d.ncols());
        let mut rows = Rows::new(n, n + m);
        self.reduced(point, &mut rows);
        let blocks = m.div_ceil(LANES);
        // Back substitution, a few right-hand sides at once: block c of row k is x[c·n + k].
        let mut x = vec![([0.0; LANES], [0.0; LANES]); n * blocks];
        for k in (0..n).rev() {
            let (re, im) = rows.at(k, k);
            let pivot = c64::new(1.0, 0.0) / c64::new(re, im);
            let (res, ims) = rows.part(k, k + 1, n);
            for c in 0..blocks {
                let mut own = rows.block(k, n + c * LANES);
                let below = &x[c * n + k + 1..(c + 1) * n];
                for ((re, im), x) in res.iter().zip(ims).zip(below) {
                    add_fused((&mut own.0, &mut own.1), (-re, -im), (&x.0, &x.1));
                }
                x[c * n + k] = times(&own, pivot);
            }
        }
        let mut sum = Mat::zeros(p, m);
        for i in 0..p {
            for j in (0..m).step_by(LANES) {
                let mut own: Block = ([0.0; LANES], [0.0; LANES]);
                for (k, v) in own.0.iter_mut().enumerate().take(m - j) {
                    *v = self.d[(i, j + k)];
                }
                let first = j / LANES * n;
                let row = &self.c[i * n..(i + 1) * n];
                for (c, (re, im)) in row.iter().zip(&x[first..first + n]) {
                    for lane in 0..LANES {
                        own.0[lane] = fused(*c, re[lane], own.0[lane]);
                        own.1[lane] = fused(*c, im[lane], own.1[lane]);
                    }
                }
                for k in 0..LANES.min(m - j) {
                    sum[(i, j + k)] = c64::new(own.0[k], own.1[k]);
                }
            }
        }
        sum
    }

    /// Rows of [ζI − H | B], reduced to an upper triangle with row exchanges.
    fn reduced(&self, point: c64, rows: &mut Rows) {
        let (n, m) = (self.n, self.d.ncols());
        let width = n + m;
        for i in 0..n {
            let first = i * width;
            for j in i.saturating_sub(1)..n {
                rows.re[first + j] = -self.h[i * n + j];
            }
            rows.re[first + i] += point.re;
            rows.im[first + i] += point.im;
            rows.re[first + n..first + width].copy_from_slice(&self.b[i * m..(i + 1) * m]);
        }
        for k in 0..n.saturating_sub(1) {
            let value = |(re, im): (f64, f64)| c64::new(re, im);
            if value(rows.at(k + 1, k)).norm_sqr() > value(rows.at(k, k)).norm_sqr() {
                rows.swap(k, k + 1, k);
            }
            let below = value(rows.at(k + 1, k));
            if below != c64::new(0.0, 0.0) {
                let f = below / value(rows.at(k, k));
                let (above, own) = rows.neighbours(k, k + 1);
                add_fused(own, (-f.re, -f.im), above);
            }
        }
    }

    /// Continuous or sampled time.
    pub(crate) fn time(&self) -> T {
        self.time
    }

    /// Response at an angular frequency; D at infinity (continuous time).
    pub(crate) fn at_or_infinity(&self, omega_rad_s: f64) -> Mat<c64> {
        if omega_rad_s.is_infinite() {
            return Mat::from_fn(self.d.nrows(), self.d.ncols(), |i, j| {
                c64::new(self.d[(i, j)], 0.0)
            });
        }
        self.transfer(self.time.point(omega_rad_s))
    }
}

/// (I − βvvᵀ) M for rows of a width, from a column on: those before it are zero.
fn reflect_rows(m: &mut [f64], (width, from): (usize, usize), (v, beta): (&[f64], f64)) {
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

/// Right-hand sides at once: they stay in registers while a row is eliminated.
const LANES: usize = 8;
/// Real and imaginary parts of a few entries of a row.
type Block = ([f64; LANES], [f64; LANES]);

fn times(block: &Block, factor: c64) -> Block {
    let mut product = *block;
    for k in 0..LANES {
        let entry = c64::new(block.0[k], block.1[k]) * factor;
        (product.0[k], product.1[k]) = (entry.re, entry.im);
    }
    product
}

/// Complex rows in two arrays, real and imaginary parts, row after row.
struct Rows {
    width: usize,
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Rows {
    fn new(rows: usize, width: usize) -> Self {
        Self {
            width,
            re: vec![0.0; rows * width],
            im: vec![0.0; rows * width],
        }
    }

    fn at(&self, i: usize, j: usize) -> (f64, f64) {
        let k = i * self.width + j;
        (self.re[k], self.im[k])
    }

    /// Columns `from` to `to` of row `i`.
    fn part(&self, i: usize, from: usize, to: usize) -> Part<'_> {
        let span = i * self.width + from..i * self.width + to;
        (&self.re[span.clone()], &self.im[span])
    }

    /// Columns of row `i` from `from` on, as many as there are, then zeros.
    fn block(&self, i: usize, from: usize) -> Block {
        let (re, im) = self.part(i, from, self.width.min(from + LANES));
        let mut block = ([0.0; LANES], [0.0; LANES]);
        block.0[..re.len()].copy_from_slice(re);
        block.1[..im.len()].copy_from_slice(im);
        block
    }

    /// Row `k` and the next one for writing, from column `from` on.
    fn neighbours(&mut self, k: usize, from: usize) -> (Part<'_>, PartMut<'_>) {
        let (w, cut) = (self.width, (k + 1) * self.width);
        let (above_re, below_re) = self.re.split_at_mut(cut);
        let (above_im, below_im) = self.im.split_at_mut(cut);
        let above = k * w + from..cut;
        (
            (&above_re[above.clone()], &above_im[above]),
            (&mut below_re[from..w], &mut below_im[from..w]),
        )
    }

    /// Exchanges two neighbouring rows from column `from` on.
    fn swap(&mut self, k: usize, l: usize, from: usize) {
        let w = self.width;
        for array in [&mut self.re, &mut self.im] {
            let (above, below) = array.split_at_mut(l * w);
            above[k * w + from..(k + 1) * w].swap_with_slice(&mut below[from..w]);
        }
    }
}
