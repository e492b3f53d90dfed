//! Real modal form: a similarity transform to block-diagonal A with 1×1 (real pole) and 2×2 (pair σ ± jω) blocks.
//! Poles that (nearly) repeat share one larger block, so that the transform stays well conditioned and the transfer
//! matrix is kept; how close poles may be for blocks of their own follows from these two checks, not from a distance.
//! Source: Bavely and Stewart, SIAM J. Numer. Anal. 16 (1979) 359 (`crate::linalg::block_diagonal`).
//! States that A does not connect are treated apart, so decoupled planes stay exactly decoupled.
//! Symbols: A T = T diag(A₁, A₂, …), B̃ = T⁻¹B, C̃ = C T.

use super::{ControllerError, in_step};
use crate::linalg::basis::condition;
use crate::linalg::block_diagonal::invariant_bases;
use crate::linalg::dense::balance;
use crate::linalg::lyapunov::sylvester;
use crate::linalg::{Mat, NumericError, c64, eigenvalues, max_singular_value_complex, solve};
use crate::lti::{Discrete, StateSpace};
use std::f64::consts::PI;

/// Largest condition number of the transform of balanced states. Six of the sixteen digits may go; the
/// coefficients that result still cancel by less than what single precision can carry in one block.
const LARGEST_CONDITION: f64 = 1e6;
/// Limits on the coupling of two blocks that are tried in this order. The first gives the smallest blocks that the
/// condition number allows at all, every further one gives a digit of accuracy for larger blocks; zero leaves one
/// block.
const COUPLING_LIMITS: [f64; 8] = [1e6, 1e5, 1e4, 1e3, 1e2, 10.0, 1.0, 0.0];
/// Newton steps on the transform: the first leaves the square of the Schur form's rounding, the second what the first
/// rounds.
const REFINEMENTS: usize = 2;
/// A longer step is none of refinement: it loses its own second order above the digits that it gains.
const LARGEST_STEP: f64 = 1e-6;
/// Accepted change of the transfer matrix, relative to its peak: well below single precision (6e-8).
pub(crate) const LARGEST_CHANGE: f64 = 1e-9;
/// Where no form reaches that, because the states of the controller as given hold its slow poles no better (companion
/// forms of high order), the most accurate form serves up to this change: a hundredth of what rounding of firmware may
/// change.
const LARGEST_SAID_CHANGE: f64 = 1e-4;

/// A system in block-diagonal form with the certificate of the transform.
#[derive(Clone, Debug)]
pub(crate) struct ModalForm {
    /// The system in modal coordinates.
    pub system: StateSpace<Discrete>,
    /// Sizes of the diagonal blocks of A, in order; they sum to the order.
    pub blocks: Vec<usize>,
    /// Largest condition number of the transform over the decoupled parts (balanced states).
    pub condition: f64,
    /// Largest change of the transfer matrix over check frequencies, relative to its peak.
    pub transfer_error: f64,
}

impl ModalForm {
    /// Sizes of the blocks that hold more than one pole or pair, because their poles (nearly) repeat.
    pub(crate) fn merged_blocks(&self) -> impl Iterator<Item = usize> {
        self.blocks.iter().copied().filter(|size| *size > 2)
    }
}

/// Transforms a sampled system to real modal form with the smallest blocks that keep the transfer matrix; with a change
/// beyond [`LARGEST_CHANGE`] where the system as given allows no less.
pub(crate) fn block_diagonalise(system: &StateSpace<Discrete>) -> Result<ModalForm, ControllerError> {
    let mut best: Option<ModalForm> = None;
    for limit in COUPLING_LIMITS {
        let form = block_diagonal(system, limit)?;
        if form.condition > LARGEST_CONDITION {
            continue;
        }
        if form.transfer_error <= LARGEST_CHANGE {
            return Ok(form);
        }
        if best.as_ref().is_none_or(|b| form.transfer_error < b.transfer_error || b.transfer_error.is_nan()) {
            best = Some(form);
        }
    }
    let error = best.as_ref().map_or(f64::NAN, |form| form.transfer_error);
    best.filter(|form| form.transfer_error <= LARGEST_SAID_CHANGE).ok_or(ControllerError::Inaccurate {
        step: "modal form",
        error,
        allowed: LARGEST_SAID_CHANGE,
    })
}

