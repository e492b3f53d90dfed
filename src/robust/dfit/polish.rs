//! Nonlinear minimax polish of a magnitude fit: prox-linear steps on the largest error, with the curvature that they
//! teach.
//!
//!   minimise over the parameters   max over the data of  weight · |ln|d| − ln m|
//!
//! Fewer errors than parameters may bind at a fit, so that curvature decides how far a step goes along the rest.

use super::factors::Factors;
use super::magnitudes::Magnitudes;
use crate::linalg::dense::dot;
use crate::linalg::{Mat, symmetric_eigen};
use crate::robust::minimax::curvature::Curvature;
use crate::robust::minimax::proximal::{HEAVIEST, after_refusal, after_step, is_accepted};
use crate::robust::minimax::step::{LinearValue, MinimaxStep, StepRule, curved_step};

/// Largest weighted |ln(|d|/m)|.
pub(crate) fn weighted_error(data: &Magnitudes, fit: &Factors) -> f64 {
    data.points()
        .map(|(w, m, weight)| weight * (fit.ln_magnitude(w) - m.ln()).abs())
        .fold(
            0.0,
            |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) },
        )
}

/// A step that promises less than this share of the error ends a polish: what is left is far below what the shape of a
/// D-scale is known to.
const SETTLED: f64 = 1e-5;
/// Above this proximal weight it is the weight that keeps a promise small, and a lighter one follows.
const LIGHT: f64 = 1e-2;
const LIGHTER: f64 = 0.1;
/// Errors below this are smaller than anything a D-scale can show.
const EXACT: f64 = 1e-10;
/// Weight of a parameter itself in the metric, beside its effect on |d|: a pole on its zero has none.
const OWN: f64 = 0.03;

/// Improves a fit by at most `steps` steps; the result keeps the limits and is never worse than the start moved into
/// them.
pub(crate) fn polish(data: &Magnitudes, start: Factors, steps: usize) -> Factors {
    let mut best = start.with_parameters(&start.parameters(), &data.limits);
    let mut error = weighted_error(data, &best);
    let mut rows = errors(data, &best);
    let mut binding: Vec<(usize, f64)> = vec![];
    let mut weight = 1.0;
    let mut lightened = false;
    for _ in 0..steps {
        if error < EXACT || weight > HEAVIEST {
            break;
        }
        let Some((whiten, curvature)) = coordinates(data, &best, &binding) else {
            break;
        };
        let found = scaled_step(&rows, error, &binding, (&whiten, &curvature), weight);
        let Some((step, predicted)) = found else {
            weight = after_refusal(weight, false);
            continue;
        };
        let moved = |by: &[f64]| {
            let pairs = best.parameters();
            let values: Vec<f64> = pairs.iter().zip(by).map(|(p, s)| p + s).collect();
            best.with_parameters(&values, &data.limits)
        };
        let mut trial = moved(&step.step);
        let mut next = weighted_error(data, &trial);
        let promised = error - predicted - curvature.half_along(&step.step);
        if !is_accepted(error - next, promised) {
            // The errors as the step found them, on slopes from before it: what the slopes did not show bends them.
            let seen = corrected(&rows, &errors(data, &trial), &step.step);
            let again = scaled_step(&seen, error, &binding, (&whiten, &curvature), weight);
            if let Some((again, _)) = again {
                let other = moved(&again.step);
                let level = weighted_error(data, &other);
                if level < next {
                    (trial, next) = (other, level);
                }
            }
        }
        let held = promised < SETTLED * error;
        if held && (weight <= LIGHT || lightened) {
            break;
        }
        binding = step.binding;
        let kept = error - next;
        lightened = held || (lightened && kept < SETTLED * error);
        weight = match is_accepted(kept, promised) {
            _ if held => LIGHTER * weight,
            true => after_step(weight, kept, promised),
            false => after_refusal(weight, kept > -promised),
        };
        if is_accepted(kept, promised) {
            (best, error) = (trial, next);
            rows = errors(data, &best);
        }
    }
    best
}

