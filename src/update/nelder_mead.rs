//! The search of the reference method: Nelder–Mead on Eq. (7),  err = Σ |Δf_r|^w_r + Σ |Δf_a|^w_a, errors in Hz.
//!
//! The search moves ln θ, so factors stay positive. Fifteen moduli and eight data leave a seven-dimensional set of
//! equal objective; a simplex along the coordinate axes spends its iterations there. Each simplex here spans the
//! combinations that the data determine (singular vectors of the sensitivity, see `determine`), sized by the
//! step that a linear model would take, and after its share of the iterations a new one starts at the best point.
//! Symbols: w exponents, θ modulus factors.

use super::UpdateError;
use super::determine::{find_determined, prior_root};
use super::outcome::{self, Explanation, Finish, Method, Updated, assemble};
use super::peak_kind::PeakKind;
use super::problem::{UpdateEvaluation, UpdateProblem, UpdateSettings};
use super::targets::Targets;
use crate::linalg::simplex_search::descend_simplex;
use crate::linalg::{Mat, symmetric_eigen};
use crate::rotor::Rotor;
use std::cell::Cell;

/// Largest |Δ ln θ| of a vertex: beyond a factor 1.6 the linear picture of the simplex no longer holds.
const VERTEX_LIMIT: f64 = 0.5;
/// A vertex moves at least this share of the largest frequency error along its combination, so that no edge collapses.
const LEAST_EDGE: f64 = 0.02;
/// Singular values below this share of the largest belong to rounding.
const RANK_TOLERANCE: f64 = 1e-9;

/// Moves the modulus factors with Nelder–Mead; settings give exponents, iterations and number of simplexes.
///
/// # Errors
/// As [`super::gauss_newton_rotor`].
pub fn nelder_mead_rotor(rotor: &Rotor, targets: &Targets, settings: &UpdateSettings) -> Result<Updated, UpdateError> {
    let problem = UpdateProblem::new(rotor, targets, settings.use_antiresonances)?;
    let n = problem.parameters();
    let positions: Vec<f64> = problem.chain.regions.iter().map(|r| r.position_m).collect();
    let unit_root = prior_root(&positions, 1.0, settings.prior_correlation_m)?;
    let start = problem.evaluate(&vec![0.0; n], true);
    outcome::check_matches(&problem, &start)?;
    let evaluations = Cell::new(1);
    let mut at = start.clone();
    let mut iterations = 0;
    let simplexes = settings.simplexes.clamp(1, settings.iterations.max(1));
    for k in 0..simplexes {
        // Equal shares; the remainder goes to the first ones.
        let share = settings.iterations / simplexes + usize::from(k < settings.iterations % simplexes);
        let vertices = simplex(&problem, &at, &unit_root)?;
        let before = objective(&problem, settings, &at);
        let value = |ln_factors: &[f64]| {
            evaluations.set(evaluations.get() + 1);
            objective(&problem, settings, &problem.evaluate(ln_factors, false))
        };
        let Some(end) = descend_simplex(vertices, share, value) else { continue };
        iterations += end.steps;
        if end.value < before {
            at = problem.evaluate(&end.point, true);
        }
    }
    let relative_sd: Vec<f64> = problem
        .peaks
        .iter()
        .map(|p| {
            let given = p.target.standard_deviation_hz;
            given.map_or(0.0, |s| s / p.target.frequency_hz).max(settings.floor_relative_sd)
        })
        .collect();
    let used = problem.peaks.iter().filter(|p| p.used);
    let data = used.clone().count();
    let no_sd = used.clone().any(|p| p.target.standard_deviation_hz.is_none());
    let statistic: f64 = problem
        .peaks
        .iter()
        .zip(&at.compared)
        .zip(&relative_sd)
        .filter(|((p, _), _)| p.used)
        .map(|((_, c), s)| (c.residual_ln / s).powi(2))
        .sum();
    let sd = settings.prior_sd_ln;
    let root = Mat::from_fn(n, n, |i, j| sd * unit_root[(i, j)]);
    let j = weigh_jacobian(&problem, &at, &relative_sd) * &root;
    let (values, vectors) = symmetric_eigen(&(j.transpose() * &j))?;
    let explanation = Explanation::judge(&problem, &at, statistic, data, no_sd);
    assemble(
        rotor,
        &problem,
        Finish {
            method: Method::NelderMead,
            start: &start,
            end: &at,
            evaluations: evaluations.get(),
            iterations,
            relative_sd,
            noise_estimated: no_sd,
            determined: find_determined(&root, &values, &vectors),
            explanation,
        },
        targets,
    )
}

