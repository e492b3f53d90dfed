//! Derivative of the smallest feasible level by the matrices of the plant.
//!
//! Where ρ(XY) = γ² binds: XYv = γ²v, w = Yv, vᵀw = 1, so dρ = wᵀdX w + γ²vᵀdY v. X belongs to the closed loop A_c =
//! A + BK, C_c = C₁ + DK under the worst disturbance and the control, [w; u] = Kx; its change solves
//!   A_cᵀdX + dX A_c + S + Sᵀ − 2γ dγ K₁ᵀK₁ = 0,   S = X(dA + dB K) + C_cᵀ(dC₁ + dD K),
//! K₁ the rows of the disturbance. One Lyapunov equation a side, A_cZ + ZA_cᵀ + wwᵀ = 0, therefore gives the derivative
//! by every entry and by γ at once; differences need a search for each entry.
//!
//! Where one side binds, γ = σmax(ΠP₁₁(jω)) at its peak; the derivative there is that of a singular value, uᴴ dP f with
//! f = [v; −P₁₂⁺P₁₁v] (a peak does not move to first order).

use super::matrix_slope::MatrixSlope;
use super::normal::NormalForm;
use super::riccati_pair::{Coupling, Solved, solved};
use super::search::Search;
use super::side::{Regulator, Side, beyond_control, feedback};
use crate::linalg::dense::complex;
use crate::linalg::hermitian::singular_vectors;
use crate::linalg::lyapunov::lyapunov_with;
use crate::linalg::riccati::Effort;
use crate::linalg::schur::{RealSchur, schur};
use crate::linalg::{Mat, c64, solve_complex};
use crate::lti::connect::stack_cols;
use crate::lti::level_set::Peak;
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
const NEAR: f64 = 0.1;
/// Eigenvalues of XY at most.
const COUPLINGS: usize = 4;

/// The levels that bind at the optimum `gamma` of a search, or nearly: those of the largest eigenvalues of XY, and of
/// the two sides.
pub(super) fn binding_levels(
    search: &Search,
    gamma: f64,
) -> Result<Vec<BindingLevel>, SynthesisError> {
    let normal = &search.normal;
    let (control, filter) = (&search.control, &search.filter);
    // No solution at the end of a bracket means that a side binds.
    let mut found = match solved(control, filter, gamma, Effort::Fast)? {
        Some(found) if found.coupling.is_definite() => {
            Couplings::new(control, filter, &found, gamma)?.levels(normal)
        }
        _ => vec![],
    };
    let near = |level: &Peak| level.lower >= gamma * (1.0 - NEAR);
    let mut add = |level: &Peak, slope: &MatrixSlope| {
        found.push(BindingLevel {
            ln_level: level.lower.ln(),
            slope: normal.pulled_back(&normal.zero_slope().plus(slope)),
        });
    };
    if near(&search.control_level) {
        let slope = axis_slope(control, &search.control_regulator, &search.control_level)?;
        add(&search.control_level, &slope);
    }
    if near(&search.filter_level) {
        let slope = axis_slope(filter, &search.filter_regulator, &search.filter_level)?;
        add(&search.filter_level, &slope.transposed());
    }
    Ok(found)
}

