//! Structure-preserving doubling for AᵀX + XA − XGX + Q = 0 (Chu, Fan and Lin 2005): a Cayley transform with shift γ
//! turns the Hamiltonian into a symplectic pencil, whose power 2ᵏ is formed step by step:
//!   A ← A(I + GH)⁻¹A,  G ← G + A(I + GH)⁻¹GAᵀ,  H ← H + AᵀH(I + GH)⁻¹A,   H → X.
//! Quadratic convergence; no ordering of eigenvalues is needed, so identical channels do no harm.

use super::lyapunov::symmetric;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{PartialPivLuParams, lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Accum, Auto, Mat, MatRef, Par, Scale, Spec};

/// Steps allowed: the closed-loop spectrum contracts by squaring, so 60 cover ratios down to 2⁻⁶⁰.
const STEPS: usize = 60;

/// Relative change of X below which it is rounding.
const ROUNDING: f64 = 1e-16;

/// A stabilising solution if the iteration settles, on balanced data. The caller checks the residual.
pub(crate) fn doubling(a: &Mat<f64>, g: &Mat<f64>, q: &Mat<f64>, shift: f64) -> Option<Mat<f64>> {
    let n = a.nrows();
    let one = Mat::<f64>::identity(n, n);
    let mut pair = PairSolver::new(n);
    // With A − γI = S and W = Sᵀ + QS⁻¹G: A ← I + 2γW⁻ᵀ, G ← 2γS⁻¹GW⁻¹, H ← 2γW⁻¹QS⁻¹.
    let shifted = a - &one * Scale(shift);
    let [inverse, driven] = pair.solve(&shifted, [&one, g]);
    let read = q * inverse;
    let w = shifted.transpose() + &read * g;
    let driven = driven.to_owned();
    let [inverse, start] = pair.solve(&w, [&one, &read]);
    let twice = Scale(2.0 * shift);
    let ak = &one + inverse.transpose() * twice;
    let gk = symmetric(&(driven * inverse * twice));
    let hk = symmetric(&(start * twice));
    double_until_settled(ak, gk, hk)
}

/// The stabilising solution of H = Q + AᵀH(I + GH)⁻¹A, the equation of sampled time, if the iteration from (A, G, Q)
/// settles. The caller checks the residual.
pub(crate) fn double_until_settled(mut ak: Mat<f64>, mut gk: Mat<f64>, mut hk: Mat<f64>) -> Option<Mat<f64>> {
    let n = ak.nrows();
    let one = Mat::<f64>::identity(n, n);
    let mut pair = PairSolver::new(n);
    // Memory of the steps is allocated once: for small matrices that takes as long as the products.
    let [mut step, mut product] = [(); 2].map(|()| Mat::<f64>::zeros(n, n));
    let mut last = f64::NAN;
    for _ in 0..STEPS {
        product.copy_from(&one);
        add_product(&mut product, &gk, hk.as_ref());
        let [left, right] = pair.solve(&product, [&ak, &gk]);
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
        // Estimate of the next change: successive changes square, or halve where an eigenvalue is on the axis.
        let next = change * (change / last).powi(2);
        // At rounding level, or stagnating close to it: no further step helps.
        if change.min(next) < ROUNDING || (change < 1e-10 && change >= last) {
            return Some(hk);
        }
        last = change;
    }
    None
}

/// Solves systems of one order with two square right-hand sides, in memory that it keeps.
struct PairSolver {
    /// [M B₁ B₂]: the factors of a wide matrix hold what forward substitution leaves of B.
    wide: Mat<f64>,
    rows: [Vec<usize>; 2],
    memory: MemBuffer,
    params: Spec<PartialPivLuParams, f64>,
}

impl PairSolver {
    fn new(n: usize) -> Self {
        let params = Spec::new(<_ as Auto<f64>>::auto());
        let scratch = lu_in_place_scratch::<usize, f64>(n, 3 * n, Par::Seq, params);
        Self { wide: Mat::zeros(n, 3 * n), rows: [vec![0; n], vec![0; n]], memory: MemBuffer::new(scratch), params }
    }

    /// M⁻¹B₁ and M⁻¹B₂ by LU with partial pivoting; not finite where M is singular.
    fn solve(&mut self, m: &Mat<f64>, [first, second]: [&Mat<f64>; 2]) -> [MatRef<'_, f64>; 2] {
        let n = m.nrows();
        for (k, part) in [m, first, second].into_iter().enumerate() {
            self.wide.subcols_mut(k * n, n).copy_from(part);
        }
        let [to, from] = &mut self.rows;
        let stack = MemStack::new(&mut self.memory);
        lu_in_place(self.wide.as_mut(), to, from, Par::Seq, stack, self.params);
        let (factors, mut right) = self.wide.split_at_col_mut(n);
        solve_upper_triangular_in_place(factors.as_ref(), right.as_mut(), Par::Seq);
        [self.wide.subcols(n, n), self.wide.subcols(2 * n, n)]
    }
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