/// Objective function of Eq. (7).
fn objective(problem: &UpdateProblem, settings: &UpdateSettings, at: &UpdateEvaluation) -> f64 {
    let used = problem.peaks.iter().zip(&at.compared).filter(|(p, _)| p.used);
    let errors = used.map(|(peak, compared)| {
        let exponent = match peak.kind {
            PeakKind::Resonance => settings.resonance_exponent,
            PeakKind::Antiresonance => settings.antiresonance_exponent,
        };
        let error_hz = peak.target.frequency_hz * compared.residual_ln.exp_m1();
        error_hz.abs().powf(exponent)
    });
    errors.sum()
}

/// The best point and one vertex along every combination that the data determine.
fn simplex(problem: &UpdateProblem, at: &UpdateEvaluation, unit_root: &Mat<f64>) -> Result<Vec<Vec<f64>>, UpdateError> {
    let n = problem.parameters();
    let ones = vec![1.0; problem.peaks.len()];
    let j = weigh_jacobian(problem, at, &ones) * unit_root;
    let residual: Vec<f64> =
        problem.peaks.iter().zip(&at.compared).filter(|(p, _)| p.used).map(|(_, c)| c.residual_ln).collect();
    let largest = residual.iter().fold(0.0f64, |m, r| m.max(r.abs()));
    let (values, vectors) = symmetric_eigen(&(j.transpose() * &j))?;
    let gradient = j.transpose() * Mat::from_fn(residual.len(), 1, |i, _| residual[i]);
    let along = vectors.transpose() * gradient;
    let directions = unit_root * &vectors;
    let top = values.last().copied().unwrap_or(0.0);
    let mut vertices = vec![at.ln_factors.clone()];
    for k in (0..n).rev().take(residual.len()) {
        let s = values[k].max(0.0).sqrt();
        if s <= RANK_TOLERANCE * top.max(0.0).sqrt() {
            break;
        }
        let newton = -along[(k, 0)] / values[k];
        let least = LEAST_EDGE * largest.max(1e-6) / s;
        let mut length = newton.abs().max(least).copysign(newton);
        let reach = (0..n).map(|i| (length * directions[(i, k)]).abs());
        let reach = reach.fold(0.0, f64::max);
        if reach > VERTEX_LIMIT {
            length *= VERTEX_LIMIT / reach;
        }
        vertices.push((0..n).map(|i| at.ln_factors[i] + length * directions[(i, k)]).collect());
    }
    Ok(vertices)
}

/// Sensitivities of the used peaks over their standard deviations, peaks × regions.
fn weigh_jacobian(problem: &UpdateProblem, at: &UpdateEvaluation, sigma: &[f64]) -> Mat<f64> {
    let rows: Vec<(&Vec<f64>, f64)> = problem
        .peaks
        .iter()
        .zip(&at.compared)
        .zip(sigma)
        .filter(|((p, _), _)| p.used)
        .map(|((_, c), s)| (&c.sensitivity, *s))
        .collect();
    Mat::from_fn(rows.len(), problem.parameters(), |i, j| rows[i].0.get(j).copied().unwrap_or(0.0) / rows[i].1)
}
