//! The D-scaled largest singular value of the specification's loop at one line, and its derivative.
//!
//! M = E₁₁ + E₁₂ R E₂₁ with R = K (I − G K)⁻¹, δR = (I − K G)⁻¹ δK (I − G K)⁻¹. At the optimal D the derivative of the
//! bound is that of σ_max(D M D⁻¹) with D held (envelope theorem): δσ = Re tr(Q δK), Q = S b aᵀ S_u, aᵀ = uᴴ D E₁₂, b =
//! E₂₁ D⁻¹ v.

use super::loop_state::LoopState;
use super::matrix2::{Matrix2, ZERO, outer, row_times, times};
use super::responses::SpecificationLine;
use crate::linalg::{Mat, c64};
use crate::robust::mu::dscale::optimal;
use crate::robust::structure::Structure;

/// Largest singular value and Q of its logarithm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    pub sigma: f64,
    pub q: Matrix2,
}

/// M of a line for a loop.
fn closed(line: &SpecificationLine, r: &Matrix2) -> Mat<c64> {
    let (rows, columns) = (line.direct.nrows(), line.direct.ncols());
    Mat::from_fn(rows, columns, |i, j| {
        let (e, f) = (&line.drive, &line.read);
        let left = row_times(&[e[(i, 0)], e[(i, 1)]], r);
        line.direct[(i, j)] + left[0] * f[(0, j)] + left[1] * f[(1, j)]
    })
}

/// The best scales of a line, one per block, the last (performance) 1.
pub(super) fn best_scales(
    line: &SpecificationLine,
    r: &Matrix2,
    structure: &Structure,
) -> Vec<f64> {
    optimal(&closed(line, r), structure).d
}

/// The bound at a line with these scales of the modal channels; S = (I − G K)⁻¹, S_u = (I − K G)⁻¹ of the loop, R = K
/// S.
pub(super) fn bound(
    line: &SpecificationLine,
    scales: &[f64],
    state: &LoopState,
    r: &Matrix2,
) -> Bound {
    let d = |i: usize| scales.get(i).copied().unwrap_or(1.0);
    let modal = scales.len().saturating_sub(1);
    let scale = |i: usize| if i < modal { d(i) } else { 1.0 };
    let mut m = closed(line, r);
    let (rows, columns) = (m.nrows(), m.ncols());
    for i in 0..rows {
        for j in 0..columns {
            m[(i, j)] *= scale(i) / scale(j);
        }
    }
    let (sigma, v) = largest(&m);
    if sigma <= 0.0 {
        return Bound {
            sigma,
            q: [[ZERO; 2]; 2],
        };
    }
    // u = M v/σ.
    let u: Vec<c64> = (0..rows)
        .map(|i| (0..columns).fold(ZERO, |sum, j| sum + m[(i, j)] * v[j]) / sigma)
        .collect();
    let a = [0, 1].map(|k| {
        (0..rows).fold(ZERO, |sum, i| {
            sum + u[i].conj() * line.drive[(i, k)] * scale(i)
        })
    });
    let b =
        [0, 1].map(|k| (0..columns).fold(ZERO, |sum, j| sum + line.read[(k, j)] * v[j] / scale(j)));
    Bound {
        sigma,
        q: outer(
            &times(&state.s, &b),
            &row_times(&a, &state.su),
            c64::new(1.0 / sigma, 0.0),
        ),
    }
}

/// Largest singular value with its right vector: the power method on MᴴM, started from a column of its 16th power.
fn largest(m: &Mat<c64>) -> (f64, Vec<c64>) {
    let n = m.ncols();
    let gram = m.adjoint() * m;
    let mut power = gram.clone();
    for _ in 0..4 {
        let trace: f64 = (0..n).map(|i| power[(i, i)].re).sum();
        if trace.is_nan() || trace <= 0.0 {
            return (if trace.is_nan() { f64::NAN } else { 0.0 }, vec![ZERO; n]);
        }
        for i in 0..n {
            for j in 0..n {
                power[(i, j)] /= trace;
            }
        }
        power = &power * &power;
    }
    let mut column = 0;
    for i in 1..n {
        if power[(i, i)].re > power[(column, column)].re {
            column = i;
        }
    }
    let mut v: Vec<c64> = (0..n).map(|i| power[(i, column)]).collect();
    let mut square = 0.0;
    // Three more steps: a second value 1 % below the largest is left with 1e-3 of the vector, 1e-6 of the value.
    for _ in 0..3 {
        let w: Vec<c64> = (0..n)
            .map(|i| (0..n).fold(ZERO, |sum, j| sum + power[(i, j)] * v[j]))
            .collect();
        let size = w.iter().map(c64::norm_sqr).sum::<f64>().sqrt();
        v = w.into_iter().map(|z| z / size).collect();
        let image = (0..n).map(|i| (0..n).fold(ZERO, |sum, j| sum + gram[(i, j)] * v[j]));
        square = image.zip(&v).map(|(g, v)| (g * v.conj()).re).sum();
    }
    (square.max(0.0).sqrt(), v)
}
