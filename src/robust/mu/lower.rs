//! Lower bound of μ: a Δ of the structure with det(I − ΔM) = 0, found by local ascent from several starts.
//!
//! μ is the largest |λ| (real parameters: the largest real λ > 0) of an eigenvalue of ΔM over all Δ with σ_max(Δ) ≤ 1.
//! With right and left eigenvectors x, y the derivative of λ is yᴴ dΔ Mx / yᴴx, linear in Δ, so the best Δ of the
//! linear model is known block by block (a dyad, a phase, a sign); this is the step of the power iteration of Packard,
//! Fan and Doyle (1988), here safeguarded by a line search. With real parameters the model is maximised subject to Im λ
//! = 0: its multiplier is a phase ψ found by bisection (Young and Doyle 1990 iterate on the same conditions).
//!
//! Every value returned is checked: Δ is scaled so that ΔM has the eigenvalue 1, and σ_min(I − ΔM) is evaluated.
//! Limits: a local search. The bound can be low with real parameters, where no method of polynomial cost is exact.

use crate::linalg::hermitian::{min_singular_value, singular_vectors};
use crate::linalg::{Mat, c64, eigenvalues_complex, max_singular_value_complex};
use crate::robust::structure::{Scaling, Span, Structure};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A perturbation that makes the loop singular.
#[derive(Clone, Debug)]
pub struct SingularDelta {
    /// 1/σ_max(Δ): a lower bound of μ; 0 when no Δ was found.
    pub value: f64,
    /// Δ, w×z; zero when none was found.
    pub delta: Mat<c64>,
    /// σ_min(I − ΔM) relative to 1 + σ_max(ΔM), in scaled coordinates.
    pub singularity: f64,
}

impl SingularDelta {
    /// Nothing found.
    pub fn none(structure: &Structure) -> Self {
        Self { value: 0.0, delta: Mat::zeros(structure.inputs(), structure.outputs()), singularity: f64::NAN }
    }
}

/// A Δ counts as singular below this relative σ_min: some hundred roundings of a matrix of a few dozen channels.
const SINGULAR: f64 = 1e-10;
/// The search ends when the bound is this close (relative) to the upper bound.
const CLOSED: f64 = 1e-7;
/// Starts without and with real parameters (the latter have many local maxima).
const STARTS: [usize; 2] = [8, 40];
/// Weight of |Im λ| in the merit of a step with real parameters.
const IMAGINARY_WEIGHT: f64 = 2.0;

/// Lower bound of μ(M) for a scaling (that of the upper bound) in whose coordinates the search runs.
pub(crate) fn search(m: &Mat<c64>, structure: &Structure, scaling: &Scaling, upper: f64) -> SingularDelta {
    let mut best = SingularDelta::none(structure);
    let scaled = scaling.apply(m);
    if !scaled.is_all_finite() || scaled.norm_max() == 0.0 {
        return best;
    }
    let problem = LowerProblem { m: &scaled, structure, real: structure.has_real() };
    if problem.is_one_real_parameter() {
        return problem.largest_real_eigenvalue().unwrap_or(best);
    }
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for start in 0..STARTS[usize::from(problem.real)] {
        let Some(delta) = problem.start(start, &mut random) else {
            continue;
        };
        for choice in 0..if problem.real { BRANCHES } else { 1 } {
            let found = problem.ascend(delta.clone(), choice);
            if let Some(found) = found.filter(|f| f.value > best.value) {
                best = found;
            }
            if best.value >= upper * (1.0 - CLOSED) {
                return best;
            }
        }
    }
    best
}

/// Perturbations of size one with an eigenvalue of ΔM that is large, though not real: what a search over frequency goes
/// on with.
pub(super) fn list_unrestored(m: &Mat<c64>, structure: &Structure, scaling: &Scaling) -> Vec<(Mat<c64>, c64)> {
    let scaled = scaling.apply(m);
    if !scaled.is_all_finite() || scaled.norm_max() == 0.0 {
        return vec![];
    }
    let problem = LowerProblem { m: &scaled, structure, real: true };
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut found = vec![];
    for number in 0..STARTS[0] {
        let Some(start) = problem.start(number, &mut random) else {
            continue;
        };
        for choice in 0..BRANCHES {
            let eigenvalue = problem.eigenvalue(&start, choice).map(|lambda| (start.clone(), lambda));
            found.extend(eigenvalue);
            found.extend(problem.climb(start.clone(), choice));
        }
    }
    found
}

