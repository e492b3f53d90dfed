//! Poly-reference least squares of complex frequency responses (p-LSCF, PolyMAX: Peeters, Van der Auweraer, Guillaume
//! and Leuridan, Shock and Vibration 11, 2004):  H(z) A(z) = B(z),  z = exp(−jπ(f − f₁)/(f₂ − f₁)).
//!
//! A(z) = I + A₁z + … + A_n zⁿ is a matrix polynomial of the inputs with real coefficients; each output has a row of B.
//! Minimises Σ |w (H A − B)|². B is eliminated output by output, which leaves the reduced normal equations
//! Σ_o (T − SᵀR⁻¹S) of A; R, S and T are block Toeplitz, so that one pass over the lines serves every order. Fixing A₀
//! gives physical poles positive damping and leaves most others without. Lines need not be uniform.
//! Symbols: n order, w weight of an output at a line, [f₁, f₂] band. A pole is f_d + jζf on the frequency axis, Hz.

use super::channel::Channel;
use crate::linalg::dense::solve_normal;
use crate::linalg::{Mat, c64, eigenvalues};
use std::f64::consts::PI;
use std::ops::Range;

/// FRFs of outputs over inputs: channel index = input + inputs·output.
pub(super) struct Responses<'a> {
    pub(super) frequency_hz: &'a [f64],
    pub(super) channels: &'a [Channel],
    pub(super) inputs: usize,
}

/// R, S and T of an output up to the highest order.
struct Normal {
    r: Mat<f64>,
    s: Mat<f64>,
    t: Mat<f64>,
}

impl Responses<'_> {
    /// Poles inside the band of the lines, one list per order; an order whose equations are singular has none.
    pub(super) fn poles(&self, lines: &Range<usize>, orders: &[usize]) -> Vec<Vec<c64>> {
        let band = &self.frequency_hz[lines.clone()];
        let (Some(first), Some(last)) = (band.first(), band.last()) else {
            return vec![];
        };
        let (width, most) = (last - first, orders.iter().copied().max().unwrap_or(0));
        let z: Vec<c64> = band.iter().map(|f| c64::from_polar(1.0, -PI * (f - first) / width)).collect();
        let outputs = self.channels.chunks(self.inputs);
        let normal: Vec<Normal> = outputs.map(|row| normal_matrices(row, lines, &z, most)).collect();
        let of_order = |order: &usize| -> Vec<c64> {
            let roots = denominator_roots(&normal, *order, self.inputs).unwrap_or_default();
            // A root is 1/z: the pole is f₁ − j(f₂ − f₁)/π ln(root).
            let poles = roots
                .iter()
                .filter(|root| root.norm() > 0.0)
                .map(|root| c64::new(*first, 0.0) - c64::new(0.0, width / PI) * c64::new(root.norm().ln(), root.arg()));
            poles.filter(|p| p.re > *first && p.re < *last).collect()
        };
        orders.iter().map(of_order).collect()
    }
}

fn normal_matrices(row: &[Channel], lines: &Range<usize>, z: &[c64], most: usize) -> Normal {
    let inputs = row.len();
    let weight: Vec<f64> = lines
        .clone()
        .map(|l| row.iter().map(|c| c.sigma[l].powi(2)).sum::<f64>() / inputs as f64)
        .map(|variance| if variance > 0.0 { variance.recip() } else { 0.0 })
        .collect();
    let value = |i: usize, k: usize| row[i].value[lines.start + k];
    let sums = |term: &dyn Fn(usize) -> c64| LaggedSums::of(z, most, |k| term(k) * weight[k]);
    let ones = sums(&|_| c64::new(1.0, 0.0));
    let single: Vec<LaggedSums> = (0..inputs).map(|i| sums(&|k| -value(i, k))).collect();
    let double: Vec<LaggedSums> =
        (0..inputs * inputs).map(|ij| sums(&|k| value(ij / inputs, k).conj() * value(ij % inputs, k))).collect();
    let (rows, columns) = (most + 1, (most + 1) * inputs);
    Normal {
        r: Mat::from_fn(rows, rows, |a, b| ones.at(a, b)),
        s: Mat::from_fn(rows, columns, |a, b| single[b % inputs].at(a, b / inputs)),
        t: Mat::from_fn(columns, columns, |a, b| double[inputs * (a % inputs) + b % inputs].at(a / inputs, b / inputs)),
    }
}

/// Re Σ g z^r for r from −most to most.
struct LaggedSums {
    positive: Vec<f64>,
    negative: Vec<f64>,
}

impl LaggedSums {
    fn of(z: &[c64], most: usize, g: impl Fn(usize) -> c64) -> Self {
        let mut sums = Self { positive: vec![0.0; most + 1], negative: vec![0.0; most + 1] };
        for (k, z) in z.iter().enumerate() {
            let (g, mut power) = (g(k), c64::new(1.0, 0.0));
            for (positive, negative) in sums.positive.iter_mut().zip(&mut sums.negative) {
                *positive += g.re * power.re - g.im * power.im;
                *negative += g.re * power.re + g.im * power.im;
                power *= z;
            }
        }
        sums
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        if column >= row { self.positive[column - row] } else { self.negative[row - column] }
    }
}

/// Inverses of the roots of det A(z); none where the equations are singular.
fn denominator_roots(normal: &[Normal], order: usize, inputs: usize) -> Option<Vec<c64>> {
    let (rows, columns) = (order + 1, (order + 1) * inputs);
    let mut reduced = Mat::<f64>::zeros(columns, columns);
    for n in normal {
        let r = n.r.submatrix(0, 0, rows, rows).to_owned();
        let s = n.s.submatrix(0, 0, rows, columns).to_owned();
        reduced += n.t.submatrix(0, 0, columns, columns) - s.transpose() * solve_normal(&r, &s).ok()?;
    }
    let unknown = columns - inputs;
    let matrix = reduced.submatrix(inputs, inputs, unknown, unknown).to_owned();
    let right = Mat::from_fn(unknown, inputs, |i, j| -reduced[(inputs + i, j)]);
    let a = solve_normal(&matrix, &right).ok()?;
    let companion = Mat::from_fn(unknown, unknown, |i, j| match i.checked_sub(inputs) {
        None => -a[(j, i)],
        Some(k) => f64::from(u8::from(k == j)),
    });
    eigenvalues(&companion).ok()
}
