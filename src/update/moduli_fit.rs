//! The iteration of Gauss–Newton on ln θ ([`super::gauss_newton()`] has the objective): Levenberg's damping within a
//! trust region, and the noise along a path.

use super::UpdateError;
use super::problem::{ComparedPeak, UpdateEvaluation, UpdateProblem, UpdateSettings};
use super::targets::Targets;
use crate::linalg::{Mat, symmetric_eigen};
use crate::rotor::Rotor;

/// First trust radius on any ln θ: a factor 1.8.
const FIRST_RADIUS: f64 = 0.6;
/// Largest trust radius on any ln θ.
const LAST_RADIUS: f64 = 1.5;
/// The fit stands when a step gains less than this in the objective, which counts standard deviations squared.
pub(super) const CONVERGED: f64 = 1e-3;
/// On the path to the noise level a tenth of a standard deviation is enough.
const PATH_CONVERGED: f64 = 0.1;
/// Noise-to-prior ratios of the path: frequencies known to 1 % down to 0.03 % when moduli scatter by a factor 1.8.
const PATH: [f64; 6] = [1.6e-2, 8e-3, 4e-3, 2e-3, 1e-3, 5e-4];
/// Evaluations kept back for the final fit.
const RESERVE: usize = 8;

/// A fit of the moduli: its problem, its end and its χ² with the prior.
pub(super) struct ModuliFit {
    pub(super) problem: UpdateProblem,
    pub(super) end: UpdateEvaluation,
    pub(super) statistic: f64,
}

/// Fits the moduli of a rotor from those of its file with given deviations and root of the prior covariance.
pub(super) fn fit_moduli(
    rotor: &Rotor,
    targets: &Targets,
    settings: &UpdateSettings,
    sigma: &[f64],
    root: &Mat<f64>,
) -> Result<ModuliFit, UpdateError> {
    let problem = UpdateProblem::new(rotor, targets, settings.use_antiresonances)?;
    let at = problem.evaluate(&vec![0.0; problem.parameters()], true);
    let mut fit = UpdateFit { problem: &problem, evaluations: 1, limit: settings.max_evaluations.max(2), at };
    let statistic = fit.minimise(sigma, root, CONVERGED)?.objective;
    let end = fit.at;
    Ok(ModuliFit { problem, end, statistic })
}

/// A fit on its way: what it has used of its limit, and where it stands.
pub(super) struct UpdateFit<'a> {
    pub(super) problem: &'a UpdateProblem,
    pub(super) evaluations: usize,
    pub(super) limit: usize,
    pub(super) at: UpdateEvaluation,
}

/// The end of a minimisation: objective and the curvature of the data in prior units.
pub(super) struct State {
    pub objective: f64,
    pub values: Vec<f64>,
    pub vectors: Mat<f64>,
}

/// Weighted residuals and sensitivities in the coordinates u, ln θ = L u.
struct UpdateLinear {
    values: Vec<f64>,
    vectors: Mat<f64>,
    gradient: Mat<f64>,
}

