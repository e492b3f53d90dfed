//! Central controller at a level γ from X and Y (Glover and Doyle 1988, general D11; notation of Zhou, Doyle and
//! Glover 1996, theorem 17.1), on the normal form D12 = [0; I], D21 = [0, I], D22 = 0:
//!   F = −R⁻¹([D11 D12]ᵀC1 + BᵀX) = [F11; F12; F2],   L = −(B1[D11; D21]ᵀ + YCᵀ)R̃⁻¹ = [L11 L12 L2],
//!   D_K = −D1121 D1111ᵀ(γ²I − D1111 D1111ᵀ)⁻¹D1112 − D1122,   Z = (I − YX/γ²)⁻¹,
//!   C_K = F2 − D_K(C2 + F12),   B_K = Z(−L2 + (B2 + L12)D_K),   A_K = A + BF − B_K(C2 + F12).

use super::normal::NormalForm;
use super::side::{RiccatiSide, feedback};
use crate::linalg::{Mat, NumericError, solve};
use crate::lti::connect::stack_cols;
use crate::lti::{Continuous, StateSpace};

/// Controller of the normal form.
pub(crate) fn central(
    p: &NormalForm,
    control: &RiccatiSide,
    filter: &RiccatiSide,
    gamma: f64,
    x: &Mat<f64>,
    y: &Mat<f64>,
) -> Result<StateSpace<Continuous>, NumericError> {
    let (n, m1, m2) = (p.a.nrows(), p.b1.ncols(), p.controls());
    let (p1, p2) = (p.c1.nrows(), p.measurements());
    let f = feedback(control, gamma, x)?;
    let l = feedback(filter, gamma, y)?.transpose().to_owned();
    let f12 = f.submatrix(m1 - p2, 0, p2, n);
    let f2 = f.submatrix(m1, 0, m2, n);
    let l12 = l.submatrix(0, p1 - m2, n, m2);
    let l2 = l.submatrix(0, p1, n, p2);
    let dk = direct(p, gamma)?;
    let cf = &p.c2 + f12;
    let z = Mat::<f64>::identity(n, n)
        - Mat::from_fn(n, n, |i, j| (0..n).map(|k| y[(i, k)] * x[(k, j)]).sum::<f64>() / gamma / gamma);
    let bk = solve(&z, &((&p.b2 + l12) * &dk - l2))?;
    let ck = f2 - &dk * &cf;
    let ak = &p.a + stack_cols(&p.b1, &p.b2) * &f - &bk * &cf;
    StateSpace::new(ak, bk, ck, dk, Continuous)
}

/// D_K, the feedthrough that meets the Parrott bound.
fn direct(p: &NormalForm, gamma: f64) -> Result<Mat<f64>, NumericError> {
    let (m1, m2) = (p.b1.ncols(), p.controls());
    let (p1, p2) = (p.c1.nrows(), p.measurements());
    let (r, c) = (p1 - m2, m1 - p2);
    let d = |i: usize, j: usize, h: usize, w: usize| p.d11.submatrix(i, j, h, w).to_owned();
    let (d1111, d1112) = (d(0, 0, r, c), d(0, c, r, p2));
    let (d1121, d1122) = (d(r, 0, m2, c), d(r, c, m2, p2));
    let zero = Mat::<f64>::zeros(m2, p2);
    if r == 0 {
        return Ok(zero - d1122);
    }
    let gap = Mat::from_fn(r, r, |i, j| if i == j { gamma * gamma } else { 0.0 }) - &d1111 * d1111.transpose();
    Ok(zero - &d1121 * d1111.transpose() * solve(&gap, &d1112)? - d1122)
}
