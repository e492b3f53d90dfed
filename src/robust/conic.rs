//! Conic programmes: the only user of clarabel.
//!
//!   minimise  cᵀx (+ ½ xᵀPx)   subject to   ‖Fx + g‖ ≤ aᵀx + b,   aᵀx ≤ b,   aᵀx = b
//!
//! The answer of the solver is never trusted here or above: callers evaluate the bound that belongs to x themselves, so
//! an end short of full accuracy only costs tightness.

use crate::linalg::{Mat, lapack};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use thiserror::Error;

/// Why a programme has no answer.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ProgrammeError {
    /// No point satisfies the constraints.
    #[error("the convex programme is infeasible")]
    Infeasible,
    /// The objective falls without limit.
    #[error("the convex programme is unbounded")]
    Unbounded,
    /// The interior-point iteration broke down.
    #[error("the interior-point solver stopped with {status} after {iterations} iterations")]
    Stopped {
        /// Status as the solver names it.
        status: String,
        iterations: u32,
    },
}

/// aᵀx ⋚ b with a sparse a.
#[derive(Clone, Debug)]
pub(crate) struct SparseRow {
    /// Variables and their coefficients.
    pub terms: Vec<(usize, f64)>,
    /// Right-hand side b.
    pub bound: f64,
}

/// aᵀx + b.
#[derive(Clone, Debug, Default)]
pub(crate) struct Affine {
    /// Variables and their coefficients.
    pub terms: Vec<(usize, f64)>,
    /// b.
    pub constant: f64,
}

/// ‖(parts)‖ ≤ bound.
#[derive(Clone, Debug, Default)]
pub(crate) struct NormInequality {
    pub bound: Affine,
    /// Entries of the vector.
    pub parts: Vec<Affine>,
}

impl Affine {
    pub(crate) fn at(&self, x: &[f64]) -> f64 {
        let terms = self.terms.iter();
        terms.fold(self.constant, |sum, (k, value)| sum + value * x[*k])
    }
}

impl NormInequality {
    /// By how much of the bound the norm exceeds it at x; negative within.
    pub(crate) fn excess(&self, x: &[f64]) -> f64 {
        let norm = self.parts.iter().map(|p| p.at(x).powi(2)).sum::<f64>();
        norm.sqrt() / self.bound.at(x) - 1.0
    }
}

/// A convex programme; see the module for its form.
#[derive(Clone, Debug, Default)]
pub(crate) struct Programme {
    /// Objective c; its length is the number of variables.
    pub objective: Vec<f64>,
    /// aᵀx = b.
    pub equalities: Vec<SparseRow>,
    /// aᵀx ≤ b.
    pub inequalities: Vec<SparseRow>,
    /// Bounds on Euclidean norms.
    pub norms: Vec<NormInequality>,
}

/// minimise ½ xᵀPx + cᵀx subject to equalities aᵀx = b and inequalities aᵀx ≤ b.
#[derive(Clone, Debug)]
pub(crate) struct QuadraticProgramme {
    /// P, positive semidefinite; its upper triangle is read.
    pub quadratic: Mat<f64>,
    /// c.
    pub objective: Vec<f64>,
    /// aᵀx = b.
    pub equalities: Vec<SparseRow>,
    /// aᵀx ≤ b.
    pub inequalities: Vec<SparseRow>,
}

