//! The directions of a line: what they explain of a whitened residual, and what lies beyond them.

use crate::linalg::c64;
use crate::spindle::response::ZERO;

/// Part of a direction below which it repeats the others (rounding of the small springs it comes from).
const DEPENDENT: f64 = 1e-9;

/// Orthonormal directions of a line, whitened, with the triangle that leads back.
pub(super) struct LineBasis {
    pub q: Vec<[c64; 16]>,
    /// Index of the direction behind each q, and R (columns over q).
    pub kept: Vec<usize>,
    pub r: Vec<Vec<c64>>,
}

impl LineBasis {
    pub(super) fn new(directions: &[[c64; 16]]) -> Self {
        let mut basis = Self { q: vec![], kept: vec![], r: vec![] };
        for (i, d) in directions.iter().enumerate() {
            let own = power(d).sqrt();
            let (mut v, mut column) = (*d, vec![]);
            for q in &basis.q {
                let share = dot(q, &v);
                for (v, q) in v.iter_mut().zip(q) {
                    *v -= q * share;
                }
                column.push(share);
            }
            let left = power(&v).sqrt();
            if own > 0.0 && left > DEPENDENT * own {
                column.push(c64::new(left, 0.0));
                basis.q.push(v.map(|x| x / left));
                basis.kept.push(i);
                basis.r.push(column);
            }
        }
        basis
    }

    /// What lies beyond the directions.
    pub(super) fn beyond(&self, v: &[c64; 16]) -> [c64; 16] {
        let mut v = *v;
        for q in &self.q {
            let share = dot(q, &v);
            for (v, q) in v.iter_mut().zip(q) {
                *v -= q * share;
            }
        }
        v
    }

    /// Least squares X of `v` and standard deviations for whitened noise of χ² = 2|w|².
    pub(super) fn solve(&self, v: &[c64; 16], count: usize) -> (Vec<c64>, Vec<f64>) {
        let n = self.q.len();
        let (mut x, mut sd) = (vec![ZERO; count], vec![0.0; count]);
        let mut z: Vec<c64> = self.q.iter().map(|q| dot(q, v)).collect();
        // R⁻¹ by back substitution; variance of X_a is the squared row a of R⁻¹.
        let mut inverse = vec![vec![ZERO; n]; n];
        for k in (0..n).rev() {
            let pivot = self.r[k][k];
            for c in k..n {
                let mut sum = if c == k { c64::new(1.0, 0.0) } else { ZERO };
                for l in k + 1..n {
                    sum -= self.r[l][k] * inverse[l][c];
                }
                inverse[k][c] = sum / pivot;
            }
            for l in k + 1..n {
                let shift = self.r[l][k] * z[l];
                z[k] -= shift;
            }
            z[k] /= pivot;
        }
        for (k, at) in self.kept.iter().enumerate() {
            x[*at] = z[k];
            sd[*at] = inverse[k].iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        }
        (x, sd)
    }
}

fn dot(a: &[c64; 16], b: &[c64; 16]) -> c64 {
    a.iter().zip(b).fold(ZERO, |s, (a, b)| s + a.conj() * b)
}

pub(super) fn power(a: &[c64; 16]) -> f64 {
    a.iter().map(|v| v.norm_sqr()).sum()
}
