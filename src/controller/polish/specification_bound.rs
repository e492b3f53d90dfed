//! The D-scaled largest singular value of the specification's loop at one line, and its derivative.
//!
//! M = E₁₁ + E₁₂ R E₂₁ with R = K (I − G K)⁻¹, δR = (I − K G)⁻¹ δK (I − G K)⁻¹. At the optimal D the derivative of the
//! bound is that of σ_max(D M D⁻¹) with D held (envelope theorem): δσ = Re tr(Q δK), Q = S b aᵀ S_u, aᵀ = uᴴ D E₁₂, b =
//! E₂₁ D⁻¹ v.

use super::loop_state::LoopState;
use super::matrix2::{Matrix2, ZERO, outer, row_times, times};
use super::responses::SpecificationLine;
use crate::linalg::{Mat, c64};
use crate::robust::mu::dscale::settled;
use crate::robust::structure::Structure;

/// Largest singular value and Q of its logarithm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    pub sigma: f64,
    pub q: Matrix2,
    /// Largest derivative of the logarithm by that of a scale; an optimum of scales has none, unless two singular
    /// values meet there.
    pub slope: f64,
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
    settled(&closed(line, r), structure).d
}

/// The bound at a line with these scales of the modal channels, of a loop with its G. Where a norm that is cheaper
/// shows that σ is below `floor`, that norm stands in its place, without a derivative.
pub(super) fn bound(
    line: &SpecificationLine,
    scales: &[f64],
    (state, g): (&LoopState, &Matrix2),
    floor: f64,
) -> Bound {
    let modal = scales.len().saturating_sub(1);
    let scale = |i: usize| match scales.get(i) {
        Some(d) if i < modal => *d,
        _ => 1.0,
    };
    let (rows, columns) = (line.direct.nrows(), line.direct.ncols());
    let below = |sigma: f64| Bound {
        sigma,
        q: [[ZERO; 2]; 2],
        slope: 0.0,
    };
    // D M D⁻¹, column after column.
    let mut m = Vec::with_capacity(rows * columns);
    let mut sum = 0.0;
    for j in 0..columns {
        let inner = times(&state.r, &[line.read[(0, j)], line.read[(1, j)]]);
        for i in 0..rows {
            let (e, f) = (line.drive[(i, 0)], line.drive[(i, 1)]);
            let entry = line.direct[(i, j)] + e * inner[0] + f * inner[1];
            let entry = entry * (scale(i) / scale(j));
            sum += entry.norm_sqr();
            m.push(entry);
        }
    }
    // σ ≤ ‖M‖_F.
    if sum < floor * floor || sum == 0.0 {
        return below(sum.sqrt());
    }
    let gram = gram(&m, rows, columns);
    // σ⁴ ≤ ‖MᴴM‖_F².
    let square = gram.iter().map(c64::norm_sqr).sum::<f64>().sqrt();
    if square < floor * floor {
        return below(square.sqrt());
    }
    let (sigma, v) = largest(&gram, columns);
    if sigma <= 0.0 {
        return below(sigma);
    }
    // u = M v/σ.
    let mut u = vec![ZERO; rows];
    for (column, v) in m.chunks_exact(rows).zip(&v) {
        for (u, entry) in u.iter_mut().zip(column) {
            *u += entry * v / sigma;
        }
    }
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
            &row_times(&a, &state.input_sensitivity(g)),
            c64::new(1.0 / sigma, 0.0),
        ),
        // The modal channels come first, one each.
        slope: (0..modal.min(rows).min(columns))
            .map(|k| (u[k].norm_sqr() - v[k].norm_sqr()).abs())
            .fold(0.0, f64::max),
    }
}

/// MᴴM of a matrix stored column after column, which is Hermitian: row after row.
fn gram(m: &[c64], rows: usize, n: usize) -> Vec<c64> {
    let mut gram = vec![ZERO; n * n];
    for i in 0..n {
        for j in i..n {
            let (a, b) = (&m[i * rows..(i + 1) * rows], &m[j * rows..(j + 1) * rows]);
            let entry = a.iter().zip(b).fold(ZERO, |sum, (a, b)| sum + a.conj() * b);
            gram[i * n + j] = entry;
            gram[j * n + i] = entry.conj();
        }
    }
    gram
}

