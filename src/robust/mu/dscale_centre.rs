//! Method of centres for the diagonal scale of least gain: Newton's method on −log det S(x), S = βX_R − MᴴX_L M, with β
//! the square of a bound, lowered along the path of centres (Boyd and El Ghaoui 1993).
//!
//! A step that ends is one with a certificate. For the Newton step δ along cᵀδ = 0 the matrix Z = G − GΔSG, G = S⁻¹, is
//! positive definite as long as the decrement is below one, and tr ZA_k = −μc_k for every block with A_k = ∂S/∂x_k, so
//! no scale reaches below β − μ max(c_k / tr Z_k): for any scale some block has more gain in Z than that.

use crate::linalg::dense::dot;
use crate::linalg::fixed::{Columns, Fixed};
use crate::linalg::planar::Planar;
use std::ops::Range;

/// Columns and rows of M that a block owns.
pub(crate) type BlockRange = (Range<usize>, Range<usize>);

/// A scale with what it proves.
#[derive(Clone, Debug)]
pub(crate) struct Centre {
    /// Squares of the scales, one per block.
    pub x: Vec<f64>,
    /// No scale has a squared bound below this.
    pub at_least: f64,
    pub steps: usize,
    /// Whether the end that was asked for is reached; rounding may end the method before.
    pub ended: bool,
}

/// Where the method ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// Where the certificate says that the bound is within [`GAP`].
    Proven,
    /// Where the tangent of the path says that it falls by no more than [`SETTLED`].
    Settled,
}

/// Relative width of β at which the method ends: half of it in the bound, far below the 1e-4 asked of one.
const GAP: f64 = 1e-8;
/// Fall along the tangent, relative to β, at which a scale is settled. What is left of β was 3.2 times as much at most
/// on 60 000 matrices of four machines: 2e-7 of the bound, of which 1e-4 is asked.
const SETTLED: f64 = 1e-7;
/// Newton steps in all; 12 to 40 are usual.
const MAX_STEPS: usize = 250;
/// Start of β over σ_max² = 1, so that x = 1 is strictly inside.
const START: f64 = 1.05;
/// The level falls while the decrement is below this; a full step is safe below one.
const NEAR: f64 = 0.9;
/// Below this decrement the next fall is bolder.
const CENTRED: f64 = 0.4;
/// Share of what the slope promises that a step towards the centre has to lower −log det S.
const LOWERED: f64 = 0.1;
/// Share of the distance to the boundary that is always left: of the order of the error of its estimate.
const LEFT: f64 = 3e-3;

/// Centres of a matrix with σ_max = 1 for its blocks, from x = 1.
pub(crate) fn centres(m: &Planar, blocks: &[BlockRange], until: End) -> Centre {
    match m.rows().max(m.cols()) {
        0..=4 => centres_in::<Fixed<4>>(m, blocks, until),
        5..=8 => centres_in::<Fixed<8>>(m, blocks, until),
        _ => centres_in::<Planar>(m, blocks, until),
    }
}

