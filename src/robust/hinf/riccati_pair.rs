//! X and Y at one level γ: definiteness, ρ(XY)/γ², and a measure of feasibility that is continuous in γ.
//! X and Y grow as γ falls and turn indefinite through infinity; 1/λmax therefore passes zero smoothly, and so does
//! γ²/ρ(XY) − 1. The smaller of the two is positive exactly when the conditions hold.

use super::limit::Limit;
use super::side::RiccatiSide;
use crate::linalg::riccati::{CareSolution, RiccatiEffort};
use crate::linalg::{Mat, NumericError, symmetric_eigen};
use crate::robust::error::Condition;

/// X and Y at a level with everything that the conditions need.
pub(super) struct Pair {
    pub x: Mat<f64>,
    pub y: Mat<f64>,
    pub x_residual: f64,
    pub y_residual: f64,
    pub x_min: f64,
    pub y_min: f64,
    /// ρ(XY)/γ².
    pub coupling: f64,
    /// Positive when feasible, negative when not, zero at the boundary and continuous through it.
    pub measure: f64,
    /// The condition that the measure belongs to: the nearest to failing.
    pub nearest: Limit,
    pub failed: Option<Condition>,
}

/// Negative eigenvalues of X and Y relative to the largest that count as rounding. X turns indefinite through infinity,
/// so a true negative eigenvalue is a large one.
pub(super) const DEFINITE: f64 = 1e-7;

/// The stabilising solutions of both sides at one level.
pub(super) struct Solved {
    pub x: CareSolution,
    pub y: CareSolution,
    pub coupling: Coupling,
}

/// Solves both sides at γ; `None` when one of them has no stabilising solution.
pub(super) fn solve_pair(
    control: &RiccatiSide,
    filter: &RiccatiSide,
    gamma: f64,
    effort: RiccatiEffort,
) -> Result<Option<Solved>, NumericError> {
    let (x, y) = rayon::join(|| control.riccati(gamma, effort), || filter.riccati(gamma, effort));
    let (Ok(x), Ok(y)) = (x, y) else {
        return Ok(None);
    };
    let coupling = coupling(&x.x, &y.x)?;
    Ok(Some(Solved { x, y, coupling }))
}

pub(super) struct Coupling {
    pub x_min: f64,
    pub y_min: f64,
    /// ρ(XY), or the most negative eigenvalue of XY when one of them is indefinite.
    pub ratio: f64,
    /// Largest eigenvalue of X and of Y, or the most negative one of an indefinite matrix.
    pub extremes: [f64; 2],
    /// L with Y = LLᵀ, or of X where Y is indefinite, and eigenvalues and eigenvectors of LᵀXL (of LᵀYL).
    pub root: Mat<f64>,
    pub values: Vec<f64>,
    pub vectors: Mat<f64>,
}

impl Coupling {
    /// True when X ≥ 0 and Y ≥ 0.
    pub(super) fn is_definite(&self) -> bool {
        self.x_min >= -DEFINITE && self.y_min >= -DEFINITE
    }

    /// γ²/ρ(XY) − 1, and what is left until X and Y pass through infinity: the smallest, and which it is.
    pub(super) fn measure(&self, gamma: f64, sizes: [f64; 2]) -> (f64, Limit) {
        let passage = |k: usize| {
            if self.extremes[k] == 0.0 { 1.0 } else { sizes[k] / self.extremes[k] }
        };
        let near = if passage(0) <= passage(1) {
            (passage(0), Limit::ControlIndefinite)
        } else {
            (passage(1), Limit::FilterIndefinite)
        };
        if near.0 < 0.0 {
            return (near.0.max(-1.0), near.1);
        }
        let coupling = gamma * gamma / self.ratio.max(1e-12 * gamma * gamma) - 1.0;
        if coupling <= near.0 { (coupling, Limit::Coupling) } else { near }
    }
}

/// Eigenvalues of XY through a factor of the definite one: Y = LLᵀ, eigenvalues of LᵀXL.
pub(super) fn coupling(x: &Mat<f64>, y: &Mat<f64>) -> Result<Coupling, NumericError> {
    let n = x.nrows();
    if n == 0 {
        return Ok(Coupling {
            x_min: 0.0,
            y_min: 0.0,
            ratio: 0.0,
            extremes: [0.0; 2],
            root: Mat::zeros(0, 0),
            values: vec![],
            vectors: Mat::zeros(0, 0),
        });
    }
    let (of_x, of_y) = rayon::join(|| symmetric_eigen(x), || symmetric_eigen(y));
    let ((xv, xu), (yv, yu)) = (of_x?, of_y?);
    let relative = |v: &[f64]| {
        let size = v[0].abs().max(v[n - 1].abs());
        if size > 0.0 { v[0] / size } else { 0.0 }
    };
    let (x_min, y_min) = (relative(&xv), relative(&yv));
    let root =
        |values: &[f64], vectors: &Mat<f64>| Mat::from_fn(n, n, |i, j| vectors[(i, j)] * values[j].max(0.0).sqrt());
    let indefinite = x_min < -DEFINITE || y_min < -DEFINITE;
    let (root, other) = if y_min >= -DEFINITE { (root(&yv, &yu), x) } else { (root(&xv, &xu), y) };
    let (values, vectors) = symmetric_eigen(&(root.transpose() * other * &root))?;
    Ok(Coupling {
        x_min,
        y_min,
        ratio: if indefinite { values[0] } else { values[n - 1] },
        extremes: [(x_min, &xv), (y_min, &yv)].map(|(least, v)| if least < -DEFINITE { v[0] } else { v[n - 1] }),
        root,
        values,
        vectors,
    })
}
