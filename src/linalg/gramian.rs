//! Factors of gramians, P = L Lᵀ with AP + PAᵀ + BBᵀ = 0, right in their small entries too: the Lyapunov solution is
//! refined with residuals of doubled precision and factored in it, so Hankel values keep their digits far below the
//! largest one. (Hammarling's 1982 method, the usual choice, is right to ε times the largest.)
//! Also the singular values of graded matrices by one-sided Jacobi rotations (Demmel and Veselić 1992).

use super::doubled::Doubled;
use super::error::NumericError;
use super::lyapunov::lyapunov_with;
use super::schur::schur;
use faer::Mat;

/// X with AᵀX + XA + Q = 0 in doubled precision; A stable.
pub(crate) fn lyapunov_doubled(a: &Mat<f64>, q: &Doubled) -> Result<Doubled, NumericError> {
    // Each step gains the digits that ε·cond leaves; a step that gains less than one digit is hopeless.
    const LIMIT: usize = 20;
    let n = a.nrows();
    let form = schur(a)?;
    let exact_a = Doubled::from_f64(a);
    let mut x = Doubled::from_f64(&Mat::zeros(n, n));
    let mut last = f64::INFINITY;
    for k in 0..LIMIT {
        let p = x.times(&exact_a);
        let residual = p.plus(&p.transpose()).plus(q).to_double();
        let step = lyapunov_with(&form, &residual);
        if !step.is_all_finite() {
            break;
        }
        let size = step.norm_l2() / x.to_double().norm_l2().max(step.norm_l2()).max(f64::MIN_POSITIVE);
        if k > 0 && size >= 0.5 * last {
            break;
        }
        x = x.plus(&Doubled::from_f64(&step));
        last = size;
        // Thirty digits: the floor of doubled precision.
        if size < 1e-30 {
            break;
        }
    }
    // Sixteen digits at least, or the equation is singular.
    if last > 1e-13 {
        return Err(NumericError::NoConvergence { what: "Lyapunov equation", iterations: LIMIT, residual: last });
    }
    Ok(x)
}

/// L with P = L Lᵀ, AP + PAᵀ + BBᵀ = 0; n×n lower triangular, columns of zeros where P has no more rank.
pub(crate) fn reachability_factor(a: &Mat<f64>, b: &Mat<f64>) -> Result<Doubled, NumericError> {
    let q = Doubled::gram(&b.transpose().to_owned());
    Ok(lyapunov_doubled(&a.transpose().to_owned(), &q)?.cholesky())
}

/// L with Q = L Lᵀ, AᵀQ + QA + CᵀC = 0.
pub(crate) fn observability_factor(a: &Mat<f64>, c: &Mat<f64>) -> Result<Doubled, NumericError> {
    Ok(lyapunov_doubled(a, &Doubled::gram(c))?.cholesky())
}

/// Singular values (descending) and vectors of a square matrix by one-sided Jacobi: M = U diag(s) Vᵀ.
/// Small singular values of a matrix with graded columns come out with relative accuracy.
pub(crate) fn jacobi_svd(m: &Mat<f64>) -> (Mat<f64>, Vec<f64>, Mat<f64>) {
    // Quadratic convergence; ten sweeps are usual.
    const SWEEPS: usize = 40;
    let n = m.ncols();
    let (mut u, mut v) = (m.clone(), Mat::<f64>::identity(n, n));
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                let (mut pp, mut qq, mut pq) = (0.0, 0.0, 0.0);
                for i in 0..u.nrows() {
                    let (x, y) = (u[(i, p)], u[(i, q)]);
                    pp += x * x;
                    qq += y * y;
                    pq += x * y;
                }
                if pq == 0.0 || pq.abs() <= 1e-15 * (pp * qq).sqrt() {
                    continue;
                }
                rotated = true;
                let zeta = (qq - pp) / (2.0 * pq);
                let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let t = if zeta == 0.0 { 1.0 } else { t };
                let c = 1.0 / (1.0 + t * t).sqrt();
                let s = c * t;
                for w in [&mut u, &mut v] {
                    for i in 0..w.nrows() {
                        let (x, y) = (w[(i, p)], w[(i, q)]);
                        w[(i, p)] = c * x - s * y;
                        w[(i, q)] = s * x + c * y;
                    }
                }
            }
        }
        if !rotated {
            break;
        }
    }
    let norms: Vec<f64> = (0..n).map(|j| u.col(j).norm_l2()).collect();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|i, j| norms[*j].total_cmp(&norms[*i]));
    let unit = Mat::from_fn(u.nrows(), n, |i, j| {
        let norm = norms[order[j]];
        if norm > 0.0 { u[(i, order[j])] / norm } else { 0.0 }
    });
    let right = Mat::from_fn(n, n, |i, j| v[(i, order[j])]);
    (unit, order.iter().map(|j| norms[*j]).collect(), right)
}