/// Largest singular value with its right vector from MᴴM: the power method, started from a column of its 16th power.
fn largest(gram: &[c64], n: usize) -> (f64, Vec<c64>) {
    let mut power = gram.to_vec();
    let mut squared = vec![ZERO; n * n];
    for _ in 0..4 {
        let trace: f64 = (0..n).map(|i| power[i * n + i].re).sum();
        if trace.is_nan() || trace <= 0.0 {
            return (if trace.is_nan() { f64::NAN } else { 0.0 }, vec![ZERO; n]);
        }
        for entry in &mut power {
            *entry /= trace;
        }
        // (P²)ᵢⱼ of a Hermitian P is the product of its row i with the conjugate row j.
        for i in 0..n {
            for j in i..n {
                let (a, b) = (&power[i * n..(i + 1) * n], &power[j * n..(j + 1) * n]);
                let entry = a.iter().zip(b).fold(ZERO, |sum, (a, b)| sum + a * b.conj());
                squared[i * n + j] = entry;
                squared[j * n + i] = entry.conj();
            }
        }
        std::mem::swap(&mut power, &mut squared);
    }
    let mut column = 0;
    for i in 1..n {
        if power[i * n + i].re > power[column * n + column].re {
            column = i;
        }
    }
    let mut v: Vec<c64> = (0..n).map(|i| power[i * n + column]).collect();
    let image = |of: &[c64], v: &[c64]| -> Vec<c64> {
        of.chunks_exact(n)
            .map(|row| row.iter().zip(v).fold(ZERO, |sum, (p, v)| sum + p * v))
            .collect()
    };
    // Three more steps: a second value 1 % below the largest is left with 1e-3 of the vector, 1e-6 of the value.
    for _ in 0..3 {
        let w = image(&power, &v);
        let size = w.iter().map(c64::norm_sqr).sum::<f64>().sqrt();
        v = w.into_iter().map(|z| z / size).collect();
    }
    let own = image(gram, &v);
    let square: f64 = own.iter().zip(&v).map(|(g, v)| (g * v.conj()).re).sum();
    (square.max(0.0).sqrt(), v)
}

#[cfg(test)]
mod tests {
    use super::super::matrix2::ONE;
    use super::*;
    use crate::linalg::max_singular_value_complex;

    fn line(rows: usize, columns: usize) -> SpecificationLine {
        let entry = |i: usize, j: usize| {
            c64::from_polar(1.0 / (1.0 + (i * j) as f64), (3 * i + 7 * j) as f64)
        };
        SpecificationLine {
            direct: Mat::from_fn(rows, columns, entry),
            drive: Mat::from_fn(rows, 2, |i, k| entry(i + 1, k + 5)),
            read: Mat::from_fn(2, columns, |k, j| entry(k + 2, j)),
        }
    }

    #[test]
    fn a_bound_is_the_largest_singular_value_and_below_its_floor_a_larger_norm() {
        let (scales, r) = ([0.5, 3.0, 1.0], [[ONE, ZERO], [ZERO, -ONE]]);
        let state = LoopState {
            determinant: ONE,
            s: r,
            r,
            compliance: ZERO,
        };
        let line = line(7, 6);
        let d = |i: usize| if i < 2 { scales[i] } else { 1.0 };
        let m = closed(&line, &r);
        let scaled = Mat::from_fn(7, 6, |i, j| m[(i, j)] * (d(i) / d(j)));
        let exact = max_singular_value_complex(&scaled);
        let at = |floor: f64| bound(&line, &scales, (&state, &r), floor).sigma;
        // The power method ends 1e-6 off where the second singular value is close.
        assert!(
            (at(0.0) / exact - 1.0).abs() < 1e-6,
            "{} and {exact}",
            at(0.0)
        );
        assert!((at(exact) / exact - 1.0).abs() < 1e-6);
        let coarse = at(10.0 * exact);
        assert!(
            coarse >= exact && coarse < 10.0 * exact,
            "{coarse}, {exact}"
        );
    }
}
