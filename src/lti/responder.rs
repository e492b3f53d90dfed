//! Fast evaluation of C(ζI − A)⁻¹B + D on many points: one orthogonal reduction of A to Hessenberg form, then a
//! Hessenberg solve of O(n²) a point (Laub 1981). States are balanced first.

use super::response::Response;
use super::scale::balancing;
use super::state_space::{StateSpace, TimeBase};
use crate::linalg::{Mat, c64};

/// A system prepared for evaluation on a grid.
#[derive(Clone, Debug)]
pub struct FrequencyResponder<T: TimeBase> {
    /// Hessenberg matrix, row after row.
    h: Vec<f64>,
    n: usize,
    b: Mat<f64>,
    c: Mat<f64>,
    d: Mat<f64>,
    time: T,
}

impl<T: TimeBase> FrequencyResponder<T> {
    /// Prepares a system; O(n³).
    pub fn new(system: &StateSpace<T>) -> Self {
        let s = system.scale_states(&balancing(system));
        let (n, mut a, mut b, mut c) = (s.order(), s.a, s.b, s.c);
        for k in 0..n.saturating_sub(2) {
            // Householder vector that annihilates column k below the subdiagonal.
            let mut v: Vec<f64> = (k + 1..n).map(|i| a[(i, k)]).collect();
            let tail = v[1..].iter().map(|x| x * x).sum::<f64>();
            if tail == 0.0 {
                continue;
            }
            let norm = (v[0] * v[0] + tail).sqrt();
            v[0] += norm.copysign(v[0]);
            let beta = 2.0 / (v[0] * v[0] + tail);
            let left = |m: &mut Mat<f64>| {
                for j in 0..m.ncols() {
                    let dot: f64 = v
                        .iter()
                        .enumerate()
                        .map(|(i, x)| x * m[(k + 1 + i, j)])
                        .sum();
                    for (i, x) in v.iter().enumerate() {
                        m[(k + 1 + i, j)] -= beta * dot * x;
                    }
                }
            };
            left(&mut a);
            left(&mut b);
            for m in [&mut a, &mut c] {
                for row in 0..m.nrows() {
                    let dot: f64 = v
                        .iter()
                        .enumerate()
                        .map(|(i, x)| x * m[(row, k + 1 + i)])
                        .sum();
                    for (i, x) in v.iter().enumerate() {
                        m[(row, k + 1 + i)] -= beta * dot * x;
                    }
                }
            }
            for i in k + 2..n {
                a[(i, k)] = 0.0;
            }
        }
        let h = (0..n * n).map(|k| a[(k / n, k % n)]).collect();
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
        let (n, m) = (self.n, self.d.ncols());
        let width = n + m;
        let zero = c64::new(0.0, 0.0);
        // Rows of [ζI − H | B].
        let mut rows = vec![zero; n * width];
        for i in 0..n {
            let row = &mut rows[i * width..(i + 1) * width];
            for j in i.saturating_sub(1)..n {
                row[j] = c64::new(-self.h[i * n + j], 0.0);
            }
            row[i] += point;
            for j in 0..m {
                row[n + j] = c64::new(self.b[(i, j)], 0.0);
            }
        }
        for k in 0..n.saturating_sub(1) {
            let (upper, lower) = rows.split_at_mut((k + 1) * width);
            let (r, s) = (&mut upper[k * width..], &mut lower[..width]);
            if s[k].norm_sqr() > r[k].norm_sqr() {
                r[k..].swap_with_slice(&mut s[k..]);
            }
            if s[k] != zero {
                let f = s[k] / r[k];
                for (x, y) in s[k + 1..].iter_mut().zip(&r[k + 1..]) {
                    *x -= f * y;
                }
            }
        }
        let mut result = Mat::from_fn(self.d.nrows(), m, |i, j| c64::new(self.d[(i, j)], 0.0));
        for j in 0..m {
            for k in (0..n).rev() {
                let row = &rows[k * width..(k + 1) * width];
                let mut x = row[n + j];
                for l in k + 1..n {
                    x -= row[l] * rows[l * width + n + j];
                }
                rows[k * width + n + j] = x / rows[k * width + k];
            }
            for i in 0..self.d.nrows() {
                let mut sum = result[(i, j)];
                for k in 0..n {
                    sum += rows[k * width + n + j] * self.c[(i, k)];
                }
                result[(i, j)] = sum;
            }
        }
        result
    }

    /// Response at an angular frequency; D at infinity (continuous time).
    pub fn at_or_infinity(&self, omega_rad_s: f64) -> Mat<c64> {
        if omega_rad_s.is_infinite() {
            return Mat::from_fn(self.d.nrows(), self.d.ncols(), |i, j| {
                c64::new(self.d[(i, j)], 0.0)
            });
        }
        self.transfer(self.time.point(omega_rad_s))
    }
}

impl<T: TimeBase> Response for FrequencyResponder<T> {
    fn at(&self, omega_rad_s: f64) -> Mat<c64> {
        self.transfer(self.time.point(omega_rad_s))
    }
}
