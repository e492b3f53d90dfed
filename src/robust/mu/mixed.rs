//! The D,G upper bound as matrix inequalities: full Dᵢ for repeated scalars, G for real parameters (Fan, Tits, Doyle
//! 1991).
//!
//!   minimise t  subject to  MᴴX_L M + j(GM − MᴴGᴴ) − λX_R ⪯ t I,   X ⪰ 0,   tr X_R = dim w
//!
//! in coordinates in which a good scale is the identity, then λ ← the bound of the new scale, evaluated (Dinkelbach;
//! the convergence is superlinear). Symbols: λ = β².

use super::lmi::{MatrixInequality, Programme, SparseRow};
use crate::linalg::hermitian::{cholesky, inverse_complex};
use crate::linalg::{Mat, NumericError, c64, max_singular_value_complex};
use crate::robust::structure::{Scaling, Span, Structure};

/// Programmes solved at most; three to six are usual.
const MAX_ROUNDS: usize = 15;
/// λ counts as settled when a round lowers it by less than this fraction: half of it in β.
const SETTLED: f64 = 1e-7;
/// X stays within this factor of the present scale in one round.
const X_RANGE: f64 = 1e7;
/// G stays below this many times the size of the scaled matrix in one round.
const G_RANGE: f64 = 1e5;

/// Improves a scaling until the bound settles. The returned scaling is never worse than the one given.
///
/// First in the coordinates of the start, where an optimum with X near the boundary (real parameters) stays well
/// scaled; then in coordinates that follow the scaling, which reaches optima with a D of large condition.
///
/// # Errors
/// [`NumericError`] when the bound of the start cannot be evaluated.
pub fn optimal(m: &Mat<c64>, structure: &Structure, start: Scaling) -> Result<Scaling, NumericError> {
    let mut best = start.clone();
    let mut level = best.squared_bound(m)?;
    for frame in [Some(&start), None] {
        for _ in 0..MAX_ROUNDS {
            // λ ≤ 0 proves μ = 0 already.
            if level <= 0.0 {
                return Ok(best);
            }
            let frame = frame.unwrap_or(&best);
            let Some((next, lower)) = run_round(m, structure, frame, level) else {
                break;
            };
            if lower.is_nan() || lower >= level {
                break;
            }
            let settled = level - lower <= SETTLED * level.abs();
            (best, level) = (next, lower);
            if settled {
                break;
            }
        }
    }
    Ok(best)
}

/// One programme in the coordinates of `frame`: the scaling it leads to and the λ that this proves.
fn run_round(m: &Mat<c64>, structure: &Structure, frame: &Scaling, level: f64) -> Option<(Scaling, f64)> {
    let scaled = frame.apply(m);
    let size = max_singular_value_complex(&scaled);
    if size.is_nan() || size <= 0.0 {
        return None;
    }
    let unit = Mat::from_fn(m.nrows(), m.ncols(), |i, j| scaled[(i, j)] / size);
    let (x, g) = improve(&unit, structure, level / (size * size))?;
    let next = recompose(frame, structure, &x, &g, size)?;
    let lower = next.squared_bound(m).ok()?;
    Some((next, lower))
}

/// A basis element of a Hermitian n×n matrix: (row, column, value) and its mirror.
#[derive(Clone, Copy)]
struct Element {
    row: usize,
    col: usize,
    value: c64,
}

fn hermitian_basis(n: usize) -> Vec<Element> {
    let (one, j) = (c64::new(1.0, 0.0), c64::new(0.0, 1.0));
    let mut basis = vec![];
    for col in 0..n {
        for row in 0..=col {
            basis.push(Element { row, col, value: one });
            if row != col {
                basis.push(Element { row, col, value: j });
            }
        }
    }
    basis
}

impl Element {
    fn matrix(&self, n: usize) -> Mat<c64> {
        let mut e = Mat::zeros(n, n);
        e[(self.row, self.col)] = self.value;
        e[(self.col, self.row)] = self.value.conj();
        e
    }
}

/// X and G of one programme, per block as matrices (1×1 for a full block).
fn improve(m: &Mat<c64>, structure: &Structure, level: f64) -> Option<(Vec<Mat<c64>>, Vec<Mat<c64>>)> {
    let q = structure.inputs();
    let mut terms: Vec<(usize, Mat<c64>)> = vec![(0, Mat::identity(q, q))];
    let mut programme = Programme::default();
    let mut layout: Vec<(usize, bool, Vec<Element>, usize)> = vec![];
    let mut trace = vec![];
    let mut next = 1;
    for (k, span) in structure.spans.iter().enumerate() {
        let n = if span.has_scalar_scaling() { 1 } else { span.w.len() };
        let basis = hermitian_basis(n);
        for (e, element) in basis.iter().enumerate() {
            terms.push((next + e, scale_term(m, span, element, level)));
            if element.row == element.col {
                trace.push((next + e, span.w.len() as f64 / n as f64));
            }
        }
        bound_variables(&mut programme, &basis, next, n, 1.0 / X_RANGE, f64::INFINITY);
        layout.push((k, false, basis.clone(), next));
        next += basis.len();
        if span.is_real() {
            for (e, element) in basis.iter().enumerate() {
                terms.push((next + e, skew_term(m, span, element)));
            }
            bound_variables(&mut programme, &basis, next, n, -G_RANGE, G_RANGE);
            layout.push((k, true, basis.clone(), next));
            next += basis.len();
        }
    }
    programme.objective = vec![0.0; next];
    programme.objective[0] = 1.0;
    programme.equalities.push(SparseRow { terms: trace, bound: q as f64 });
    programme.matrices.push(MatrixInequality { constant: Mat::zeros(q, q), terms });
    let optimum = programme.solve().ok()?;
    let blocks = structure.spans.len();
    let mut x = vec![Mat::zeros(0, 0); blocks];
    let mut g = vec![Mat::zeros(0, 0); blocks];
    for (k, is_skew, basis, first) in layout {
        let n = basis.iter().map(|e| e.col + 1).max().unwrap_or(0);
        let mut sum = Mat::<c64>::zeros(n, n);
        for (e, element) in basis.iter().enumerate() {
            let value = element.value * optimum.x[first + e];
            sum[(element.row, element.col)] += value;
            if element.row != element.col {
                sum[(element.col, element.row)] += value.conj();
            }
        }
        if is_skew {
            g[k] = sum;
        } else {
            x[k] = sum;
        }
    }
    Some((x, g))
}

