//! One side of the H∞ problem at a level γ. The control side is (A, B1, B2, C1, D11) with D12 = [0; I]; the filter side
//! is the same thing for the transposed plant, so one code serves both.
//!
//! Riccati equation at γ: with R = [D11 D12]ᵀ[D11 D12] − diag(γ²I, 0), B = [B1 B2], S = C1ᵀ[D11 D12],
//!   A_γ = A − B R⁻¹Sᵀ,  G = B R⁻¹Bᵀ,  Q = C1ᵀC1 − S R⁻¹Sᵀ.
//! With the control eliminated, D_f, C_f the rows of D11, C1 that it does not reach, D_d, C_d those that it does, and
//! E = B1 − B2 D_d, N = I − D_fᵀD_f/γ²:
//!   A_γ = A − B2 C_d + E N⁻¹D_fᵀC_f/γ²,  G = B2B2ᵀ − E N⁻¹Eᵀ/γ²,  Q = C_fᵀ(I + D_f N⁻¹D_fᵀ/γ²)C_f.
//! So Q is exactly zero where the control reaches every error, and X as well where A − B2 C_d is stable.
//!
//! The Hamiltonian of the equation has an axis eigenvalue jω exactly when γ is a singular value of Π(jω)P11(jω), Π the
//! projection on what P12(jω) cannot reach. The peak of σmax(ΠP11) over ω is therefore the smallest γ with a
//! stabilising solution, and every single ω gives a lower bound: at that frequency no control, not even a non-causal
//! one, does better.

use crate::linalg::lyapunov::symmetric;
use crate::linalg::riccati::{CareSolution, RiccatiEffort, RiccatiError, care_with};
use crate::linalg::{
    Mat, NumericError, c64, eigenvalues, max_singular_value, max_singular_value_complex, solve, solve_complex,
};
use crate::lti::connect::{stack_cols, stack_rows};
use crate::lti::level_set::{Peak, peak};
use crate::lti::norm::places;
use crate::lti::{Continuous, FrequencyResponder, StateSpace};

#[derive(Clone, Debug)]
pub(crate) struct RiccatiSide {
    /// n×n.
    pub a: Mat<f64>,
    /// n×m1.
    pub b1: Mat<f64>,
    /// n×m2.
    pub b2: Mat<f64>,
    /// p1×n.
    pub c1: Mat<f64>,
    /// p1×m1.
    pub d11: Mat<f64>,
}

/// The γ = ∞ solution of a side: the linear-quadratic regulator, which makes P12 inner.
#[derive(Clone, Debug)]
pub(crate) struct Regulator {
    /// Stabilising solution X₂ ≥ 0.
    pub x: Mat<f64>,
    /// Feedback F₂ = −(D12ᵀC1 + B2ᵀX₂).
    pub f: Mat<f64>,
    /// Largest real part of the closed loop, negative.
    pub growth_rate: f64,
}

impl Regulator {
    /// True when the closed loop is stable only within rounding: an assumption may be violated exactly.
    pub(crate) fn is_marginal(&self, side: &RiccatiSide) -> bool {
        let closed = &side.a + &side.b2 * &self.f;
        self.growth_rate > -1e-13 * closed.norm_l2()
    }
}

/// A, G, Q of a Riccati equation.
pub(crate) struct Equation {
    /// n×n.
    pub a: Mat<f64>,
    /// n×n, symmetric.
    pub g: Mat<f64>,
    /// n×n, symmetric.
    pub q: Mat<f64>,
}

/// A side at γ with the control eliminated and the disturbances scaled by 1/γ, so that a level far below the entries of
/// D11 leaves no small pivots.
struct Eliminated {
    /// (B1 − B2 D_d)/γ, n×m1.
    e: Mat<f64>,
    /// D_f/γ, p_f×m1.
    d_free: Mat<f64>,
    /// N = I − D_fᵀD_f/γ², m1×m1.
    gap: Mat<f64>,
    /// D_d, m2×m1.
    d_direct: Mat<f64>,
}

impl RiccatiSide {
    fn free_errors(&self) -> usize {
        self.c1.nrows() - self.b2.ncols()
    }