impl UpdateFit<'_> {
    /// Minimises from where it stands with relative standard deviations `sigma` and the root of the prior covariance.
    pub(super) fn minimise(&mut self, sigma: &[f64], root: &Mat<f64>, tolerance: f64) -> Result<State, UpdateError> {
        let n = self.problem.parameters();
        let mut u = crate::linalg::solve(root, &column(&self.at.ln_factors))?;
        let mut objective = self.objective(&self.at, sigma, &u);
        let mut radius = FIRST_RADIUS;
        let mut linear = self.linear(sigma, root, &u)?;
        while self.evaluations < self.limit {
            let (step, move_ln, damped) = bounded_step(&linear, root, radius);
            let predicted = {
                let along = inner(&linear.gradient, &step);
                let in_modes = linear.vectors.transpose() * &step;
                let curvature: f64 = (0..n).map(|k| (1.0 + linear.values[k]) * in_modes[(k, 0)].powi(2)).sum();
                -(2.0 * along + curvature)
            };
            if !predicted.is_finite() || predicted < tolerance && !damped {
                break;
            }
            let trial_u = &u + &step;
            let trial_ln: Vec<f64> = {
                let x = root * &trial_u;
                (0..n).map(|i| x[(i, 0)]).collect()
            };
            let trial = self.problem.evaluate(&trial_ln, true);
            self.evaluations += 1;
            let reached = self.objective(&trial, sigma, &trial_u);
            let gain = objective - reached;
            let ratio = gain / predicted;
            // Usual trust-region rule: shrink after a poor prediction, grow after a good one.
            if ratio < 0.1 {
                radius = move_ln / 3.0;
            } else if ratio > 0.7 {
                radius = (2.0 * move_ln).clamp(radius, LAST_RADIUS);
            }
            if gain > 0.0 {
                (u, objective, self.at) = (trial_u, reached, trial);
                linear = self.linear(sigma, root, &u)?;
                if gain < tolerance && !damped {
                    break;
                }
            }
        }
        Ok(State { objective, values: linear.values, vectors: linear.vectors })
    }

    fn objective(&self, at: &UpdateEvaluation, sigma: &[f64], u: &Mat<f64>) -> f64 {
        let data: f64 = self
            .problem
            .peaks
            .iter()
            .zip(&at.compared)
            .zip(sigma)
            .filter(|((p, _), _)| p.used)
            .map(|((_, c), s)| (c.residual_ln / s).powi(2))
            .sum();
        data + inner(u, u)
    }

    fn linear(&self, sigma: &[f64], root: &Mat<f64>, u: &Mat<f64>) -> Result<UpdateLinear, UpdateError> {
        let n = self.problem.parameters();
        let rows: Vec<(&ComparedPeak, f64)> = self
            .problem
            .peaks
            .iter()
            .zip(&self.at.compared)
            .zip(sigma)
            .filter(|((p, _), _)| p.used)
            .map(|((_, c), s)| (c, *s))
            .collect();
        let sensitivity = Mat::from_fn(rows.len(), n, |i, j| rows[i].0.sensitivity[j] / rows[i].1);
        let j = &sensitivity * root;
        let residual: Vec<f64> = rows.iter().map(|(c, s)| c.residual_ln / s).collect();
        let (values, vectors) = symmetric_eigen(&(j.transpose() * &j))?;
        let gradient = j.transpose() * column(&residual) + u;
        Ok(UpdateLinear { values, vectors, gradient })
    }

    /// Relative noise of the measured frequencies by marginal likelihood; leaves the fit at the tightest point of its
    /// path.
    pub(super) fn noise(&mut self, unit_root: &Mat<f64>) -> Result<f64, UpdateError> {
        let n = self.problem.parameters();
        let peaks = self.problem.peaks.len();
        let count = self.problem.peaks.iter().filter(|p| p.used).count() as f64;
        let mut best: Option<(f64, f64)> = None;
        for ratio in PATH {
            if self.evaluations + RESERVE > self.limit && best.is_some() {
                break;
            }
            let total = self.limit;
            self.limit = total.saturating_sub(RESERVE).max(self.evaluations + 1);
            let state = self.minimise(&vec![ratio; peaks], unit_root, PATH_CONVERGED);
            self.limit = total;
            let state = state?;
            let spread: f64 = (0..n).map(|k| state.values[k].max(0.0).ln_1p()).sum();
            let scale = state.objective / count;
            let evidence = count * scale.ln() + spread + 2.0 * count * ratio.ln();
            let sigma = ratio * scale.sqrt();
            if best.is_none_or(|(e, _)| evidence < e) {
                best = Some((evidence, sigma));
            } else {
                break;
            }
        }
        Ok(best.map_or(PATH[0], |(_, sigma)| sigma))
    }
}

/// −(D + 1 + μ)⁻¹ in the eigenbasis times the gradient, with the smallest μ ≥ 0 that keeps every |Δ ln θ| within the
/// radius. Returns the step, its largest |Δ ln θ|, and whether μ > 0.
fn bounded_step(linear: &UpdateLinear, root: &Mat<f64>, radius: f64) -> (Mat<f64>, f64, bool) {
    let n = linear.values.len();
    let g = linear.vectors.transpose() * &linear.gradient;
    let step = |mu: f64| {
        let y = Mat::from_fn(n, 1, |k, _| -g[(k, 0)] / (1.0 + mu + linear.values[k].max(0.0)));
        let s = &linear.vectors * y;
        let x = root * &s;
        let largest = (0..n).map(|i| x[(i, 0)].abs()).fold(0.0, f64::max);
        (s, largest)
    };
    let (s, largest) = step(0.0);
    if largest <= radius {
        return (s, largest, false);
    }
    let (mut lo, mut hi) = (0.0f64, 1.0f64);
    // Doubling from 1 passes any curvature met (1e12) within 40 steps.
    for _ in 0..60 {
        if step(hi).1 <= radius {
            break;
        }
        lo = hi;
        hi *= 2.0;
    }
    // Eight halvings: the radius is a matter of trust, not of digits.
    for _ in 0..8 {
        let mid = 0.5 * (lo + hi);
        if step(mid).1 <= radius {
            hi = mid;
        } else {
            lo = mid;
        }
    }
    let (s, largest) = step(hi);
    (s, largest, true)
}

fn column(x: &[f64]) -> Mat<f64> {
    Mat::from_fn(x.len(), 1, |i, _| x[i])
}

fn inner(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.nrows()).map(|i| a[(i, 0)] * b[(i, 0)]).sum()
}
