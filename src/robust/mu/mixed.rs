//! The D,G upper bound: full Dᵢ for repeated scalars, G for real parameters (Fan, Tits, Doyle 1991), by the method of
//! centres for generalised eigenvalues (Boyd and El Ghaoui 1993).
//!
//!   minimise λ  subject to  S = λX_R − MᴴX_L M − j(GM − MᴴGᴴ) ≻ 0,   X ≻ 0,   tr X_R = dim w
//!
//! Newton's method finds the centre of a level, where −log det S − log det X is least; the level then falls to just
//! above the bound that the centre proves. Symbols: λ = β², v holds the entries of X and G.

use crate::linalg::dense::solve_normal;
use crate::linalg::hermitian::{cholesky, inverse_complex};
use crate::linalg::{Mat, NumericError, c64, max_singular_value_complex};
use crate::robust::structure::{Scaling, Span, Structure};

/// Share of the distance between a level and the bound of its centre that the next level keeps.
const KEPT: f64 = 0.1;
/// Fraction of the least level within which a level counts as settled: half of it in the bound, a thousandth of what a
/// bound may be off by.
const SETTLED: f64 = 2e-7;
/// Levels at most: each divides the distance to the least one by about ten, of which seven decades are asked.
const MAX_LEVELS: usize = 40;
/// Newton steps of one level at most; a centre that is not reached then is only a worse start of the next.
const MAX_STEPS: usize = 60;
/// A centre is near enough for the next level below this decrement: the quadratic range of Newton's method.
const CENTRED: f64 = 0.25;
/// Share of the promised fall of the barrier that a step has to keep.
const LOWERED: f64 = 0.1;
/// −r X ⪯ G ⪯ r X with this r in units of the scaled matrix. Where rounding alone makes an entry of M complex a G
/// without limit would prove a bound of zero.
const G_RANGE: f64 = 1e5;
/// Part of the diagonal of the Hessian that is added to it: a G with next to no effect leaves it nearly singular.
const RIDGE: f64 = 1e-13;
/// Coordinates that are tried: those of the start, in which an optimum with X near the boundary (real parameters) stays
/// well scaled, then those of what was found, which reach a D of large condition.
const FRAMES: usize = 4;

/// Improves a scaling until the bound settles. The returned scaling is never worse than the one given.
///
/// # Errors
/// [`NumericError`] when the bound of the start cannot be evaluated.
pub fn optimal(m: &Mat<c64>, structure: &Structure, start: Scaling) -> Result<Scaling, NumericError> {
    let mut level = start.squared_bound(m)?;
    let mut best = start;
    for _ in 0..FRAMES {
        let before = level;
        // λ ≤ 0 proves μ = 0 already.
        if level > 0.0
            && let Some((found, lower)) = descend(m, structure, &best)
            && lower < level
        {
            (best, level) = (found, lower);
        }
        if level <= 0.0 || before - level <= SETTLED * level {
            break;
        }
    }
    Ok(best)
}

/// The levels in the coordinates of `frame`: the best scaling and the λ that it proves.
fn descend(m: &Mat<c64>, structure: &Structure, frame: &Scaling) -> Option<(Scaling, f64)> {
    let scaled = frame.apply(m);
    let size = max_singular_value_complex(&scaled);
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let unit = Mat::from_fn(m.nrows(), m.ncols(), |i, j| scaled[(i, j)] / size);
    let barrier = Barrier::new(&unit, structure);
    let mut v = barrier.start(structure, frame, size);
    let prove = |v: &[f64]| {
        let scaling = recompose(frame, structure, &barrier.blocks(v, false), &barrier.blocks(v, true), size)?;
        let squared = scaling.squared_bound(m).ok()?;
        Some((scaling, squared))
    };
    let mut best = prove(&v)?;
    let mut bound = best.1 / (size * size);
    // The start is strictly inside of its first level.
    let mut level = 1.05 * bound;
    for _ in 0..MAX_LEVELS {
        if bound <= 0.0 || !barrier.centre(&mut v, level) {
            break;
        }
        let Some(found) = prove(&v) else { break };
        bound = found.1 / (size * size);
        if found.1 < best.1 {
            best = found;
        }
        let gap = level - bound;
        // An estimate: an ellipsoid around a centre lies inside, and `order` times as wide it holds all that does. The
        // bound itself is evaluated, whatever the estimate is worth.
        if gap.is_nan() || gap * barrier.order <= SETTLED * bound {
            break;
        }
        level = bound + KEPT * gap;
    }
    Some(best)
}