/// The largest eigenvalues of XY at a level, and their derivatives.
pub(super) struct Couplings {
    gamma: f64,
    /// From the largest down.
    list: Vec<Coupled>,
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
        control: &Side,
        filter: &Side,
        found: &Solved,
        gamma: f64,
    ) -> Result<Self, SynthesisError> {
        let (x, y) = (&found.x.x, &found.y.x);
        let Coupling {
            root,
            values,
            vectors,
            ..
        } = &found.coupling;
        let n = x.nrows();
        let (closed_control, closed_filter) = rayon::join(
            || ClosedSide::new(control, gamma, x),
            || ClosedSide::new(filter, gamma, y),
        );
        let (closed_control, closed_filter) = (closed_control?, closed_filter?);
        // XYv = λv, w = Yv, vᵀw = 1.
        let of = |k: usize| {
            let w = root * vectors.submatrix(0, k, n, 1);
            let v = x * &w * (1.0 / values[k]);
            Coupled {
                ratio: values[k] / (gamma * gamma),
                of_control: closed_control.slope(x, &w),
                of_filter: closed_filter.slope(y, &(v * values[k].sqrt())),
            }
        };
        let largest = values.last().copied().unwrap_or(0.0);
        let near = |k: &usize| values[*k] > 0.0 && values[*k] >= largest * (1.0 - NEAR).powi(2);
        Ok(Self {
            gamma,
            list: (0..n).rev().take(COUPLINGS).filter(near).map(of).collect(),
        })
    }

    /// Newton's step of ln γ towards γ² = ρ(XY), by γ²/ρ(XY) − 1; none without a coupling.
    pub(super) fn newton(&self) -> Option<f64> {
        let top = self.list.first()?;
        Some(top.newton())
    }

    /// The levels of the couplings with their derivatives by the matrices of the plant.
    pub(super) fn levels(self, normal: &NormalForm) -> Vec<BindingLevel> {
        let ln_gamma = self.gamma.ln();
        let gamma2 = self.gamma * self.gamma;
        let of = |coupled: Coupled| {
            let whole = 2.0 * gamma2 * (coupled.ratio + coupled.energy());
            let ln_level = ln_gamma + coupled.newton();
            let slope = normal
                .zero_slope()
                .plus(&coupled.of_control.matrices)
                .plus(&coupled.of_filter.matrices.transposed())
                .times(1.0 / whole);
            BindingLevel {
                ln_level,
                slope: normal.pulled_back(&slope),
            }
        };
        self.list.into_iter().map(of).collect()
    }
}

impl Coupled {
    /// −∂λ/∂γ over 2γ.
    fn energy(&self) -> f64 {
        self.of_control.by_level + self.of_filter.by_level
    }

    fn newton(&self) -> f64 {
        // h = 1/ratio − 1, dh/d ln γ = 2 (1 + energy/ratio)/ratio.
        (self.ratio - 1.0) / (2.0 * (1.0 + self.energy() / self.ratio))
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
    fn new(side: &Side, gamma: f64, x: &Mat<f64>) -> Result<Self, SynthesisError> {
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
            matrices: MatrixSlope {
                b: &by_a * self.k.transpose(),
                d: &by_c * self.k.transpose(),
                a: by_a,
                c: by_c,
            },
        }
    }
}

/// d ln of the level of one side at its peak.
fn axis_slope(
    side: &Side,
    regulator: &Regulator,
    level: &Peak,
) -> Result<MatrixSlope, SynthesisError> {
    let (n, m1, m2) = (side.a.nrows(), side.b1.ncols(), side.b2.ncols());
    let closed = side.regulated(regulator);
    let (b, c) = (complex(&closed.b), complex(&closed.c));
    let finite = level.omega_rad_s.is_finite();
    let pencil = Mat::from_fn(n, n, |i, j| {
        let diagonal = if i == j { level.omega_rad_s } else { 0.0 };
        c64::new(-closed.a[(i, j)], diagonal)
    });
    let states = match finite {
        true => solve_complex(&pencil, &b),
        false => Mat::zeros(n, m1 + m2),
    };
    let (rest, reached) = beyond_control(&(&c * &states + complex(&closed.d)), m1);
    let (left, values, right) = singular_vectors(&rest)?;
    let (u, v) = (left.subcols(0, 1).to_owned(), right.subcols(0, 1));
    // The disturbance v and the control that answers it best, around the feedback F₂.
    let answer = &reached * v;
    let around = Mat::from_fn(m1 + m2, 1, |i, _| match i < m1 {
        true => v[(i, 0)],
        false => -answer[(i - m1, 0)],
    });
    let x = &states * &around;
    let regulated = complex(&regulator.f) * &x;
    let f = Mat::from_fn(m1 + m2, 1, |i, _| match i < m1 {
        true => around[(i, 0)],
        false => around[(i, 0)] + regulated[(i - m1, 0)],
    });
    let y = match finite {
        true => solve_complex(&pencil.adjoint().to_owned(), &(c.adjoint() * &u)),
        false => Mat::zeros(n, 1),
    };
    // d ln σ = Re uᴴ dP f / σ.
    let outer = |left: &Mat<c64>, right: &Mat<c64>| {
        Mat::from_fn(left.nrows(), right.nrows(), |i, j| {
            (left[(i, 0)].conj() * right[(j, 0)]).re / values[0]
        })
    };
    Ok(MatrixSlope {
        a: outer(&y, &x),
        b: outer(&y, &f),
        c: outer(&u, &x),
        d: outer(&u, &f),
    })
}
