//! Real modal form: a similarity transform to block-diagonal A with 1×1 (real pole) and 2×2 (pair σ ± jω) blocks.
//! Each block spans an invariant subspace, found by inverse iteration on its own eigenvalues; subspaces that are
//! nearly parallel (repeated or near-defective poles) are merged into one larger block with an orthonormal basis,
//! so that the transform stays well conditioned (idea: Bavely and Stewart, SIAM J. Numer. Anal. 16 (1979) 359).
//! States that A does not connect are treated apart, so decoupled planes stay exactly decoupled.
//! Symbols: A T = T diag(A₁, A₂, …), B̃ = T⁻¹B, C̃ = C T.

use super::{ControllerError, in_step};
use crate::linalg::basis::{condition, orthonormal_columns};
use crate::linalg::dense::balance;
use crate::linalg::{
    Mat, c64, eigenvalues, max_singular_value, max_singular_value_complex, solve, solve_complex,
};
use crate::lti::{Discrete, StateSpace};
use std::f64::consts::PI;

/// Largest condition number of the transform of balanced states. Six of the sixteen digits may go; the
/// coefficients that result still cancel by less than what single precision can carry in one block.
const LARGEST_CONDITION: f64 = 1e6;
/// Poles closer than this are one cluster from the start: a defective double pole splits by about √ε.
const CLUSTER_DISTANCE: f64 = 1e-7;
/// Accepted change of the transfer matrix, relative to its peak: well below single precision (6e-8).
const LARGEST_CHANGE: f64 = 1e-9;

/// A system in block-diagonal form with the certificate of the transform.
#[derive(Clone, Debug)]
pub struct ModalForm {
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
    /// Blocks that hold more than one pole or pair, because their poles (nearly) repeat.
    pub fn merged_blocks(&self) -> usize {
        self.blocks.iter().filter(|size| **size > 2).count()
    }
}

/// Transforms a sampled system to real modal form.
///
/// # Errors
/// [`ControllerError::Numeric`] when an eigenvalue iteration fails, [`ControllerError::Inaccurate`] when the
/// transformed system does not reproduce the transfer matrix.
pub fn block_diagonalise(system: &StateSpace<Discrete>) -> Result<ModalForm, ControllerError> {
    let n = system.order();
    let mut parts = Vec::new();
    let mut worst = 1.0f64;
    for states in connected_states(&system.a) {
        let a = Mat::from_fn(states.len(), states.len(), |i, j| {
            system.a[(states[i], states[j])]
        });
        let (balanced, scale) = balance(&a);
        let split = split(&balanced)?;
        worst = worst.max(split.condition);
        let inverse = solve(&split.transform, &Mat::identity(states.len(), states.len()))
            .map_err(in_step("modal form"))?;
        // x = D T x̃, hence B̃ = T⁻¹ D⁻¹ B and C̃ = C D T.
        let b = &inverse
            * Mat::from_fn(states.len(), system.inputs(), |i, j| {
                system.b[(states[i], j)] / scale[i]
            });
        let c = Mat::from_fn(system.outputs(), states.len(), |i, j| {
            system.c[(i, states[j])] * scale[j]
        }) * &split.transform;
        let full = &inverse * &balanced * &split.transform;
        let mut start = 0;
        for size in split.blocks {
            let block = full.submatrix(start, start, size, size).to_owned();
            parts.push(Part {
                frequency: mean_angle(&block)?,
                b: b.submatrix(start, 0, size, system.inputs()).to_owned(),
                c: c.submatrix(0, start, system.outputs(), size).to_owned(),
                a: block,
            });
            start += size;
        }
    }
    parts.sort_by(|p, q| p.frequency.total_cmp(&q.frequency));
    let (mut a, mut b) = (Mat::zeros(n, n), Mat::zeros(n, system.inputs()));
    let mut c = Mat::zeros(system.outputs(), n);
    let mut start = 0;
    for part in &parts {
        let size = part.a.nrows();
        a.submatrix_mut(start, start, size, size).copy_from(&part.a);
        b.submatrix_mut(start, 0, size, system.inputs())
            .copy_from(&part.b);
        c.submatrix_mut(0, start, system.outputs(), size)
            .copy_from(&part.c);
        start += size;
    }
    let modal =
        StateSpace::new(a, b, c, system.d.clone(), system.time).map_err(in_step("modal form"))?;
    let transfer_error = transfer_change(system, &modal);
    if transfer_error.is_nan() || transfer_error > LARGEST_CHANGE {
        return Err(ControllerError::Inaccurate {
            step: "modal form",
            error: transfer_error,
            allowed: LARGEST_CHANGE,
        });
    }
    Ok(ModalForm {
        system: modal,
        blocks: parts.iter().map(|p| p.a.nrows()).collect(),
        condition: worst,
        transfer_error,
    })
}