/// An entry of X or G.
struct Variable {
    span: usize,
    is_skew: bool,
    element: Element,
}

/// What a variable adds to a matrix that stays definite: fixed + λ · by_level.
struct Term {
    variable: usize,
    by_level: Mat<c64>,
    fixed: Mat<c64>,
}

/// −log det of S, of the blocks of X, and of rX ± G in place of X for real parameters.
struct Barrier {
    variables: Vec<Variable>,
    /// Sizes of the blocks of X.
    sizes: Vec<usize>,
    /// S, then the others.
    matrices: Vec<Vec<Term>>,
    /// Trace of X_R by the variables.
    trace: Vec<f64>,
    /// Sum of the sizes of all matrices.
    order: f64,
}

impl Barrier {
    fn new(m: &Mat<c64>, structure: &Structure) -> Self {
        let q = structure.inputs();
        let size = |span: &Span| if span.has_scalar_scaling() { 1 } else { span.w.len() };
        let sizes: Vec<usize> = structure.spans.iter().map(size).collect();
        let mut own = Self { variables: vec![], matrices: vec![vec![]], trace: vec![], order: q as f64, sizes };
        for (k, span) in structure.spans.iter().enumerate() {
            let n = own.sizes[k];
            let constant = |variable, fixed: Mat<c64>| {
                let by_level = Mat::zeros(fixed.nrows(), fixed.nrows());
                Term { variable, by_level, fixed }
            };
            let scale = |factor: f64, element: &Element| {
                let matrix = element.matrix(n);
                Mat::from_fn(n, n, |i, j| matrix[(i, j)] * factor)
            };
            // X, or rX + G and rX − G.
            let mut definite = if span.is_real() { vec![vec![], vec![]] } else { vec![vec![]] };
            for element in hermitian_basis(n) {
                let fixed = scale_term(m, span, &element, 0.0);
                let by_level = scale_term(m, span, &element, 1.0) - &fixed;
                let variable = own.variables.len();
                own.matrices[0].push(Term { variable, by_level, fixed });
                let range = if span.is_real() { G_RANGE } else { 1.0 };
                definite.iter_mut().for_each(|terms| terms.push(constant(variable, scale(range, &element))));
                let is_diagonal = element.row == element.col;
                own.trace.push(if is_diagonal { span.w.len() as f64 / n as f64 } else { 0.0 });
                own.variables.push(Variable { span: k, is_skew: false, element });
            }
            for element in hermitian_basis(if span.is_real() { n } else { 0 }) {
                let variable = own.variables.len();
                own.matrices[0].push(constant(variable, skew_term(m, span, &element)));
                for (terms, sign) in definite.iter_mut().zip([1.0, -1.0]) {
                    terms.push(constant(variable, scale(sign, &element)));
                }
                own.trace.push(0.0);
                own.variables.push(Variable { span: k, is_skew: true, element });
            }
            own.order += (n * definite.len()) as f64;
            own.matrices.extend(definite);
        }
        own
    }

    /// X = I and the G of the frame.
    fn start(&self, structure: &Structure, frame: &Scaling, size: f64) -> Vec<f64> {
        let entry = |variable: &Variable| {
            let Element { row, col, value } = variable.element;
            let span = &structure.spans[variable.span];
            if variable.is_skew {
                (value.conj() * frame.skew[(span.w.start + row, span.z.start + col)]).re / size
            } else {
                f64::from(u8::from(row == col))
            }
        };
        self.variables.iter().map(entry).collect()
    }

    /// The blocks of X, or those of G.
    fn blocks(&self, v: &[f64], is_skew: bool) -> Vec<Mat<c64>> {
        let mut blocks: Vec<Mat<c64>> = self.sizes.iter().map(|n| Mat::zeros(*n, *n)).collect();
        for (variable, value) in self.variables.iter().zip(v).filter(|(variable, _)| variable.is_skew == is_skew) {
            let n = self.sizes[variable.span];
            let element = variable.element.matrix(n);
            blocks[variable.span] += Mat::from_fn(n, n, |i, j| element[(i, j)] * *value);
        }
        blocks
    }