/// The same in matrices of some kind.
fn centres_in<M: Columns>(m: &Planar, blocks: &[BlockRange], until: End) -> Centre {
    let n = blocks.len();
    let mut work = Work::<M>::new(m, blocks);
    let mut end = Centre { x: vec![1.0; n], at_least: 0.0, steps: 0, ended: false };
    let (mut level, mut left) = (START, 0.1);
    if !work.factor(&end.x, level) {
        return end;
    }
    let (mut step, mut moved) = (Step::of(n), vec![0.0; n]);
    while end.steps < MAX_STEPS {
        end.steps += 1;
        work.differentiate(&end.x, level);
        if !step.renew(&work, &end.x, level) {
            break;
        }
        end.at_least = end.at_least.max(step.at_least);
        let settled = step.decrement < NEAR && step.distance <= SETTLED * level;
        end.ended = match until {
            End::Proven => level - end.at_least <= GAP * level,
            End::Settled => settled,
        };
        if end.ended {
            break;
        }
        // A full step is safe below a decrement of one.
        let far = step.decrement >= NEAR;
        let here = if far { work.barrier() } else { 0.0 };
        let mut try_step = |length: f64, fall: f64| {
            for (k, x) in moved.iter_mut().enumerate() {
                *x = end.x[k] + length * step.own[k] + fall * step.tangent[k];
            }
            let inside = moved.iter().all(|v| *v > 0.0);
            let inside = inside && work.factor(&moved, level - fall);
            let promised = length * step.decrement * step.decrement;
            let lowered = !far || work.barrier() <= here - LOWERED * promised;
            (inside && lowered).then_some(level - fall)
        };
        let mut next = None;
        if step.decrement < NEAR {
            if step.decrement < CENTRED {
                left = f64::max(0.3 * left, LEFT);
            }
            while next.is_none() && left < 0.99 {
                next = try_step(1.0, (1.0 - left) * step.distance);
                if next.is_none() {
                    left = if left < 0.1 { 4.0 * left } else { 0.5 + 0.5 * left };
                }
            }
            left = if next.is_none() { 0.2 } else { left };
        }
        let mut length = 1.0;
        while next.is_none() && length > 1e-8 {
            next = try_step(length, 0.0);
            length *= 0.5;
        }
        match next {
            Some(lower) => level = lower,
            None => break,
        }
        std::mem::swap(&mut end.x, &mut moved);
    }
    end
}

/// Storage of the matrices of a Newton step, and the derivatives of −log det S.
struct Work<'a, M> {
    rows: usize,
    cols: usize,
    m: M,
    /// Mᵀ.
    transposed: M,
    blocks: &'a [BlockRange],
    /// S, then its Cholesky factor L.
    s: M,
    /// L⁻ᵀ.
    inverse: M,
    /// (L⁻¹Mᴴ)ᵀ.
    half: M,
    /// G = S⁻¹, MG, MGMᴴ; of the Hermitian ones the upper triangle.
    g: M,
    mg: M,
    mgm: M,
    gradient: Vec<f64>,
    hessian: Vec<f64>,
    /// tr G over the columns of each block, and its derivatives by −x_j (row k: block k).
    trace: Vec<f64>,
    trace_fall: Vec<f64>,
    /// ∂gradient/∂β.
    by_level: Vec<f64>,
    /// tr(G X_R G X_R).
    curvature: f64,
}

impl<'a, M: Columns> Work<'a, M> {
    fn new(m: &Planar, blocks: &'a [BlockRange]) -> Self {
        let (p, q, n) = (m.rows(), m.cols(), blocks.len());
        let (mut own, mut transposed) = (M::zeros(p, q), M::zeros(q, p));
        for j in 0..q {
            for i in 0..p {
                own.set(i, j, m.at(i, j));
                transposed.set(j, i, m.at(i, j));
            }
        }
        Self {
            rows: p,
            cols: q,
            m: own,
            transposed,
            blocks,
            s: M::zeros(q, q),
            inverse: M::zeros(q, q),
            half: M::zeros(p, q),
            g: M::zeros(q, q),
            mg: M::zeros(p, q),
            mgm: M::zeros(p, p),
            gradient: vec![0.0; n],
            hessian: vec![0.0; n * n],
            trace: vec![0.0; n],
            trace_fall: vec![0.0; n * n],
            by_level: vec![0.0; n],
            curvature: 0.0,
        }
    }

    /// Cholesky factor of S; false when S is not positive definite.
    fn factor(&mut self, x: &[f64], level: f64) -> bool {
        let q = self.cols;
        self.s.clear();
        for ((w, z), x) in self.blocks.iter().zip(x) {
            for k in w.clone() {
                self.s.add_real(k, k, level * x);
            }
            for i in z.clone() {
                for j in 0..q {
                    let (re, im) = self.transposed.at(j, i);
                    let row = (&self.transposed, i);
                    self.s.add_conj(j..q, j, (-x * re, -x * im), row);
                }
            }
        }
        self.s.cholesky(q)
    }

    /// −log det S, after `factor`.
    fn barrier(&self) -> f64 {
        let diagonal = (0..self.cols).map(|i| self.s.at(i, i).0.ln());
        -2.0 * diagonal.sum::<f64>()
    }

