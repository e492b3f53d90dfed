//! Nonlinear minimax polish of a magnitude fit: prox-linear steps on the largest error, with the second derivatives of
//! the errors that bind.
//!
//!   minimise over the parameters   max over the data of  weight · |ln|d| − ln m|
//!
//! Where fewer errors bind than there are parameters, second derivatives decide how far a step goes along the rest. A
//! step that is refused is corrected once for the errors found at its end (Fletcher 1982).

use super::factors::Factors;
use super::magnitudes::Magnitudes;
use super::metric::Metric;
use crate::linalg::dense::dot;
use crate::linalg::{Mat, symmetric_eigen};
use crate::robust::minimax::curvature::Curvature;
use crate::robust::minimax::proximal::{HEAVIEST, after_refusal, after_step, is_accepted};
use crate::robust::minimax::step::{CurvedProgramme, LinearValue, MinimaxStep, StepRule};

/// Largest weighted |ln(|d|/m)|.
pub(crate) fn weighted_error(data: &Magnitudes, fit: &Factors) -> f64 {
    data.points()
        .map(|(w, m, weight)| weight * (fit.ln_magnitude(w) - m.ln()).abs())
        .fold(0.0, |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) })
}

/// A step that promises less than this share of the error ends a polish: what is left is far below what the shape of a
/// D-scale is known to.
const SETTLED: f64 = 1e-5;
/// Above this proximal weight, it may be the weight that keeps a promise small: it is lowered once.
const LIGHT: f64 = 1e-2;
/// Factor by which it is lowered.
const LIGHTER: f64 = 0.1;
/// Errors below this are smaller than anything a D-scale can show.
const EXACT: f64 = 1e-10;

/// Improves a fit by at most `steps` steps; the result keeps the limits and is never worse than the start moved into
/// them.
pub(crate) fn polish(data: &Magnitudes, start: Factors, steps: usize) -> Factors {
    let mut best = start.with_parameters(&start.parameters(), &data.limits);
    let mut error = weighted_error(data, &best);
    let mut rows = errors(data, &best);
    let mut metric = metric_of(data, &best);
    let mut binding: Vec<(usize, f64)> = vec![];
    let mut weight = 1.0;
    let mut lightened = false;
    for _ in 0..steps {
        if error < EXACT || weight > HEAVIEST {
            break;
        }
        let Some(measure) = &metric else {
            break;
        };
        let Some(curvature) = curvature(data, &best, &binding, measure) else {
            break;
        };
        let shape = (&measure.matrix, &curvature);
        let programme = scaled_programme(&rows, error, shape, weight);
        let first = programme.and_then(|programme| {
            let found = scaled_step(&programme, error, &binding)?;
            Some((programme, found))
        });
        let Some((mut programme, (step, predicted))) = first else {
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
            let seen = correct_step(&rows, &errors(data, &trial), &step.step);
            programme.revalue(seen.into_iter().map(|value| value / error));
            let again = scaled_step(&programme, error, &binding);
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
        let accepted = is_accepted(kept, promised);
        weight = match accepted {
            _ if held => LIGHTER * weight,
            true => after_step(weight, kept, promised),
            false => after_refusal(weight, kept > -promised),
        };
        if accepted {
            (best, error) = (trial, next);
            rows = errors(data, &best);
            metric = metric_of(data, &best);
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

/// The programme of a step for errors in units of the largest one and steps in units of its root, in which curvature
/// and weight are the same: its tolerances are absolute.
fn scaled_programme(
    rows: &[LinearValue],
    error: f64,
    shape: (&Mat<f64>, &Curvature),
    weight: f64,
) -> Option<CurvedProgramme> {
    let root = error.sqrt();
    let scaled = |row: &LinearValue| LinearValue {
        limit: None,
        value: row.value / error,
        gradient: row.gradient.iter().map(|g| g / root).collect(),
    };
    let scaled: Vec<LinearValue> = rows.iter().map(scaled).collect();
    let rule = StepRule { limits: 0, penalty: 0.0, proximal: weight };
    CurvedProgramme::new(&scaled, shape.0, shape.1, &rule)
}

/// The step of a [`scaled_programme`] and the error that the linear model predicts.
fn scaled_step(programme: &CurvedProgramme, error: f64, binding: &[(usize, f64)]) -> Option<(MinimaxStep, f64)> {
    let likely: Vec<usize> = binding.iter().map(|(k, _)| *k).collect();
    let mut found = programme.step(&likely)?;
    let root = error.sqrt();
    found.step.iter_mut().for_each(|s| *s *= root);
    let predicted = found.predicted * error;
    Some((found, predicted))
}

/// Errors before a step for which the linear model gives those found after it.
fn correct_step(before: &[LinearValue], after: &[LinearValue], step: &[f64]) -> Vec<f64> {
    let pairs = before.iter().zip(after);
    let pairs = pairs.map(|(before, after)| after.value - dot(&before.gradient, step));
    pairs.collect()
}

/// Metric of the parameters over the data.
fn metric_of(data: &Magnitudes, fit: &Factors) -> Option<Metric> {
    Metric::new(fit, &data.omega_rad_s)
}

/// Curvature of the Lagrangian of the errors that bound at the step before, without its negative part; none before the
/// first step. `None` when eigenvalues fail.
fn curvature(data: &Magnitudes, fit: &Factors, binding: &[(usize, f64)], metric: &Metric) -> Option<Curvature> {
    if binding.is_empty() {
        return Some(Curvature::default());
    }
    let n = metric.values.len();
    let mut hessian = Mat::zeros(n, n);
    for (k, share) in binding {
        let (point, sign) = (k / 2, if k % 2 == 0 { 1.0 } else { -1.0 });
        let weight = sign * share * data.weight[point];
        fit.add_second_derivatives(data.omega_rad_s[point], weight, &mut hessian);
    }
    let whiten = &metric.whitening;
    let (bends, turns) = symmetric_eigen(&(whiten.transpose() * hessian * whiten)).ok()?;
    // With Z = W⁻ᵀU the matrix is Z diag(bends) Zᵀ.
    let root = |k: usize| metric.values[k].sqrt();
    let back = Mat::from_fn(n, n, |i, k| metric.vectors[(i, k)] * root(k)) * turns;
    let curved = Mat::from_fn(n, n, |i, k| back[(i, k)] * bends[k].max(0.0)) * back.transpose();
    Some(Curvature::of(curved))
}