    /// Cholesky factors of all matrices; `None` outside.
    fn factors(&self, v: &[f64], level: f64) -> Option<Vec<Mat<c64>>> {
        let sum = |terms: &Vec<Term>| {
            let n = terms[0].fixed.nrows();
            let entry = |i, j| {
                let terms = terms.iter();
                terms.map(|t| (t.fixed[(i, j)] + t.by_level[(i, j)] * level) * v[t.variable]).sum::<c64>()
            };
            cholesky(&Mat::from_fn(n, n, entry))
        };
        self.matrices.iter().map(sum).collect()
    }

    /// Moves v to the centre of a level; false when v is not inside or the step cannot be computed.
    fn centre(&self, v: &mut Vec<f64>, level: f64) -> bool {
        let Some(mut factors) = self.factors(v, level) else { return false };
        for _ in 0..MAX_STEPS {
            let Some(step) = self.newton(&factors, level) else { return false };
            if step.decrement < CENTRED {
                return true;
            }
            let here = log_barrier(&factors);
            let mut length = 1.0;
            loop {
                let moved: Vec<f64> = v.iter().zip(&step.direction).map(|(v, d)| v + length * d).collect();
                let fall = LOWERED * length * step.decrement * step.decrement;
                if let Some(next) = self.factors(&moved, level)
                    && log_barrier(&next) <= here - fall
                {
                    (*v, factors) = (moved, next);
                    break;
                }
                length *= 0.5;
                // Rounding leaves no step: the present point is the centre as far as it can be told.
                if length < 1e-6 {
                    return true;
                }
            }
        }
        true
    }

    /// The Newton step that keeps the trace of X_R; `None` when the Hessian is singular.
    fn newton(&self, factors: &[Mat<c64>], level: f64) -> Option<NewtonStep> {
        let n = self.variables.len();
        let (mut gradient, mut hessian) = (vec![0.0; n], Mat::<f64>::zeros(n, n));
        for (terms, factor) in self.matrices.iter().zip(factors) {
            let inverse = inverse_complex(factor);
            // L⁻¹ ∂S L⁻ᴴ, each as a column of real numbers.
            let size = factor.nrows();
            let mut columns = Mat::<f64>::zeros(2 * size * size, terms.len());
            for (k, term) in terms.iter().enumerate() {
                let moved = Mat::from_fn(size, size, |i, j| term.fixed[(i, j)] + term.by_level[(i, j)] * level);
                let seen = &inverse * moved * inverse.adjoint();
                gradient[term.variable] -= (0..size).map(|i| seen[(i, i)].re).sum::<f64>();
                for (at, value) in seen.col_iter().flat_map(|c| c.iter().copied().collect::<Vec<_>>()).enumerate() {
                    (columns[(2 * at, k)], columns[(2 * at + 1, k)]) = (value.re, value.im);
                }
            }
            let gram = columns.transpose() * &columns;
            for (k, a) in terms.iter().enumerate() {
                for (l, b) in terms.iter().enumerate() {
                    hessian[(a.variable, b.variable)] += gram[(k, l)];
                }
            }
        }
        for k in 0..n {
            hessian[(k, k)] *= 1.0 + RIDGE;
        }
        let rhs = Mat::from_fn(n, 2, |k, c| if c == 0 { gradient[k] } else { self.trace[k] });
        let solution = solve_normal(&hessian, &rhs).ok()?;
        let along = |c: usize| (0..n).map(|k| self.trace[k] * solution[(k, c)]).sum::<f64>();
        let pull = along(0) / along(1);
        let direction: Vec<f64> = (0..n).map(|k| pull * solution[(k, 1)] - solution[(k, 0)]).collect();
        let squared = -direction.iter().zip(&gradient).map(|(d, g)| d * g).sum::<f64>();
        squared.is_finite().then(|| NewtonStep { direction, decrement: squared.max(0.0).sqrt() })
    }
}

/// A step of Newton's method.
struct NewtonStep {
    direction: Vec<f64>,
    /// How far the centre is in the metric of the Hessian.
    decrement: f64,
}

/// −log det of the matrices with these Cholesky factors.
fn log_barrier(factors: &[Mat<c64>]) -> f64 {
    let diagonal = |l: &Mat<c64>| (0..l.nrows()).map(|i| l[(i, i)].re.ln()).sum::<f64>();
    -2.0 * factors.iter().map(diagonal).sum::<f64>()
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
