//! The largest eigenvalues of XY at a level and their derivatives, by γ and by the matrices of the plant.
//!
//! XYv = γ²v, w = Yv, vᵀw = 1, so dρ = wᵀdX w + γ²vᵀdY v. X belongs to the closed loop A_c = A + BK, C_c = C₁ + DK
//! under the worst disturbance and the control, [w; u] = Kx; its change solves
//!   A_cᵀdX + dX A_c + S + Sᵀ − 2γ dγ K₁ᵀK₁ = 0,   S = X(dA + dB K) + C_cᵀ(dC₁ + dD K),
//! K₁ the rows of the disturbance. One Lyapunov equation a side, A_cZ + ZA_cᵀ + wwᵀ = 0, therefore gives the derivative
//! by every entry and by γ at once; differences need a search for each entry.

use super::matrix_slope::MatrixSlope;
use super::normal::NormalForm;
use super::riccati_pair::{Coupling, Solved};
use super::side::{RiccatiSide, feedback};
use crate::linalg::Mat;
use crate::linalg::lyapunov::lyapunov_with;
use crate::linalg::schur::{RealSchur, schur};
use crate::lti::connect::stack_cols;
use crate::robust::error::SynthesisError;

/// A level below which one of the conditions fails.
#[derive(Clone, Debug)]
pub(crate) struct BindingLevel {
    /// Its logarithm, to first order in its distance from the level at which it was found.
    pub ln_level: f64,
    /// The derivative of that by the matrices of the plant.
    pub slope: MatrixSlope,
}

/// Levels this far below the optimum, as shares of it, are given: they may bind a step further.
pub(super) const NEAR: f64 = 0.1;
/// Eigenvalues of XY at most.
const COUPLINGS: usize = 4;

/// The largest eigenvalues of XY at a level, and their derivatives.
pub(super) struct Couplings {
    gamma: f64,
    /// From the largest down.
    list: Vec<Coupled>,
}

/// The eigenvalue λ of XY that binds.
pub(super) struct Binding {
    /// γ²/λ − 1.
    pub measure: f64,
    /// Its derivative by ln γ.
    pub slope: f64,
    /// Distance of the next highest level from that of this one, in ln γ.
    pub apart: f64,
}

struct Coupled {
    /// λ/γ².
    ratio: f64,
    of_control: RiccatiSlope,
    of_filter: RiccatiSlope,
}

impl Couplings {
    /// Of positive X and Y at γ.
    pub(super) fn new(
        control: &RiccatiSide,
        filter: &RiccatiSide,
        found: &Solved,
        gamma: f64,
    ) -> Result<Self, SynthesisError> {
        let solutions = [&found.x.x, &found.y.x];
        Self::of_solutions([control, filter], solutions, &found.coupling, gamma)
    }

    /// The same of both sides, their solutions and what couples them.
    pub(super) fn of_solutions(
        [control, filter]: [&RiccatiSide; 2],
        [x, y]: [&Mat<f64>; 2],
        coupling: &Coupling,
        gamma: f64,
    ) -> Result<Self, SynthesisError> {
        let Coupling { root, values, vectors, .. } = coupling;
        let n = x.nrows();
        let (closed_control, closed_filter) =
            rayon::join(|| ClosedSide::new(control, gamma, x), || ClosedSide::new(filter, gamma, y));
        let (closed_control, closed_filter) = (closed_control?, closed_filter?);
        // XYv = λv, w = Yv, vᵀw = 1.
        let of = |k: usize| {
            let w = root * vectors.submatrix(0, k, n, 1);
            let v = x * &w * (1.0 / values[k]);
            let (of_control, of_filter) =
                rayon::join(|| closed_control.slope(x, &w), || closed_filter.slope(y, &(v * values[k].sqrt())));
            Coupled { ratio: values[k] / (gamma * gamma), of_control, of_filter }
        };
        let largest = values.last().copied().unwrap_or(0.0);
        let near = |k: &usize| values[*k] > 0.0 && values[*k] >= largest * (1.0 - NEAR).powi(2);
        Ok(Self { gamma, list: (0..n).rev().take(COUPLINGS).filter(near).map(of).collect() })
    }