impl QuadraticProgramme {
    /// The minimiser.
    pub(crate) fn solve(&self) -> Result<Vec<f64>, ProgrammeError> {
        lapack::link();
        let n = self.objective.len();
        // The solver has no answer for a programme without variables.
        if n == 0 {
            return Ok(vec![]);
        }
        let linear = Programme {
            objective: self.objective.clone(),
            equalities: self.equalities.clone(),
            inequalities: self.inequalities.clone(),
            ..Programme::default()
        };
        let (a, b, cones) = linear.conic_form();
        let upper = || (0..n).flat_map(|j| (0..=j).map(move |i| (i, j)));
        let quadratic = CscMatrix::new(
            n,
            n,
            (0..=n).map(|j| j * (j + 1) / 2).collect(),
            upper().map(|(i, _)| i).collect(),
            upper().map(|ij| self.quadratic[ij]).collect(),
        );
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .presolve_enable(false)
            .max_iter(MAX_ITERATIONS)
            .build()
            .map_err(|e| name_stop(&e, 0))?;
        let mut solver =
            DefaultSolver::new(&quadratic, &self.objective, &a, &b, &cones, settings).map_err(|e| name_stop(&e, 0))?;
        solver.solve();
        let end = &solver.solution;
        if end.x.iter().all(|v| v.is_finite()) && end.iterations > 0 {
            return Ok(end.x.clone());
        }
        Err(name_stop(&end.status, end.iterations))
    }
}

/// Where the solver ended.
#[derive(Clone, Debug)]
pub(crate) struct Optimum {
    pub x: Vec<f64>,
    /// Whether the solver reached its full accuracy.
    pub is_accurate: bool,
}

/// Iterations after which a solve is given up; problems of this crate need 10 to 40.
const MAX_ITERATIONS: u32 = 120;

impl Programme {
    pub(crate) fn solve(&self) -> Result<Optimum, ProgrammeError> {
        lapack::link();
        let (a, b, cones) = self.conic_form();
        let n = self.objective.len();
        // Problems here are small and dense: presolve and chordal decomposition only cost time.
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .presolve_enable(false)
            .chordal_decomposition_enable(false)
            .max_iter(MAX_ITERATIONS)
            .build()
            .map_err(|e| name_stop(&e, 0))?;
        let quadratic = CscMatrix::zeros((n, n));
        let mut solver =
            DefaultSolver::new(&quadratic, &self.objective, &a, &b, &cones, settings).map_err(|e| name_stop(&e, 0))?;
        solver.solve();
        let end = &solver.solution;
        match end.status {
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Err(ProgrammeError::Infeasible),
            SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => Err(ProgrammeError::Unbounded),
            _ if end.x.iter().all(|v| v.is_finite()) && end.iterations > 0 => {
                Ok(Optimum { x: end.x.clone(), is_accurate: end.status == SolverStatus::Solved })
            }
            status => Err(name_stop(&status, end.iterations)),
        }
    }

    /// Ax + s = b, s in the product of the cones: equalities, inequalities, norms.
    fn conic_form(&self) -> (CscMatrix<f64>, Vec<f64>, Vec<SupportedConeT<f64>>) {
        let mut columns: Vec<Vec<(usize, f64)>> = vec![vec![]; self.objective.len()];
        let mut b = vec![];
        for row in self.equalities.iter().chain(&self.inequalities) {
            for (variable, value) in &row.terms {
                columns[*variable].push((b.len(), *value));
            }
            b.push(row.bound);
        }
        let mut cones = vec![];
        if !self.equalities.is_empty() {
            cones.push(SupportedConeT::ZeroConeT(self.equalities.len()));
        }
        if !self.inequalities.is_empty() {
            cones.push(SupportedConeT::NonnegativeConeT(self.inequalities.len()));
        }
        for norm in &self.norms {
            for affine in std::iter::once(&norm.bound).chain(&norm.parts) {
                for (variable, value) in &affine.terms {
                    columns[*variable].push((b.len(), -value));
                }
                b.push(affine.constant);
            }
            cones.push(SupportedConeT::SecondOrderConeT(1 + norm.parts.len()));
        }
        let (mut pointers, mut rows, mut values) = (vec![0], vec![], vec![]);
        for column in columns {
            for (row, value) in column {
                rows.push(row);
                values.push(value);
            }
            pointers.push(rows.len());
        }
        let a = CscMatrix::new(b.len(), self.objective.len(), pointers, rows, values);
        (a, b, cones)
    }
}

fn name_stop(status: &impl std::fmt::Debug, iterations: u32) -> ProgrammeError {
    ProgrammeError::Stopped { status: format!("{status:?}"), iterations }
}