/// The errors and their negatives with their slopes, by pairs.
fn errors(data: &Magnitudes, fit: &Factors) -> Vec<LinearValue> {
    let pair = |(w, m, weight): (f64, f64, f64)| {
        let (value, gradient) = fit.ln_magnitude_with_gradient(w);
        [weight, -weight].map(|signed| LinearValue {
            limit: None,
            value: signed * (value - m.ln()),
            gradient: gradient.iter().map(|g| signed * g).collect(),
        })
    };
    data.points().flat_map(pair).collect()
}

/// The step and the error that the linear model predicts.
///
/// The programme is solved for errors in units of the largest one and steps in units of its root, in which curvature
/// and weight are the same: its tolerances are absolute.
fn scaled_step(
    rows: &[LinearValue],
    error: f64,
    binding: &[(usize, f64)],
    (whiten, curvature): (&Mat<f64>, &Curvature),
    weight: f64,
) -> Option<(MinimaxStep, f64)> {
    let root = error.sqrt();
    let scaled = |row: &LinearValue| LinearValue {
        limit: None,
        value: row.value / error,
        gradient: row.gradient.iter().map(|g| g / root).collect(),
    };
    let scaled: Vec<LinearValue> = rows.iter().map(scaled).collect();
    let rule = StepRule {
        limits: 0,
        penalty: 0.0,
        proximal: weight,
    };
    let likely: Vec<usize> = binding.iter().map(|(k, _)| *k).collect();
    let mut found = curved_step(&scaled, &likely, (whiten, curvature), &rule)?;
    found.step.iter_mut().for_each(|s| *s *= root);
    let predicted = found.predicted * error;
    Some((found, predicted))
}

/// Errors that are those found after a step, with their slopes from before it.
fn corrected(before: &[LinearValue], after: &[LinearValue], step: &[f64]) -> Vec<LinearValue> {
    let pairs = before.iter().zip(after);
    let one = |(before, after): (&LinearValue, &LinearValue)| LinearValue {
        value: after.value - dot(&before.gradient, step),
        ..before.clone()
    };
    pairs.map(one).collect()
}

/// Coordinates p, δx = W p, in which |p|² is the mean square change of ln|d| over the data, and the curvature of the
/// Lagrangian of the errors that bound at the step before, without its negative part. `None` when eigenvalues fail.
fn coordinates(
    data: &Magnitudes,
    fit: &Factors,
    binding: &[(usize, f64)],
) -> Option<(Mat<f64>, Curvature)> {
    let n = fit.parameters().len();
    let count = data.omega_rad_s.len() as f64;
    let mut metric = Mat::from_fn(n, n, |i, j| if i == j { OWN * OWN } else { 0.0 });
    for w in &data.omega_rad_s {
        let (_, g) = fit.ln_magnitude_with_gradient(*w);
        for i in 0..n {
            for j in 0..n {
                metric[(i, j)] += g[i] * g[j] / count;
            }
        }
    }
    let (values, vectors) = symmetric_eigen(&metric).ok()?;
    let whiten = Mat::from_fn(n, n, |i, k| vectors[(i, k)] / values[k].sqrt());
    if binding.is_empty() {
        return Some((whiten, Curvature::default()));
    }
    let mut hessian = Mat::zeros(n, n);
    for (k, share) in binding {
        let (point, sign) = (k / 2, if k % 2 == 0 { 1.0 } else { -1.0 });
        let weight = sign * share * data.weight[point];
        fit.add_second_derivatives(data.omega_rad_s[point], weight, &mut hessian);
    }
    let (bends, turns) = symmetric_eigen(&(whiten.transpose() * hessian * &whiten)).ok()?;
    // With Z = W⁻ᵀU the matrix is Z diag(bends) Zᵀ.
    let back = Mat::from_fn(n, n, |i, k| vectors[(i, k)] * values[k].sqrt()) * turns;
    let curved = Mat::from_fn(n, n, |i, k| back[(i, k)] * bends[k].max(0.0)) * back.transpose();
    Some((whiten, Curvature::of(curved)))
}