    /// G, MG and MGMᴴ from the factor of S.
    fn products(&mut self) {
        let (p, q) = (self.rows, self.cols);
        self.s.invert_lower_transposed(q, &mut self.inverse);
        for matrix in [&mut self.half, &mut self.g, &mut self.mg, &mut self.mgm] {
            matrix.clear();
        }
        for r in 0..q {
            for j in 0..=r {
                let a = self.inverse.at(j, r);
                self.half.add_conj(0..p, r, a, (&self.m, j));
            }
        }
        for j in 0..q {
            for r in j..q {
                let a = self.inverse.at(j, r);
                self.mg.add_conj(0..p, j, a, (&self.half, r));
                self.g.add_conj(0..j + 1, j, a, (&self.inverse, r));
            }
        }
        for b in 0..p {
            for r in 0..q {
                let a = self.half.at(b, r);
                self.mgm.add_conj(0..b + 1, b, a, (&self.half, r));
            }
        }
    }

    /// Gradient, Hessian and the derivatives by the level, after `factor`.
    fn differentiate(&mut self, x: &[f64], level: f64) {
        self.products();
        let n = x.len();
        self.curvature = 0.0;
        self.by_level.fill(0.0);
        for k in 0..n {
            let (w, z) = &self.blocks[k];
            let diagonal = |of: &M, span: &Range<usize>| -> f64 { span.clone().map(|i| of.at(i, i).0).sum() };
            let trace = diagonal(&self.g, w);
            self.trace[k] = trace;
            self.gradient[k] = diagonal(&self.mgm, z) - level * trace;
            self.by_level[k] -= trace;
            for j in 0..=k {
                let (wj, zj) = &self.blocks[j];
                let gg = squares_above(&self.g, wj, w);
                let pp = squares_above(&self.mgm, zj, z);
                let (jk, kj) = (squares(&self.mg, zj, w), squares(&self.mg, z, wj));
                let value = level * (level * gg - jk - kj) + pp;
                self.hessian[j * n + k] = value;
                self.hessian[k * n + j] = value;
                self.trace_fall[k * n + j] = level * gg - jk;
                self.trace_fall[j * n + k] = level * gg - kj;
                self.by_level[k] += x[j] * (level * gg - kj);
                if j < k {
                    self.by_level[j] += x[k] * (level * gg - jk);
                }
                self.curvature += if j < k { 2.0 } else { 1.0 } * x[j] * x[k] * gg;
            }
        }
    }
}

/// Σ|entry|² over rows and columns.
fn squares<M: Columns>(of: &M, rows: &Range<usize>, cols: &Range<usize>) -> f64 {
    let mut sum = 0.0;
    for j in cols.clone() {
        for i in rows.clone() {
            sum += of.square_of(i, j);
        }
    }
    sum
}

/// The same for a Hermitian matrix of which the upper triangle is stored; `rows` are before `cols` or the same.
fn squares_above<M: Columns>(of: &M, rows: &Range<usize>, cols: &Range<usize>) -> f64 {
    if rows.start != cols.start {
        return squares(of, rows, cols);
    }
    let mut sum = 0.0;
    for j in cols.clone() {
        for i in rows.start..j {
            sum += 2.0 * of.square_of(i, j);
        }
        sum += of.square_of(j, j);
    }
    sum
}

/// A Newton step with the tangent of the path of centres.
struct Step {
    /// Newton step at the present level.
    own: Vec<f64>,
    /// Derivative of the centre by a fall of the level.
    tangent: Vec<f64>,
    decrement: f64,
    /// Estimate of how far the level can fall along the tangent.
    distance: f64,
    /// No scale has a squared bound below this.
    at_least: f64,
    /// Hessian made definite, then its factor.
    factor: Vec<f64>,
    ones: Vec<f64>,
    /// What the Hessian makes of ones, the gradient and its derivative by the level.
    solutions: [Vec<f64>; 3],
}