/// The form with no coupling solution above `limit`, its accuracy measured and not yet judged.
fn block_diagonal(system: &StateSpace<Discrete>, limit: f64) -> Result<ModalForm, ControllerError> {
    let mut parts = Vec::new();
    let mut worst = 1.0f64;
    for states in connected_states(&system.a) {
        worst = worst.max(separate(system, &states, limit, &mut parts)?);
    }
    parts.sort_by(|p, q| p.frequency.total_cmp(&q.frequency));
    let n = system.order();
    let (mut a, mut b) = (Mat::zeros(n, n), Mat::zeros(n, system.inputs()));
    let mut c = Mat::zeros(system.outputs(), n);
    let mut start = 0;
    for part in &parts {
        let size = part.a.nrows();
        a.submatrix_mut(start, start, size, size).copy_from(&part.a);
        b.submatrix_mut(start, 0, size, system.inputs()).copy_from(&part.b);
        c.submatrix_mut(0, start, system.outputs(), size).copy_from(&part.c);
        start += size;
    }
    let modal = StateSpace::new(a, b, c, system.d.clone(), system.time).map_err(in_step("modal form"))?;
    Ok(ModalForm {
        transfer_error: transfer_change(system, &modal),
        system: modal,
        blocks: parts.iter().map(|p| p.a.nrows()).collect(),
        condition: worst,
    })
}

/// Adds the blocks of the given states to `parts`; returns the condition number of their transform.
fn separate(
    system: &StateSpace<Discrete>,
    states: &[usize],
    limit: f64,
    parts: &mut Vec<ModalPart>,
) -> Result<f64, ControllerError> {
    let n = states.len();
    let a = Mat::from_fn(n, n, |i, j| system.a[(states[i], states[j])]);
    let (balanced, scale) = balance(&a);
    let split = split(&balanced, limit)?;
    let inverse = solve(&split.transform, &Mat::identity(n, n)).map_err(in_step("modal form"))?;
    // x = D T x̃, hence B̃ = T⁻¹ D⁻¹ B and C̃ = C D T.
    let b = &inverse * Mat::from_fn(n, system.inputs(), |i, j| system.b[(states[i], j)] / scale[i]);
    let c = Mat::from_fn(system.outputs(), n, |i, j| system.c[(i, states[j])] * scale[j]) * &split.transform;
    let full = &inverse * &balanced * &split.transform;
    let mut start = 0;
    for size in split.blocks {
        let block = full.submatrix(start, start, size, size).to_owned();
        parts.push(ModalPart {
            frequency: mean_angle(&block)?,
            b: b.submatrix(start, 0, size, system.inputs()).to_owned(),
            c: c.submatrix(0, start, system.outputs(), size).to_owned(),
            a: block,
        });
        start += size;
    }
    Ok(split.condition)
}

/// Largest difference of two transfer matrices on the unit circle, relative to the peak of the first, over
/// 64 points spaced evenly in the logarithm from 10⁻⁵ of the Nyquist frequency up to it.
pub(crate) fn transfer_change(first: &StateSpace<Discrete>, second: &StateSpace<Discrete>) -> f64 {
    let (mut peak, mut change) = (f64::MIN_POSITIVE, 0.0f64);
    for k in 0..64 {
        let z = c64::from_polar(1.0, PI * 10f64.powf(-5.0 * (1.0 - k as f64 / 63.0)));
        let (g, h) = (first.transfer(z), second.transfer(z));
        let difference = max_singular_value_complex(&(&g - &h));
        if difference.is_nan() {
            return f64::NAN;
        }
        peak = peak.max(max_singular_value_complex(&g));
        change = change.max(difference);
    }
    change / peak
}

struct ModalPart {
    frequency: f64,
    a: Mat<f64>,
    b: Mat<f64>,
    c: Mat<f64>,
}

struct Split {
    transform: Mat<f64>,
    blocks: Vec<usize>,
    condition: f64,
}

/// Bases of the blocks of a balanced matrix; no coupling solution above `limit`.
fn split(a: &Mat<f64>, limit: f64) -> Result<Split, ControllerError> {
    let n = a.nrows();
    let bases = invariant_bases(a, limit).map_err(in_step("modal form"))?;
    if bases.len() == 1 && n > 2 {
        // Nothing is separated: the balanced matrix stays as it is, and no digit is lost.
        return Ok(Split { transform: Mat::identity(n, n), blocks: vec![n], condition: 1.0 });
    }
    let mut transform = Mat::zeros(n, n);
    let mut start = 0;
    for basis in &bases {
        let basis = rotation_basis(a, basis);
        let size = basis.ncols();
        transform.submatrix_mut(0, start, n, size).copy_from(&basis);
        start += size;
    }
    let blocks: Vec<usize> = bases.iter().map(Mat::ncols).collect();
    for _ in 0..REFINEMENTS {
        transform = refine_blocks(a, &transform, &blocks).map_err(in_step("modal form"))?;
    }
    Ok(Split { condition: condition(&transform).map_err(in_step("modal form"))?, transform, blocks })
}

