//! `muspin solve care` and `dare`: A with G and Q, or A, B, Q, R and a cross term → X, its relative residual, the poles
//! of the loop, and the gain where there is a B.

use super::answer::number;
use super::{Answer, Failure, ProblemFields};
use crate::linalg::lyapunov::symmetric;
use crate::linalg::regulator::{Regulator, RegulatorSolution};
use crate::linalg::riccati::{RiccatiError, care};
use crate::linalg::{Mat, c64, solve as divide};
use crate::robust::riccati_cause::{find_cause, find_regulator_cause};
use serde_json::Value;

/// Solves the problem of a `care` file.
pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    if problem.has("B") && !problem.has("G") {
        let found = solve_given(problem, false)?;
        let growth_rate = found.poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
        return Ok(stated(&found).with_number("closed_loop_max_real", growth_rate));
    }
    if let Some(field) = ["B", "R", "S", "N", "E"].into_iter().find(|field| problem.has(field)) {
        return Err(problem.failure(field, "stands beside G: give A, G, Q or A, B, Q, R").into());
    }
    let a = problem.square("A")?;
    let n = a.nrows();
    problem.agrees("n", n)?;
    let g = problem.matrix_of("G", n, n)?;
    let q = problem.matrix_of("Q", n, n)?;
    let found = care(&a, &g, &q).map_err(|error| {
        let cause = if is_unsolved(&error) { find_cause(&a, &g, &q).ok().flatten() } else { None };
        explain(error, cause)
    })?;
    Ok(Answer::new()
        .with_matrix("X", &found.x)
        .with_number("residual", found.residual)
        .with_number("closed_loop_max_real", found.closed_loop_max_real))
}

/// Solves the problem of a `dare` file.
pub(super) fn solve_sampled(problem: &ProblemFields) -> Result<Answer, Failure> {
    let found = solve_given(problem, true)?;
    let radius = found.poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    Ok(stated(&found).with_number("closed_loop_max_abs", radius))
}

fn stated(found: &RegulatorSolution) -> Answer {
    let parts = |part: fn(&c64) -> f64| found.poles.iter().map(|pole| number(part(pole))).collect::<Vec<Value>>();
    let poles = Answer::new().with("re", parts(|pole| pole.re)).with("im", parts(|pole| pole.im));
    Answer::new()
        .with_matrix("X", &found.x)
        .with_matrix("F", &found.gain)
        .with_number("residual", found.residual)
        .with("closed_loop_poles", poles)
}

/// The solution of A, B, Q, R, a cross term and E. With E the equation of E⁻¹A and E⁻¹B has the solution E'XE.
fn solve_given(problem: &ProblemFields, is_sampled: bool) -> Result<RegulatorSolution, Failure> {
    let a = problem.square("A")?;
    let n = a.nrows();
    problem.agrees("n", n)?;
    let b = problem.rows_of("B", n)?;
    let [q, r, s] = read_cost(problem, n, b.ncols())?;
    let Some((e, _)) = problem.descriptor(n)? else {
        return solve_regulator(&Regulator { a, b, q, r, s, is_sampled });
    };
    let found = solve_regulator(&Regulator { a: divide(&e, &a)?, b: divide(&e, &b)?, q, r, s, is_sampled })?;
    let transposed = e.transpose().to_owned();
    let left = divide(&transposed, &found.x)?;
    let x = divide(&transposed, &left.transpose().to_owned())?;
    Ok(RegulatorSolution { x: symmetric(&x), ..found })
}

/// Q, R and the cross term, which may be called S or N.
pub(super) fn read_cost(problem: &ProblemFields, n: usize, m: usize) -> Result<[Mat<f64>; 3], Failure> {
    let q = problem.matrix_of("Q", n, n)?;
    let r = if problem.has("R") { problem.matrix_of("R", m, m)? } else { Mat::identity(m, m) };
    let s = match (problem.has("S"), problem.has("N")) {
        (true, true) => return Err(problem.failure("N", "is another name of S: give one").into()),
        (true, false) => problem.matrix_of("S", n, m)?,
        (false, true) => problem.matrix_of("N", n, m)?,
        (false, false) => Mat::zeros(n, m),
    };
    Ok([q, r, s])
}

/// The stabilising solution, or the condition on the data behind its failure.
pub(super) fn solve_regulator(regulator: &Regulator) -> Result<RegulatorSolution, Failure> {
    regulator.solve().map_err(|error| {
        let cause = if is_unsolved(&error) { find_regulator_cause(regulator).ok().flatten() } else { None };
        explain(error, cause)
    })
}

fn is_unsolved(error: &RiccatiError) -> bool {
    use RiccatiError as E;
    matches!(error, E::AxisEigenvalue { .. } | E::CircleEigenvalue { .. } | E::NoStabilisingSolution { .. })
}

/// The failure with the condition on the data behind it, if it is known.
fn explain(error: RiccatiError, cause: Option<String>) -> Failure {
    match cause {
        Some(cause) => Failure::new(format!("Riccati equation: {error}")).with_hint(cause),
        None => error.into(),
    }
}

impl From<RiccatiError> for Failure {
    fn from(error: RiccatiError) -> Self {
        use RiccatiError as E;
        let hint = match error {
            E::NotSymmetric { .. } => "symmetrise the matrix before writing it",
            E::AxisEigenvalue { .. } | E::CircleEigenvalue { .. } => {
                "every mode is reached by the control and every undamped one observed by Q: with an indefinite G, R or \
                 Q a level below the optimum of an H-infinity problem has no solution"
            }
            E::Numeric(_) => "R must have an inverse; in sampled time R + B'XB",
            E::NoStabilisingSolution { .. } => "check that the control stabilises A, and the scaling of the data",
        };
        Self::new(format!("Riccati equation: {error}")).with_hint(hint)
    }
}
