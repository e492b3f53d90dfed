//! Structure-preserving doubling for AᵀX + XA − XGX + Q = 0 (Chu, Fan and Lin 2005): a Cayley transform with shift γ
//! turns the Hamiltonian into a symplectic pencil, whose power 2ᵏ is formed step by step:
//!   A ← A(I + GH)⁻¹A,  G ← G + A(I + GH)⁻¹GAᵀ,  H ← H + AᵀH(I + GH)⁻¹A,   H → X.
//! Quadratic convergence; no ordering of eigenvalues is needed, so identical channels do no harm.

use super::lyapunov::symmetric;
use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, Scale};

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
    let mut last = f64::INFINITY;
    for _ in 0..STEPS {
        let lu = (&one + &gk * &hk).partial_piv_lu();
        let (left, right) = (lu.solve(&ak), lu.solve(&gk));
        let step = ak.transpose() * (&hk * &left);
        gk = symmetric(&(&gk + &ak * right * ak.transpose()));
        hk = symmetric(&(&hk + &step));
        ak = &ak * left;
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