/// Δ scaled to make the loop singular, checked; none where it is not singular, λ being the eigenvalue of ΔM.
pub(super) fn singular(m: &Mat<c64>, structure: &Structure, delta: &Mat<c64>, lambda: c64) -> Option<SingularDelta> {
    LowerProblem { m, structure, real: true }.finish(delta, lambda)
}

/// Eigenvalues that are followed from each start.
const BRANCHES: usize = 3;

struct LowerProblem<'a> {
    m: &'a Mat<c64>,
    structure: &'a Structure,
    real: bool,
}

/// The linear model of one eigenvalue: λ(Δ) ≈ aᴴ Δ b.
struct EigenvalueModel {
    a: Mat<c64>,
    b: Mat<c64>,
}

impl LowerProblem<'_> {
    /// Start 0 aligns with the largest singular vectors, others are random; with few real parameters all signs are met.
    fn start(&self, number: usize, random: &mut ChaCha8Rng) -> Option<Mat<c64>> {
        let (q, p) = (self.structure.inputs(), self.structure.outputs());
        let (a, b) = if number == 0 {
            let (u, _, v) = singular_vectors(self.m).ok()?;
            (v.get(.., 0..1).to_owned(), u.get(.., 0..1).to_owned())
        } else {
            let mut draw = || c64::from_polar(random.random::<f64>(), TAU * random.random::<f64>());
            let a = Mat::from_fn(q, 1, |_, _| draw());
            (a, Mat::from_fn(p, 1, |_, _| draw()))
        };
        let mut delta = self.vertex(&EigenvalueModel { a, b }, 0.0);
        // The first starts run through the signs of the real parameters, as far as they reach.
        let signs = self.structure.spans.iter().filter(|s| s.is_real());
        for (k, span) in signs.enumerate().take(5) {
            let sign = if (number >> k) & 1 == 0 { 1.0 } else { -1.0 };
            for (i, j) in span.w.clone().zip(span.z.clone()) {
                delta[(i, j)] = c64::new(sign, 0.0);
            }
        }
        Some(delta)
    }

    /// The Δ with σ_max ≤ 1 that maximises Re(e^{−jψ} aᴴΔb).
    fn vertex(&self, model: &EigenvalueModel, psi: f64) -> Mat<c64> {
        let mut delta = Mat::zeros(self.structure.inputs(), self.structure.outputs());
        for span in &self.structure.spans {
            let rotation = c64::from_polar(1.0, psi);
            if !span.is_scalar() {
                let norm =
                    |v: &Mat<c64>, r: std::ops::Range<usize>| r.map(|i| v[(i, 0)].norm_sqr()).sum::<f64>().sqrt();
                let size = norm(&model.a, span.w.clone()) * norm(&model.b, span.z.clone());
                for i in span.w.clone() {
                    for j in span.z.clone() {
                        let dyad = model.a[(i, 0)] * model.b[(j, 0)].conj();
                        if size > 0.0 {
                            delta[(i, j)] = rotation * dyad / size;
                        }
                    }
                }
                continue;
            }
            let gain = scalar_gain(model, span);
            let value = if span.is_real() {
                let along = (rotation.conj() * gain).re;
                c64::new(if along < 0.0 { -1.0 } else { 1.0 }, 0.0)
            } else if gain.norm() > 0.0 {
                rotation * gain.conj() / gain.norm()
            } else {
                c64::new(1.0, 0.0)
            };
            for (i, j) in span.w.clone().zip(span.z.clone()) {
                delta[(i, j)] = value;
            }
        }
        delta
    }

    /// aᴴΔb.
    fn value(model: &EigenvalueModel, delta: &Mat<c64>) -> c64 {
        (model.a.adjoint() * delta * &model.b)[(0, 0)]
    }

    /// Best Δ of the model: along the present phase of λ, or subject to Im λ = 0 when there are real parameters.
    fn target(&self, model: &EigenvalueModel, lambda: c64) -> Mat<c64> {
        if !self.real {
            return self.vertex(model, lambda.arg());
        }
        let (mut lo, mut hi) = (-FRAC_PI_2, FRAC_PI_2);
        // The imaginary part of the best Δ grows with ψ; 40 halvings reach the rounding of ψ.
        for _ in 0..40 {
            let mid = 0.5 * (lo + hi);
            if Self::value(model, &self.vertex(model, mid)).im > 0.0 {
                hi = mid;
            } else {
                lo = mid;
            }
        }
        let (low, high) = (self.vertex(model, lo), self.vertex(model, hi));
        let (below, above) = (Self::value(model, &low).im, Self::value(model, &high).im);
        // Where a real parameter switches its sign between lo and hi it takes the value in between that makes Im λ = 0.
        let share = if above > below { (above / (above - below)).clamp(0.0, 1.0) } else { 0.5 };
        blend(&high, &low, share)
    }

    fn merit(&self, lambda: c64) -> f64 {
        if self.real { lambda.re - IMAGINARY_WEIGHT * lambda.im.abs() } else { lambda.norm() }
    }

    /// The eigenvalue of ΔM with the `choice`-th best merit.
    fn eigenvalue(&self, delta: &Mat<c64>, choice: usize) -> Option<c64> {
        let mut all = eigenvalues_complex(&(delta * self.m)).ok()?;
        all.sort_by(|x, y| self.merit(*y).total_cmp(&self.merit(*x)));
        all.get(choice).copied()
    }

    /// a and b of the linear model at an eigenvalue.
    fn model(&self, delta: &Mat<c64>, lambda: c64) -> Option<EigenvalueModel> {
        let mut shifted = delta * self.m;
        for k in 0..shifted.nrows() {
            shifted[(k, k)] -= lambda;
        }
        let (u, _, v) = singular_vectors(&shifted).ok()?;
        let last = u.ncols().checked_sub(1)?;
        let (y, x) = (u.get(.., last..), v.get(.., last..));
        let product = (y.adjoint() * x)[(0, 0)];
        // A defective eigenvalue has an infinite derivative: its direction is what counts.
        let divisor = if product.norm() > 1e-14 { product } else { c64::new(1e-14, 0.0) };
        let a = Mat::from_fn(y.nrows(), 1, |i, _| y[(i, 0)] / divisor.conj());
        Some(EigenvalueModel { a, b: self.m * x })
    }

    fn is_one_real_parameter(&self) -> bool {
        matches!(self.structure.spans.as_slice(), [span] if span.is_real())
    }

    /// Δ = I/λ at the largest real eigenvalue λ of M: μ of one real parameter, exactly.
    fn largest_real_eigenvalue(&self) -> Option<SingularDelta> {
        let values = eigenvalues_complex(self.m).ok()?;
        let n = self.m.nrows();
        let singular = values.into_iter().filter_map(|lambda| {
            let sign = c64::new(lambda.re.signum(), 0.0);
            let delta = Mat::from_fn(n, n, |i, j| if i == j { sign } else { c64::new(0.0, 0.0) });
            self.finish(&delta, lambda * sign)
        });
        singular.max_by(|x, y| x.value.total_cmp(&y.value))
    }

    fn ascend(&self, delta: Mat<c64>, choice: usize) -> Option<SingularDelta> {
        let (mut delta, mut lambda) = self.climb(delta, choice)?;
        if self.real {
            (delta, lambda) = self.restore(delta, lambda)?;
        }
        self.finish(&delta, lambda)
    }

    /// Raises the merit of an eigenvalue until it settles.
    fn climb(&self, mut delta: Mat<c64>, choice: usize) -> Option<(Mat<c64>, c64)> {
        let mut lambda = self.eigenvalue(&delta, choice)?;
        // Linear convergence: 60 steps settle what is going to settle.
        for _ in 0..60 {
            let model = self.model(&delta, lambda)?;
            let target = self.target(&model, lambda);
            let mut moved = false;
            let mut length = 1.0;
            while length > 0.01 {
                let trial = blend(&delta, &target, length);
                let next = self.eigenvalue(&trial, 0)?;
                let gain = self.merit(next) - self.merit(lambda);
                if gain > 1e-10 * next.norm() {
                    (delta, lambda, moved) = (trial, next, true);
                    break;
                }
                length *= 0.5;
            }
            if !moved {
                break;
            }
        }
        Some((delta, lambda))
    }

    /// Moves Δ until Im λ = 0, towards the vertex that changes Im λ most.
    fn restore(&self, delta: Mat<c64>, lambda: c64) -> Option<(Mat<c64>, c64)> {
        let small = |l: c64| l.im.abs() <= 1e-14 * l.norm();
        if small(lambda) {
            return Some((delta, lambda));
        }
        let model = self.model(&delta, lambda)?;
        let psi = if lambda.im > 0.0 { -FRAC_PI_2 } else { FRAC_PI_2 };
        let target = self.vertex(&model, psi);
        let follow = |length: f64, near: c64| {
            let all = eigenvalues_complex(&(blend(&delta, &target, length) * self.m)).ok()?;
            all.into_iter().min_by(|x, y| (x - near).norm().total_cmp(&(y - near).norm()))
        };
        let (mut lo, mut hi, mut near) = (0.0, None, lambda);
        let mut length = 1e-3;
        // March until the sign of Im λ changes, then bisect to rounding.
        while hi.is_none() && length <= 1.0 {
            let next = follow(length, near)?;
            if next.im * lambda.im <= 0.0 {
                hi = Some(length);
            } else {
                (lo, near) = (length, next);
                length *= 1.5;
            }
        }
        let mut hi = hi?;
        let mut end = near;
        for _ in 0..60 {
            let mid = 0.5 * (lo + hi);
            let next = follow(mid, end)?;
            end = next;
            if next.im * lambda.im > 0.0 {
                lo = mid;
            } else {
                hi = mid;
            }
            if small(next) {
                return Some((blend(&delta, &target, mid), next));
            }
        }
        (end.im.abs() <= 1e-11 * end.norm()).then(|| (blend(&delta, &target, hi), end))
    }

    /// Δ/λ with its checks.
    fn finish(&self, delta: &Mat<c64>, lambda: c64) -> Option<SingularDelta> {
        let divisor = if self.real { c64::new(lambda.re, 0.0) } else { lambda };
        if divisor.re <= 0.0 && self.real || divisor.norm() < 1e-300 {
            return None;
        }
        let delta = Mat::from_fn(delta.nrows(), delta.ncols(), |i, j| delta[(i, j)] / divisor);
        let loop_gain = &delta * self.m;
        let n = loop_gain.nrows();
        let difference = Mat::from_fn(n, n, |i, j| c64::new(f64::from(u8::from(i == j)), 0.0) - loop_gain[(i, j)]);
        let singularity = min_singular_value(&difference) / (1.0 + max_singular_value_complex(&loop_gain));
        let size = max_singular_value_complex(&delta);
        (singularity <= SINGULAR && size > 0.0).then(|| SingularDelta { value: 1.0 / size, delta, singularity })
    }
}

/// Σ over the repetitions of conj(a)·b: the derivative of λ with respect to a scalar.
fn scalar_gain(model: &EigenvalueModel, span: &Span) -> c64 {
    let pairs = span.w.clone().zip(span.z.clone());
    pairs.map(|(i, j)| model.a[(i, 0)].conj() * model.b[(j, 0)]).sum()
}

/// (1 − t)·a + t·b.
fn blend(a: &Mat<c64>, b: &Mat<c64>, t: f64) -> Mat<c64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * (1.0 - t) + b[(i, j)] * t)
}