/// λE_w − M_zᴴ E M_z for a basis element E of X.
fn scale_term(m: &Mat<c64>, span: &Span, element: &Element, level: f64) -> Mat<c64> {
    let q = m.ncols();
    let mut f = Mat::<c64>::zeros(q, q);
    if span.has_scalar_scaling() {
        let rows = m.get(span.z.clone(), ..);
        let product = rows.adjoint() * rows;
        for j in 0..q {
            for i in 0..q {
                f[(i, j)] = -product[(i, j)];
            }
        }
        for k in span.w.clone() {
            f[(k, k)] += level;
        }
        return f;
    }
    let rows = m.get(span.z.clone(), ..);
    let e = element.matrix(span.w.len());
    let product = rows.adjoint() * &e * rows;
    for j in 0..q {
        for i in 0..q {
            f[(i, j)] = -product[(i, j)];
        }
    }
    let w = span.w.start;
    for j in 0..span.w.len() {
        for i in 0..span.w.len() {
            f[(w + i, w + j)] += e[(i, j)] * level;
        }
    }
    f
}

/// −j(E M − MᴴE) for a basis element E of G.
fn skew_term(m: &Mat<c64>, span: &Span, element: &Element) -> Mat<c64> {
    let q = m.ncols();
    let product = element.matrix(span.w.len()) * m.get(span.z.clone(), ..);
    let mut placed = Mat::<c64>::zeros(q, q);
    for j in 0..q {
        for i in 0..span.w.len() {
            placed[(span.w.start + i, j)] = product[(i, j)];
        }
    }
    Mat::from_fn(q, q, |i, j| c64::new(0.0, -1.0) * (placed[(i, j)] - placed[(j, i)].conj()))
}

/// lo·I ⪯ Σ xᵢEᵢ ⪯ hi·I.
fn bound_variables(programme: &mut Programme, basis: &[Element], first: usize, n: usize, lo: f64, hi: f64) {
    for (sign, limit) in [(1.0, lo), (-1.0, -hi)] {
        if !limit.is_finite() {
            continue;
        }
        // sign·Σ xᵢEᵢ ⪰ limit·I
        if n == 1 {
            programme.inequalities.push(SparseRow { terms: vec![(first, -sign)], bound: -limit });
            continue;
        }
        let scaled = |e: &Element| {
            let m = e.matrix(n);
            Mat::from_fn(n, n, |i, j| m[(i, j)] * sign)
        };
        programme.matrices.push(MatrixInequality {
            constant: Mat::from_fn(n, n, |i, j| c64::new(if i == j { -limit } else { 0.0 }, 0.0)),
            terms: basis.iter().enumerate().map(|(e, element)| (first + e, scaled(element))).collect(),
        });
    }
}

/// The present scaling followed by X = LLᴴ: D ← LᴴD, G̃ = size·L⁻¹GL⁻ᴴ.
fn recompose(present: &Scaling, structure: &Structure, x: &[Mat<c64>], g: &[Mat<c64>], size: f64) -> Option<Scaling> {
    let mut step = Scaling::identity(structure);
    for (k, span) in structure.spans.iter().enumerate() {
        let l = cholesky(&x[k])?;
        if span.has_scalar_scaling() {
            for i in span.z.clone() {
                step.left[(i, i)] = l[(0, 0)];
            }
            for i in span.w.clone() {
                step.right[(i, i)] = l[(0, 0)];
            }
            continue;
        }
        let n = span.w.len();
        for j in 0..n {
            for i in 0..n {
                let value = l[(j, i)].conj();
                step.left[(span.z.start + i, span.z.start + j)] = value;
                step.right[(span.w.start + i, span.w.start + j)] = value;
            }
        }
        if span.is_real() {
            let inverse = inverse_complex(&l);
            let skew = &inverse * &g[k] * inverse.adjoint();
            for j in 0..n {
                for i in 0..n {
                    // Exactly Hermitian, whatever the rounding of the products.
                    let even = (skew[(i, j)] + skew[(j, i)].conj()) * (0.5 * size);
                    step.skew[(span.w.start + i, span.z.start + j)] = even;
                }
            }
        }
    }
    Some(Scaling { left: &step.left * &present.left, right: &step.right * &present.right, skew: step.skew })
}