/// One Newton step on T⁻¹AT = diag(Aₖ) + E: T ← T(I + P) with AᵢPᵢⱼ − PᵢⱼAⱼ = −Eᵢⱼ takes the rounding of the Schur form
/// out, which an integrator would magnify at low frequencies.
fn refine_blocks(a: &Mat<f64>, transform: &Mat<f64>, blocks: &[usize]) -> Result<Mat<f64>, NumericError> {
    let n = a.nrows();
    let full = solve(transform, &(a * transform))?;
    let mut correction = Mat::<f64>::identity(n, n);
    let starts: Vec<usize> = blocks
        .iter()
        .scan(0, |next, size| {
            *next += size;
            Some(*next - size)
        })
        .collect();
    let part = |i: usize, j: usize, sign: f64| {
        Mat::from_fn(blocks[i], blocks[j], |r, c| sign * full[(starts[i] + r, starts[j] + c)])
    };
    for i in 0..blocks.len() {
        for j in (0..blocks.len()).filter(|j| *j != i) {
            // Blocks that share a pole have no bounded step; their coupling stays, and the transfer matrix tells
            // whether it matters.
            let p = sylvester(&part(i, i, 1.0), &part(j, j, -1.0), &part(i, j, -1.0));
            if let Some(p) = p.ok().filter(|p| p.norm_l2() <= LARGEST_STEP) {
                correction.submatrix_mut(starts[i], starts[j], blocks[i], blocks[j]).copy_from(&p);
            }
        }
    }
    Ok(transform * correction)
}

/// Basis of a pair's plane in which A is [[σ, ω], [−ω, σ]]; the orthonormal basis itself for any other block and when
/// the pair is so close to a double real pole that the rotation form would be ill conditioned.
fn rotation_basis(a: &Mat<f64>, q: &Mat<f64>) -> Mat<f64> {
    if q.ncols() != 2 {
        return q.clone();
    }
    let block = q.transpose() * a * q;
    let (a11, a12, a21, a22) = (block[(0, 0)], block[(0, 1)], block[(1, 0)], block[(1, 1)]);
    let half = 0.5 * (a11 - a22);
    let omega2 = -(half * half + a12 * a21);
    if omega2 <= 0.0 {
        return q.clone();
    }
    let pole = c64::new(0.5 * (a11 + a22), omega2.sqrt());
    let v = if a12.abs() >= a21.abs() { [c64::new(a12, 0.0), pole - a11] } else { [pole - a22, c64::new(a21, 0.0)] };
    // Turn the phase until real and imaginary part are orthogonal.
    let turn = c64::from_polar(1.0, -0.5 * (v[0] * v[0] + v[1] * v[1]).arg());
    let v = [v[0] * turn, v[1] * turn];
    let (real, imaginary) = (v[0].re.hypot(v[1].re), v[0].im.hypot(v[1].im));
    // Three digits at most are given away to the symmetric form.
    if imaginary < 1e-3 * real {
        return q.clone();
    }
    let small = Mat::from_fn(2, 2, |i, j| (if j == 0 { v[i].re } else { v[i].im }) / real);
    q * small
}

/// Mean |arg λ| of a block: where it stands in the list.
fn mean_angle(block: &Mat<f64>) -> Result<f64, ControllerError> {
    let poles = eigenvalues(block).map_err(in_step("modal form"))?;
    let sum: f64 = poles.iter().map(|p| p.arg().abs()).sum();
    Ok(sum / poles.len().max(1) as f64)
}

/// Sets of states that A connects, each ascending, ordered by their first state.
fn connected_states(a: &Mat<f64>) -> Vec<Vec<usize>> {
    let n = a.nrows();
    let mut label: Vec<usize> = (0..n).collect();
    for i in 0..n {
        for j in 0..n {
            if a[(i, j)] != 0.0 && label[i] != label[j] {
                let (keep, drop) = (label[i].min(label[j]), label[i].max(label[j]));
                label.iter_mut().filter(|l| **l == drop).for_each(|l| *l = keep);
            }
        }
    }
    (0..n).map(|l| (0..n).filter(|i| label[*i] == l).collect::<Vec<_>>()).filter(|states| !states.is_empty()).collect()
}
