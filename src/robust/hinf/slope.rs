//! Derivative of the smallest feasible level by the matrices of the plant: that of the coupling, where it binds
//! ([`super::couplings`]), and those of the sides.
//!
//! Where one side binds, γ = σmax(ΠP₁₁(jω)) at its peak; the derivative there is that of a singular value, uᴴ dP f with
//! f = [v; −P₁₂⁺P₁₁v] (a peak does not move to first order).

use super::couplings::{BindingLevel, Couplings, NEAR};
use super::matrix_slope::MatrixSlope;
use super::riccati_pair::solve_pair;
use super::search::GammaSearch;
use super::side::{Regulator, RiccatiSide, beyond_control};
use crate::linalg::dense::complex;
use crate::linalg::hermitian::singular_vectors;
use crate::linalg::riccati::RiccatiEffort;
use crate::linalg::{Mat, c64, solve_complex};
use crate::lti::level_set::Peak;
use crate::robust::error::SynthesisError;

/// The levels that bind at the optimum `gamma` of a search, or nearly: those of the largest eigenvalues of XY, and of
/// the two sides.
pub(super) fn binding_levels(search: &GammaSearch, gamma: f64) -> Result<Vec<BindingLevel>, SynthesisError> {
    let normal = &search.normal;
    let (control, filter) = (&search.control, &search.filter);
    // No solution at the end of a bracket means that a side binds.
    let mut found = match solve_pair(control, filter, gamma, RiccatiEffort::Fast)? {
        Some(found) if found.coupling.is_definite() => Couplings::new(control, filter, &found, gamma)?.levels(normal),
        _ => vec![],
    };
    let [control_level, filter_level] = search.levels()?;
    let near = |level: &Peak| level.lower >= gamma * (1.0 - NEAR);
    let mut add = |level: &Peak, slope: &MatrixSlope| {
        found.push(BindingLevel {
            ln_level: level.lower.ln(),
            slope: normal.pulled_back(&normal.zero_slope().plus(slope)),
        });
    };
    if near(&control_level) {
        let slope = axis_slope(control, &search.control_regulator, &control_level)?;
        add(&control_level, &slope);
    }
    if near(&filter_level) {
        let slope = axis_slope(filter, &search.filter_regulator, &filter_level)?;
        add(&filter_level, &slope.transpose());
    }
    Ok(found)
}

/// d ln of the level of one side at its peak.
fn axis_slope(side: &RiccatiSide, regulator: &Regulator, level: &Peak) -> Result<MatrixSlope, SynthesisError> {
    let (n, m1, m2) = (side.a.nrows(), side.b1.ncols(), side.b2.ncols());
    let closed = side.close_regulator(regulator);
    let (b, c) = (complex(&closed.b), complex(&closed.c));
    let finite = level.omega_rad_s.is_finite();
    let pencil = Mat::from_fn(n, n, |i, j| {
        let diagonal = if i == j { level.omega_rad_s } else { 0.0 };
        c64::new(-closed.a[(i, j)], diagonal)
    });
    let states = if finite { solve_complex(&pencil, &b) } else { Mat::zeros(n, m1 + m2) };
    let (rest, reached) = beyond_control(&(&c * &states + complex(&closed.d)), m1);
    let (left, values, right) = singular_vectors(&rest)?;
    let (u, v) = (left.subcols(0, 1).to_owned(), right.subcols(0, 1));
    // The disturbance v and the control that answers it best, around the feedback F₂.
    let answer = &reached * v;
    let around = Mat::from_fn(m1 + m2, 1, |i, _| if i < m1 { v[(i, 0)] } else { -answer[(i - m1, 0)] });
    let x = &states * &around;
    let regulated = complex(&regulator.f) * &x;
    let f =
        Mat::from_fn(m1 + m2, 1, |i, _| if i < m1 { around[(i, 0)] } else { around[(i, 0)] + regulated[(i - m1, 0)] });
    let y = if finite { solve_complex(&pencil.adjoint().to_owned(), &(c.adjoint() * &u)) } else { Mat::zeros(n, 1) };
    // d ln σ = Re uᴴ dP f / σ.
    let outer = |left: &Mat<c64>, right: &Mat<c64>| {
        Mat::from_fn(left.nrows(), right.nrows(), |i, j| (left[(i, 0)].conj() * right[(j, 0)]).re / values[0])
    };
    Ok(MatrixSlope { a: outer(&y, &x), b: outer(&y, &f), c: outer(&u, &x), d: outer(&u, &f) })
}
