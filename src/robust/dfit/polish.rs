//! Nonlinear minimax polish of a magnitude fit: sequential linear programmes in a trust region.
//!
//!   minimise e  subject to  wᵢ|rᵢ + Jᵢδ| ≤ e,  |δ| ≤ Δ,    r = ln|d| − ln m
//!
//! At a minimax solution with as many active points as parameters the convergence is quadratic.

use super::exchange::{Chosen, Exchange};
use super::factors::Factors;
use super::magnitudes::Magnitudes;
use crate::robust::mu::lmi::Row;

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

/// Improves a fit for at most `rounds` programmes; the result keeps the limits and is never worse than the start moved
/// into them.
pub(crate) fn polish(data: &Magnitudes, start: Factors, rounds: usize) -> Factors {
    let mut best = start.with_parameters(&start.parameters(), &data.limits);
    let mut error = weighted_error(data, &best);
    let mut radius: f64 = 0.5;
    let mut binding: Chosen = vec![];
    for _ in 0..rounds {
        // Errors of 1e-10 are below anything a D-scale can show.
        if error < 1e-10 || radius < 1e-7 {
            break;
        }
        let Some((step, predicted)) = linear_step(data, &best, (error, radius), &mut binding)
        else {
            radius *= 0.25;
            continue;
        };
        let values: Vec<f64> = best
            .parameters()
            .iter()
            .zip(&step)
            .map(|(p, s)| p + s)
            .collect();
        let trial = best.with_parameters(&values, &data.limits);
        let next = weighted_error(data, &trial);
        let gain = (error - next) / (error - predicted).max(1e-300);
        let settled = error - predicted < SETTLED * error;
        if next < error {
            (best, error) = (trial, next);
        }
        if settled {
            break;
        }
        if gain > 0.7 {
            radius = (2.0 * radius).min(2.0);
        } else if gain < 0.2 {
            radius *= 0.3;
        }
    }
    best
}

/// The step of the linear model and the error that it predicts.
fn linear_step(
    data: &Magnitudes,
    fit: &Factors,
    (error, radius): (f64, f64),
    binding: &mut Chosen,
) -> Option<(Vec<f64>, f64)> {
    let count = fit.parameters().len();
    let mut curves = [vec![], vec![]];
    for (w, m, weight) in data.points() {
        let (value, gradient) = fit.ln_magnitude_with_gradient(w);
        let residual = (value - m.ln()) * weight / error;
        for (sign, curve) in [1.0, -1.0].into_iter().zip(&mut curves) {
            let slopes = gradient.iter().map(|g| sign * g * weight * radius / error);
            let mut terms: Vec<(usize, f64)> = slopes.enumerate().collect();
            terms.push((count, -1.0));
            curve.push(Row {
                terms,
                bound: -sign * residual,
            });
        }
    }
    let mut always = vec![];
    for k in 0..count {
        for sign in [1.0, -1.0] {
            always.push(Row {
                terms: vec![(k, sign)],
                bound: 1.0,
            });
        }
    }
    let mut objective = vec![0.0; count + 1];
    objective[count] = 1.0;
    let programme = Exchange {
        objective,
        always,
        curves: curves.into(),
    };
    let (end, next) = programme.solve(binding).ok()?;
    *binding = next;
    let predicted = end.x[count] * error;
    (predicted < error).then(|| {
        (
            end.x[..count].iter().map(|v| v * radius).collect(),
            predicted,
        )
    })
}