impl Step {
    /// Storage for `n` blocks.
    fn of(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Self {
            own: zeros(),
            tangent: zeros(),
            decrement: 0.0,
            distance: 0.0,
            at_least: 0.0,
            factor: vec![0.0; n * n],
            ones: vec![1.0; n],
            solutions: [zeros(), zeros(), zeros()],
        }
    }

    /// The step of what was differentiated; false when the Hessian is not definite to rounding.
    fn renew<M: Columns>(&mut self, work: &Work<M>, x: &[f64], level: f64) -> bool {
        let (n, q) = (x.len(), work.cols);
        // The scale of x is free: cᵀδ = 0 with c = 1 fixes it. There a multiple of ccᵀ changes nothing, and the Hessian
        // is nearly singular in the direction of x without it.
        let weight = (0..n).map(|k| work.hessian[k * n + k]).sum::<f64>() / n as f64;
        for (own, h) in self.factor.iter_mut().zip(&work.hessian) {
            *own = h + weight;
        }
        let rhs = [&self.ones, &work.gradient, &work.by_level];
        if !solve_definite(&mut self.factor, rhs, &mut self.solutions) {
            return false;
        }
        let [hc, hg, drift] = &self.solutions;
        let sum = |v: &[f64]| v.iter().sum::<f64>();
        let (pull, slope) = (sum(hg) / sum(hc), sum(drift) / sum(hc));
        let (own, tangent) = (&mut self.own, &mut self.tangent);
        for k in 0..n {
            own[k] = pull * hc[k] - hg[k];
            tangent[k] = drift[k] - slope * hc[k];
        }
        let squared = (-dot(own, &work.gradient)).max(0.0);
        // tr ZS = q − decrement² at this step.
        let mu = (q as f64 - squared) / sum(x);
        let traces = (0..n).map(|k| work.trace[k] - dot(&work.trace_fall[k * n..(k + 1) * n], own));
        let at_least = if squared < 1.0 { traces.map(|t| level - mu / t).fold(f64::INFINITY, f64::min) } else { 0.0 };
        // Along the tangent S falls linearly; if its small eigenvalues vanish together they do so at tr GS' / tr(GS')².
        let first = dot(&work.trace, x) + dot(tangent, &work.gradient);
        let mut second = work.curvature;
        for k in 0..n {
            let row = dot(&work.hessian[k * n..(k + 1) * n], tangent);
            second += tangent[k] * (row - 2.0 * (work.by_level[k] + work.trace[k]));
        }
        let all_finite = own.iter().chain(&*tangent).all(|v| v.is_finite());
        self.decrement = squared.sqrt();
        self.distance = first / second;
        self.at_least = if at_least.is_finite() { at_least } else { 0.0 };
        all_finite && first > 0.0 && second > 0.0
    }
}

/// Solutions of a real symmetric definite system, row after row, whose lower triangle becomes its Cholesky factor;
/// false when it is not definite.
fn solve_definite(l: &mut [f64], rhs: [&Vec<f64>; 3], solutions: &mut [Vec<f64>; 3]) -> bool {
    let n = rhs[0].len();
    // Row i of L, with the reciprocal of its diagonal entry.
    for i in 0..n {
        let (above, own) = l.split_at_mut(i * n);
        for (j, row) in above.chunks_exact(n).enumerate() {
            own[j] = (own[j] - dot(&own[..j], &row[..j])) * row[j];
        }
        let pivot = own[i] - dot(&own[..i], &own[..i]);
        if !(pivot > 0.0 && pivot.is_finite()) {
            return false;
        }
        own[i] = pivot.sqrt().recip();
    }
    for (b, y) in rhs.into_iter().zip(solutions) {
        y.copy_from_slice(b);
        for (i, row) in l.chunks_exact(n).enumerate() {
            y[i] = (y[i] - dot(&row[..i], &y[..i])) * row[i];
        }
        for (i, row) in l.chunks_exact(n).enumerate().rev() {
            let (before, own) = y.split_at_mut(i);
            own[0] *= row[i];
            for (y, l) in before.iter_mut().zip(row) {
                *y -= l * own[0];
            }
        }
    }
    true
}