/// Largest difference of two transfer matrices on the unit circle, relative to the peak of the first, over
/// 64 points spaced evenly in the logarithm from 10⁻⁵ of the Nyquist frequency up to it.
pub fn transfer_change(first: &StateSpace<Discrete>, second: &StateSpace<Discrete>) -> f64 {
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

struct Part {
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

/// Poles of a block, pairs by their member in the upper half plane, with a basis of their invariant subspace.
struct Cluster {
    poles: Vec<c64>,
    basis: Mat<f64>,
}

fn split(a: &Mat<f64>) -> Result<Split, ControllerError> {
    let n = a.nrows();
    let mut clusters: Vec<Cluster> = Vec::new();
    for group in initial_groups(&eigenvalues(a).map_err(in_step("modal form"))?) {
        clusters.push(cluster(a, group)?);
    }
    loop {
        if clusters.len() <= 1 {
            // Nothing left to separate: the balanced matrix is its own best form.
            let trivial = clusters.first().is_none_or(|c| c.basis.ncols() > 2);
            let transform = match clusters.first() {
                Some(only) if !trivial => only.basis.clone(),
                _ => Mat::identity(n, n),
            };
            return Ok(Split {
                transform,
                blocks: if n == 0 { vec![] } else { vec![n] },
                condition: 1.0,
            });
        }
        let mut transform = Mat::zeros(n, n);
        let mut start = 0;
        for c in &clusters {
            transform
                .submatrix_mut(0, start, n, c.basis.ncols())
                .copy_from(&c.basis);
            start += c.basis.ncols();
        }
        let condition = condition(&transform).map_err(in_step("modal form"))?;
        if condition <= LARGEST_CONDITION {
            return Ok(Split {
                transform,
                blocks: clusters.iter().map(|c| c.basis.ncols()).collect(),
                condition,
            });
        }
        let (i, j) = most_parallel(&clusters);
        let second = clusters.remove(j);
        let first = clusters.remove(i);
        let poles = first.poles.into_iter().chain(second.poles).collect();
        clusters.push(cluster(a, poles)?);
    }
}

/// Pair of clusters with the smallest angle between their subspaces, i < j.
fn most_parallel(clusters: &[Cluster]) -> (usize, usize) {
    let orthonormal: Vec<Mat<f64>> = clusters
        .iter()
        .map(|c| orthonormal_columns(&c.basis))
        .collect();
    let (mut best, mut cosine) = ((0, 1), -1.0);
    for (j, second) in orthonormal.iter().enumerate() {
        for (i, first) in orthonormal.iter().enumerate().take(j) {
            let c = max_singular_value(&(first.transpose() * second));
            if c > cosine {
                (best, cosine) = ((i, j), c);
            }
        }
    }
    best
}

/// Eigenvalues with Im ≥ 0, grouped when they lie within [`CLUSTER_DISTANCE`].
fn initial_groups(poles: &[c64]) -> Vec<Vec<c64>> {
    let mut groups: Vec<Vec<c64>> = Vec::new();
    for pole in poles.iter().filter(|p| p.im >= 0.0) {
        let near = |q: &c64| (pole - q).norm() < CLUSTER_DISTANCE * pole.norm().max(1.0);
        match groups.iter_mut().find(|g| g.iter().any(near)) {
            Some(group) => group.push(*pole),
            None => groups.push(vec![*pole]),
        }
    }
    groups
}

fn cluster(a: &Mat<f64>, poles: Vec<c64>) -> Result<Cluster, ControllerError> {
    let n = a.nrows();
    let size: usize = poles.iter().map(|p| if p.im > 0.0 { 2 } else { 1 }).sum();
    let size = size.min(n);
    // Any start with a component along every direction serves; this one is fixed.
    let mut x = orthonormal_columns(&Mat::from_fn(n, size, |i, j| {
        let k = (i * 7919 + j * 104_729 + i * j * 31) % 1009;
        k as f64 / 1009.0 - 0.5 + if i == j { 2.0 } else { 0.0 }
    }));
    // The shift must not make the matrix exactly singular; 1e-13 keeps the wanted directions dominant by 1e6 and more.
    let offset = 1e-13 * a.norm_l2().max(f64::MIN_POSITIVE);
    // Two passes reach rounding level; the third is for clusters with spread poles.
    for _ in 0..3 {
        for pole in &poles {
            x = inverse_step(a, *pole + offset, &x)?;
        }
    }
    if let (2, Some(pole)) = (size, poles.first())
        && poles.len() == 1
        && pole.im > 0.0
    {
        x = rotation_basis(a, &x);
    }
    Ok(Cluster { poles, basis: x })
}

/// Orthonormal basis of (A − λI)⁻¹(A − λ̄I)⁻¹ X for a pair, of (A − λI)⁻¹ X for a real pole.
fn inverse_step(a: &Mat<f64>, pole: c64, x: &Mat<f64>) -> Result<Mat<f64>, ControllerError> {
    let shifted = |shift: c64| {
        Mat::from_fn(a.nrows(), a.nrows(), |i, j| {
            c64::new(a[(i, j)], 0.0) - if i == j { shift } else { c64::new(0.0, 0.0) }
        })
    };
    let mut y = Mat::from_fn(x.nrows(), x.ncols(), |i, j| c64::new(x[(i, j)], 0.0));
    y = solve_complex(&shifted(pole), &y);
    if pole.im != 0.0 {
        y = solve_complex(&shifted(pole.conj()), &y);
    }
    let largest = y.norm_max();
    let real = Mat::from_fn(x.nrows(), x.ncols(), |i, j| y[(i, j)].re / largest);
    if !real.is_all_finite() {
        return Err(ControllerError::Numeric {
            step: "modal form, inverse iteration",
            source: crate::linalg::NumericError::Singular {
                what: "A − λI",
                rcond: 0.0,
            },
        });
    }
    Ok(orthonormal_columns(&real))
}

/// Basis of a pair's plane in which A is [[σ, ω], [−ω, σ]]; the orthonormal basis itself when the pair is so close
/// to a double real pole that the rotation form would be ill conditioned.
fn rotation_basis(a: &Mat<f64>, q: &Mat<f64>) -> Mat<f64> {
    let block = q.transpose() * a * q;
    let (a11, a12, a21, a22) = (block[(0, 0)], block[(0, 1)], block[(1, 0)], block[(1, 1)]);
    let half = 0.5 * (a11 - a22);
    let omega2 = -(half * half + a12 * a21);
    if omega2 <= 0.0 {
        return q.clone();
    }
    let pole = c64::new(0.5 * (a11 + a22), omega2.sqrt());
    let v = if a12.abs() >= a21.abs() {
        [c64::new(a12, 0.0), pole - a11]
    } else {
        [pole - a22, c64::new(a21, 0.0)]
    };
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
                label
                    .iter_mut()
                    .filter(|l| **l == drop)
                    .for_each(|l| *l = keep);
            }
        }
    }
    (0..n)
        .map(|l| (0..n).filter(|i| label[*i] == l).collect::<Vec<_>>())
        .filter(|states| !states.is_empty())
        .collect()
}
