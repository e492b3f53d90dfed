//! Structure-preserving doubling for AᵀX + XA − XGX + Q = 0 (Chu, Fan and Lin 2005): a Cayley transform with shift γ
//! turns the Hamiltonian into a symplectic pencil, whose power 2ᵏ is formed step by step:
//!   A ← A(I + GH)⁻¹A,  G ← G + A(I + GH)⁻¹GAᵀ,  H ← H + AᵀH(I + GH)⁻¹A,   H → X.
//! Quadratic convergence; no ordering of eigenvalues is needed, so identical channels do no harm.

use super::lyapunov::symmetric;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Accum, Mat, MatRef, Par, Scale};

/// Steps allowed: the closed-loop spectrum contracts by squaring, so 60 cover ratios down to 2⁻⁶⁰.
const STEPS: usize = 60;

/// A stabilising solution if the iteration settles, on balanced data. The caller checks the residual.
pub(crate) fn doubling(a: &Mat<f64>, g: &Mat<f64>, q: &Mat<f64>, shift: f64) -> Option<Mat<f64>> {
    let n = a.nrows();
    let one = Mat::<f64>::identity(n, n);
    let shifted = a - &one * Scale(shift);
    let inverse = shifted.partial_piv_lu().inverse();
    let w = shifted.transpose() + q * &inverse * g;
    let w = w.partial_piv_lu().inverse();
    let mut ak = &one + w.transpose() * Scale(2.0 * shift);
    let mut gk = symmetric(&(&inverse * g * &w * Scale(2.0 * shift)));
    let mut hk = symmetric(&(&w * q * &inverse * Scale(2.0 * shift)));
    // A step of a small matrix takes as long as reserving its memory would.
    let [mut step, mut product] = [(); 2].map(|()| Mat::<f64>::zeros(n, n));
    let mut solved = Mat::<f64>::zeros(n, 2 * n);
    let mut last = f64::INFINITY;
    for _ in 0..STEPS {
        product.copy_from(&one);
        add_product(&mut product, &gk, hk.as_ref());
        solved.subcols_mut(0, n).copy_from(&ak);
        solved.subcols_mut(n, n).copy_from(&gk);
        product.partial_piv_lu().solve_in_place(&mut solved);
        let (left, right) = (solved.subcols(0, n), solved.subcols(n, n));
        set_product(&mut product, hk.as_ref(), left);
        set_product(&mut step, ak.transpose(), product.as_ref());
        set_product(&mut product, ak.as_ref(), right);
        add_product(&mut gk, &product, ak.transpose());
        make_symmetric(&mut gk);
        hk += &step;
        make_symmetric(&mut hk);
        set_product(&mut product, ak.as_ref(), left);
        std::mem::swap(&mut ak, &mut product);
        let size = hk.norm_l2();
        let change = step.norm_l2() / if size > 0.0 { size } else { 1.0 };
        if !change.is_finite() || !ak.is_all_finite() {
            return None;
        }
        // At rounding level, or stagnating close to it: no further step helps.
        if change < 1e-16 || (change < 1e-10 && change >= last) {
            return Some(hk);
        }
        last = change;
    }
    None
}

fn set_product(into: &mut Mat<f64>, a: MatRef<f64>, b: MatRef<f64>) {
    matmul(into, Accum::Replace, a, b, 1.0, Par::Seq);
}

fn add_product(to: &mut Mat<f64>, a: &Mat<f64>, b: MatRef<f64>) {
    matmul(to, Accum::Add, a, b, 1.0, Par::Seq);
}

/// (M + Mᵀ)/2 in place.
fn make_symmetric(m: &mut Mat<f64>) {
    for j in 1..m.ncols() {
        for i in 0..j {
            let mean = 0.5 * (m[(i, j)] + m[(j, i)]);
            (m[(i, j)], m[(j, i)]) = (mean, mean);
        }
    }
}