    /// C_d = D12ᵀC1: the errors that u reaches directly are the last ones.
    fn c_direct(&self) -> Mat<f64> {
        let free = self.free_errors();
        self.c1.subrows(free, self.b2.ncols()).to_owned()
    }

    /// C_f.
    fn c_free(&self) -> Mat<f64> {
        self.c1.subrows(0, self.free_errors()).to_owned()
    }

    /// D_f.
    fn d_free(&self) -> Mat<f64> {
        self.d11.subrows(0, self.free_errors()).to_owned()
    }

    /// Solves the side at γ = ∞.
    pub(crate) fn regulator(&self) -> Result<Regulator, RiccatiError> {
        let n = self.a.nrows();
        let (direct, free) = (self.c_direct(), self.c_free());
        let found = care_with(
            &(&self.a - &self.b2 * &direct),
            &(&self.b2 * self.b2.transpose()),
            &(free.transpose() * &free),
            RiccatiEffort::Fast,
        )?;
        let f = Mat::<f64>::zeros(self.b2.ncols(), n) - &direct - self.b2.transpose() * &found.x;
        Ok(Regulator { x: found.x, f, growth_rate: found.closed_loop_max_real })
    }

    /// [D11 D12].
    pub(crate) fn feedthrough(&self) -> Mat<f64> {
        let (p1, m2) = (self.c1.nrows(), self.b2.ncols());
        let free = self.free_errors();
        let d12 = Mat::from_fn(p1, m2, |i, j| if i == free + j { 1.0 } else { 0.0 });
        stack_cols(&self.d11, &d12)
    }

    /// The side at γ with the control eliminated.
    fn eliminate_feedthrough(&self, gamma: f64) -> Eliminated {
        let m1 = self.b1.ncols();
        let d_direct = self.d11.subrows(self.free_errors(), self.b2.ncols());
        let d_free = self.d_free() * gamma.recip();
        Eliminated {
            e: (&self.b1 - &self.b2 * d_direct) * gamma.recip(),
            gap: Mat::<f64>::identity(m1, m1) - d_free.transpose() * &d_free,
            d_direct: d_direct.to_owned(),
            d_free,
        }
    }

    /// Riccati equation at γ.
    pub(crate) fn equation(&self, gamma: f64) -> Result<Equation, NumericError> {
        let Eliminated { e, d_free, gap, .. } = self.eliminate_feedthrough(gamma);
        let (n, free) = (self.a.nrows(), self.c_free());
        let seen = d_free.transpose() * &free;
        let x = solve(&gap, &stack_cols(&e.transpose().to_owned(), &seen))?;
        let (driven, read) = (x.subcols(0, n), x.subcols(n, n));
        Ok(Equation {
            a: &self.a - &self.b2 * self.c_direct() + &e * read,
            g: symmetric(&(&self.b2 * self.b2.transpose() - &e * driven)),
            q: symmetric(&(free.transpose() * &free + seen.transpose() * read)),
        })
    }

    /// Stabilising solution at γ; the second solver runs before the answer is no.
    pub(crate) fn riccati(&self, gamma: f64, effort: RiccatiEffort) -> Result<CareSolution, RiccatiError> {
        let e = self.equation(gamma)?;
        care_with(&e.a, &e.g, &e.q, effort)
    }

    /// P11 and P12 with the feedback u = F₂x + v, which changes neither the range of P12 nor ΠP11, and makes P12 inner
    /// and stable.
    pub(crate) fn close_regulator(&self, regulator: &Regulator) -> StateSpace<Continuous> {
        let d = self.feedthrough();
        let (p1, m1, m2) = (d.nrows(), self.b1.ncols(), self.b2.ncols());
        StateSpace {
            a: &self.a + &self.b2 * &regulator.f,
            b: stack_cols(&self.b1, &self.b2),
            c: &self.c1 + d.submatrix(0, m1, p1, m2) * &regulator.f,
            d,
            time: Continuous,
        }
    }

