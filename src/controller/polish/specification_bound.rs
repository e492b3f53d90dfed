//! The D-scaled largest singular value of the specification's loop at one line, and its derivative.
//!
//! M = E₁₁ + E₁₂ R E₂₁ with R = K (I − G K)⁻¹, δR = (I − K G)⁻¹ δK (I − G K)⁻¹. At the optimal D the derivative of the
//! bound is that of σ_max(D M D⁻¹) with D held (envelope theorem): δσ = Re tr(Q δK), Q = S b aᵀ S_u, aᵀ = uᴴ D E₁₂, b =
//! E₂₁ D⁻¹ v.

use super::line_scales::LineScales;
use super::loop_state::LoopState;
use super::matrix2::{Matrix2, ZERO, outer, row_times, times};
use super::responses::SpecificationLine;
use crate::linalg::lanes::{HermitianLanes, Lanes, Largest, groups};
use crate::linalg::{Mat, c64};
use crate::robust::mu::dscale::settle_scaling;
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

/// Column j of M for a loop without its direct part: R E₂₁.
fn currents(line: &SpecificationLine, r: &Matrix2, j: usize) -> [c64; 2] {
    times(r, &line.read[j])
}

/// Group `g` of column j of M = E₁₁ + E₁₂ R E₂₁, of the column's currents.
#[inline]
fn closed_group(line: &SpecificationLine, currents: &[c64; 2], g: usize, j: usize) -> Lanes {
    let [front, rear] = &line.drive;
    line.direct[j * groups(line.rows) + g].plus(currents[0], &front[g]).plus(currents[1], &rear[g])
}

/// M of a line for a loop.
fn close_line(line: &SpecificationLine, r: &Matrix2) -> Mat<c64> {
    let columns: Vec<Vec<Lanes>> = (0..line.read.len())
        .map(|j| {
            let currents = currents(line, r, j);
            let list = (0..groups(line.rows)).map(|g| closed_group(line, &currents, g, j));
            list.collect()
        })
        .collect();
    Mat::from_fn(line.rows, columns.len(), |i, j| Lanes::at(&columns[j], i))
}

/// The best scales of a line, one per block, the last (performance) 1.
pub(super) fn best_scales(line: &SpecificationLine, r: &Matrix2, structure: &Structure) -> Vec<f64> {
    settle_scaling(&close_line(line, r), structure).d
}

impl Bound {
    /// A norm in the place of σ, without a derivative.
    pub(super) fn at_most(sigma: f64) -> Self {
        Self { sigma, q: [[ZERO; 2]; 2], slope: 0.0 }
    }
}

/// The bound at a line with these scales of the modal channels, of a loop with its G. Where a norm that is cheaper
/// shows that σ is below `floor`, that norm stands in its place.
pub(super) fn bound_line(
    line: &SpecificationLine,
    scales: &LineScales,
    state: &LoopState,
    g: &Matrix2,
    floor: f64,
) -> Bound {
    // D M D⁻¹, column after column.
    let (columns, height) = (line.read.len(), groups(line.rows));
    let mut m = Vec::with_capacity(columns * height);
    for j in 0..columns {
        let (currents, own) = (currents(line, &state.r, j), scales.of(j));
        m.extend((0..height).map(|h| closed_group(line, &currents, h, j).times(scales.group(h) / own)));
    }
    let gram = HermitianLanes::gram(&m, height);
    let (square, v) = match gram.largest_above(floor * floor) {
        Largest::Value(square, v) => (square, v),
        Largest::Below(square) => return Bound::at_most(square.sqrt()),
    };
    // What is not a number goes on.
    if square <= 0.0 {
        return Bound::at_most(0.0);
    }
    let sigma = square.sqrt();
    // u = M v/σ.
    let mut u = vec![Lanes::ZERO; height];
    for (j, column) in m.chunks_exact(height).enumerate() {
        let factor = Lanes::at(&v, j) / sigma;
        for (u, group) in u.iter_mut().zip(column) {
            *u = u.plus(factor, group);
        }
    }
    let scaled: Vec<Lanes> = (0..height).map(|h| u[h].times(scales.group(h))).collect();
    let a = [0, 1].map(|k| Lanes::inner(&scaled, &line.drive[k]));
    let b = [0, 1].map(|k| (0..columns).fold(ZERO, |sum, j| sum + line.read[j][k] * Lanes::at(&v, j) / scales.of(j)));
    Bound {
        sigma,
        q: outer(&times(&state.s, &b), &row_times(&a, &state.input_sensitivity(g)), c64::new(1.0 / sigma, 0.0)),
        // The modal channels come first, one each.
        slope: (0..scales.modal().min(line.rows).min(columns))
            .map(|k| (Lanes::at(&u, k).norm_sqr() - Lanes::at(&v, k).norm_sqr()).abs())
            .fold(0.0, f64::max),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::matrix2::ONE;
    use super::*;
    use crate::linalg::max_singular_value_complex;

    pub(in super::super) fn entry(i: usize, j: usize) -> c64 {
        c64::from_polar(1.0 / (1.0 + (i * j) as f64), (3 * i + 7 * j) as f64)
    }

    /// E₁₁ of entries (i, j), E₁₂ of (i + 1, k + 5), E₂₁ of (k + 2, j).
    pub(in super::super) fn line(rows: usize, columns: usize) -> SpecificationLine {
        SpecificationLine {
            rows,
            direct: Lanes::columns(rows, columns, entry),
            drive: [0, 1].map(|k| Lanes::columns(rows, 1, |i, _| entry(i + 1, k + 5))),
            read: (0..columns).map(|j| [0, 1].map(|k| entry(k + 2, j))).collect(),
        }
    }

    #[test]
    fn a_bound_is_the_largest_singular_value_and_below_its_floor_a_larger_norm() {
        let (scales, r) = ([0.5, 3.0, 1.0], [[ONE, ZERO], [ZERO, -ONE]]);
        let state = LoopState { s: r, r, compliance: ZERO };
        let line = line(7, 6);
        let d = |i: usize| if i < 2 { scales[i] } else { 1.0 };
        let m = close_line(&line, &r);
        let scaled = Mat::from_fn(7, 6, |i, j| m[(i, j)] * (d(i) / d(j)));
        let exact = max_singular_value_complex(&scaled);
        let scales = LineScales::new(scales.to_vec());
        let at = |floor: f64| bound_line(&line, &scales, &state, &r, floor).sigma;
        // The power method ends 1e-6 off where the second singular value is close.
        assert!((at(0.0) / exact - 1.0).abs() < 1e-6, "{} and {exact}", at(0.0));
        assert!((at(exact) / exact - 1.0).abs() < 1e-6);
        let coarse = at(10.0 * exact);
        assert!(coarse >= exact && coarse < 10.0 * exact, "{coarse}, {exact}");
    }
}