    /// The eigenvalue whose level is the highest to first order; none without a coupling.
    pub(super) fn binding(&self) -> Option<Binding> {
        let measures = || self.list.iter().map(Coupled::measure);
        let step = |m: &[f64; 2]| -m[0] / m[1];
        let [measure, slope] = measures().max_by(|a, b| step(a).total_cmp(&step(b)))?;
        let mut steps: Vec<f64> = measures().map(|m| step(&m)).collect();
        steps.sort_by(|a, b| b.total_cmp(a));
        Some(Binding { measure, slope, apart: steps.get(1).map_or(f64::INFINITY, |next| steps[0] - next) })
    }

    /// An estimate of the level at which the largest coupling λ binds, divided by √λ, from its value and derivative λ'
    /// by s = 1/γ² at a level far above. λ(s) is taken as λ/(1 − sλ'/λ), with a pole like that of X and Y; it binds
    /// where it is 1/s.
    pub(super) fn binding_per_root(&self) -> f64 {
        // λ' = γ⁴ times the energy.
        let share = |c: &Coupled| c.energy() / (c.ratio * c.ratio);
        self.list.first().map_or(1.0, |c| (1.0 + share(c)).sqrt())
    }

    /// The levels of the couplings with their derivatives by the matrices of the plant.
    pub(super) fn levels(self, normal: &NormalForm) -> Vec<BindingLevel> {
        let ln_gamma = self.gamma.ln();
        let gamma2 = self.gamma * self.gamma;
        let of = |coupled: Coupled| {
            let whole = 2.0 * gamma2 * (coupled.ratio + coupled.energy());
            let [measure, by_ln] = coupled.measure();
            let ln_level = ln_gamma - measure / by_ln;
            let slope = normal
                .zero_slope()
                .plus(&coupled.of_control.matrices)
                .plus(&coupled.of_filter.matrices.transpose())
                .times(1.0 / whole);
            BindingLevel { ln_level, slope: normal.pulled_back(&slope) }
        };
        self.list.into_iter().map(of).collect()
    }
}

impl Coupled {
    /// −∂λ/∂γ over 2γ.
    fn energy(&self) -> f64 {
        self.of_control.by_level + self.of_filter.by_level
    }

    /// γ²/λ − 1 and its derivative by ln γ.
    fn measure(&self) -> [f64; 2] {
        let slope = 2.0 * (1.0 + self.energy() / self.ratio) / self.ratio;
        [1.0 / self.ratio - 1.0, slope]
    }
}

/// A side closed by its worst disturbance and control.
struct ClosedSide {
    /// [w; u] = Kx.
    k: Mat<f64>,
    /// Rows of the disturbance.
    disturbances: usize,
    c: Mat<f64>,
    /// Schur form of A_cᵀ.
    form: RealSchur,
}

/// wᵀX w of a side as a function of its matrices, and of γ.
struct RiccatiSlope {
    matrices: MatrixSlope,
    /// tr K₁ZK₁ᵀ: the derivative by γ is −2γ times this.
    by_level: f64,
}

impl ClosedSide {
    fn new(side: &RiccatiSide, gamma: f64, x: &Mat<f64>) -> Result<Self, SynthesisError> {
        let k = feedback(side, gamma, x)?;
        let a = &side.a + stack_cols(&side.b1, &side.b2) * &k;
        Ok(Self {
            disturbances: side.b1.ncols(),
            c: &side.c1 + side.feedthrough() * &k,
            form: schur(&a.transpose().to_owned())?,
            k,
        })
    }

    fn slope(&self, x: &Mat<f64>, w: &Mat<f64>) -> RiccatiSlope {
        // A_cZ + ZA_cᵀ + wwᵀ = 0.
        let z = lyapunov_with(&self.form, &(w * w.transpose()));
        let by_a = x * &z * 2.0;
        let by_c = &self.c * &z * 2.0;
        let n = x.nrows();
        let disturbance = self.k.submatrix(0, 0, self.disturbances, n);
        let energy = disturbance * &z * disturbance.transpose();
        RiccatiSlope {
            by_level: (0..energy.nrows()).map(|i| energy[(i, i)]).sum(),
            matrices: MatrixSlope { b: &by_a * self.k.transpose(), d: &by_c * self.k.transpose(), a: by_a, c: by_c },
        }
    }
}