    /// What no control reaches at infinite frequency: γ is above it.
    pub(crate) fn level_at_infinity(&self) -> f64 {
        max_singular_value(&self.d_free())
    }

    /// Smallest γ for which the Riccati equation has a stabilising solution, with its frequency.
    pub(crate) fn smallest_level(&self, regulator: &Regulator, rel_tol: f64) -> Result<Peak, NumericError> {
        let m1 = self.b1.ncols();
        let free = self.free_errors();
        let nothing = Peak { lower: 0.0, omega_rad_s: 0.0, upper: 0.0 };
        if free == 0 || m1 == 0 {
            return Ok(nothing);
        }
        let closed = self.close_regulator(regulator);
        let responder = FrequencyResponder::new(&closed);
        let at_infinity = self.level_at_infinity();
        let value = |omega: f64| {
            if omega.is_infinite() {
                return at_infinity;
            }
            let (rest, _) = beyond_control(&responder.at_or_infinity(omega), m1);
            let v = max_singular_value_complex(&rest);
            if v.is_nan() { f64::INFINITY } else { v }
        };
        let mut poles = eigenvalues(&closed.a)?;
        poles.extend(eigenvalues(&self.a)?);
        // Levels near rounding of the problem are zero.
        let floor = 1e-11
            * (max_singular_value(&self.d11) + self.b1.norm_l2() * self.c1.norm_l2() / self.a.norm_l2().max(1e-300));
        let places = places(&poles, &value);
        let found = places.iter().map(|place| place.1).fold(0.0, f64::max);
        if found <= floor {
            return Ok(nothing);
        }
        let hamiltonian = |gamma: f64| {
            let e = self.equation(gamma)?;
            let n = e.a.nrows();
            let scale = crate::linalg::riccati::balance_hamiltonian(&e.a, &e.g, &e.q);
            Ok(Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
                (true, true) => e.a[(i, j)] * scale[j] / scale[i],
                (true, false) => -e.g[(i, j - n)] / scale[i] / scale[j - n],
                (false, true) => -e.q[(i - n, j)] * scale[i - n] * scale[j],
                (false, false) => -e.a[(j - n, i - n)] * scale[i - n] / scale[j - n],
            }))
        };
        peak(&value, &places, floor, &hamiltonian, rel_tol)
    }
}

/// ΠP11 of a response [P11 P12] with `m1` disturbances, and P12⁺P11: least squares against the columns of P12,
/// which are orthonormal up to rounding.
pub(crate) fn beyond_control(response: &Mat<c64>, m1: usize) -> (Mat<c64>, Mat<c64>) {
    let (g, n) = (response.subcols(0, m1), response.subcols(m1, response.ncols() - m1));
    let gram = n.adjoint() * n;
    let x = solve_complex(&gram, &(n.adjoint() * g));
    (g - n * &x, x)
}

pub(crate) fn control_side(p: &crate::robust::hinf::normal::NormalForm) -> RiccatiSide {
    RiccatiSide { a: p.a.clone(), b1: p.b1.clone(), b2: p.b2.clone(), c1: p.c1.clone(), d11: p.d11.clone() }
}

/// The filter side of a normal form: the transposed plant.
pub(crate) fn filter_side(p: &crate::robust::hinf::normal::NormalForm) -> RiccatiSide {
    let t = |m: &Mat<f64>| m.transpose().to_owned();
    RiccatiSide { a: t(&p.a), b1: t(&p.c1), b2: t(&p.c2), c1: t(&p.b1), d11: t(&p.d11) }
}

/// Worst disturbance and control of a side, −R⁻¹([D11 D12]ᵀC1 + BᵀX), (m1+m2)×n.
pub(crate) fn feedback(side: &RiccatiSide, gamma: f64, x: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    let Eliminated { e, d_free, gap, d_direct } = side.eliminate_feedthrough(gamma);
    let right = d_free.transpose() * side.c_free() + e.transpose() * x;
    let disturbance = solve(&gap, &right)? * gamma.recip();
    let control = d_direct * &disturbance + side.c_direct() + side.b2.transpose() * x;
    Ok(stack_rows(&disturbance, &(control * -1.0)))
}
