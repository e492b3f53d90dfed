//! Descent on γ itself: the optimal H∞ level of D P D⁻¹ as a function of the poles, zeros and gains of D(s).
//!
//! D-K alternation creeps along a valley and its fits lose part of each step. γ_opt(D) bounds μ of the next loop, is
//! smooth in the logarithms of the parameters but for kinks where the binding condition changes, and costs a synthesis
//! without a controller. BFGS with forward differences goes down the valley directly; it is safe at kinks (Lewis and
//! Overton 2013). A failed synthesis counts as an infinite level, which the line search steps back from.

use super::scale::DScales;
use crate::augment::GeneralizedPlant;
use crate::linalg::dense::dot;
use crate::robust::dfit::factors::{Factors, Limits};
use crate::robust::hinf::{HinfSettings, optimal_level};
use crate::robust::structure::Structure;
use rayon::prelude::*;

/// The problem and the ranges that the scales must keep.
pub(crate) struct Descent<'a> {
    /// Generalized plant without scales.
    pub plant: &'a GeneralizedPlant,
    /// Its blocks.
    pub structure: &'a Structure,
    /// Ranges of corner frequencies and damping ratios.
    pub limits: Limits,
}

/// Step of the forward differences: γ is found to 1e-9, so a derivative carries six digits less its own curvature.
const DIFFERENCE: f64 = 1e-3;
/// A line search goes on while the slope along it is steeper than this share of that at its start (Wolfe's condition,
/// which a kink does not spoil), and ends after so many trials.
const CURVED: f64 = 0.5;
const TRIALS: usize = 10;

impl Descent<'_> {
    /// Scales with another list of parameters.
    fn at(&self, start: &DScales, parameters: &[f64]) -> DScales {
        let mut next = start.clone();
        let last = next.factors.len().saturating_sub(1);
        let mut first = 0;
        for factors in &mut next.factors[..last] {
            let count = factors.parameters().len();
            *factors = factors.with_parameters(&parameters[first..first + count], &self.limits);
            first += count;
        }
        next
    }

    /// ln γ_opt; infinite when the synthesis fails.
    pub(crate) fn ln_level(&self, scales: &DScales, hint: Option<f64>) -> f64 {
        let settings = HinfSettings {
            rel_tol: 1e-9,
            hint,
            ..HinfSettings::default()
        };
        let scaled = scales.scaled_plant(self.plant, self.structure);
        let level = scaled.map_or(f64::INFINITY, |p| {
            optimal_level(&p, &settings).unwrap_or(f64::INFINITY)
        });
        if level > 0.0 {
            level.ln()
        } else {
            f64::INFINITY
        }
    }

    /// Goes down for at most `rounds` gradients or until γ is below `enough`. Returns the scales and their γ_opt.
    pub(crate) fn run(&self, start: &DScales, rounds: usize, enough: f64) -> (DScales, f64) {
        let last = start.factors.len().saturating_sub(1);
        let mut x: Vec<f64> = start.factors[..last]
            .iter()
            .flat_map(Factors::parameters)
            .collect();
        let n = x.len();
        let mut value = self.ln_level(start, None);
        if n == 0 || !value.is_finite() {
            return (start.clone(), value.exp());
        }
        let evaluate = |x: &[f64], near: f64| self.ln_level(&self.at(start, x), Some(near.exp()));
        let gradient = |x: &[f64], value: f64| -> Vec<f64> {
            (0..n)
                .into_par_iter()
                .map(|k| {
                    let mut moved = x.to_vec();
                    moved[k] += DIFFERENCE;
                    let slope = (evaluate(&moved, value) - value) / DIFFERENCE;
                    if slope.is_finite() { slope } else { 0.0 }
                })
                .collect()
        };
        let mut g = gradient(&x, value);
        let mut inverse = scaled_identity(n, 1.0);
        let mut fresh = true;
        for _ in 0..rounds {
            if value.exp() < enough {
                break;
            }
            let mut step: Vec<f64> = inverse.iter().map(|row| -dot(row, &g)).collect();
            if fresh || dot(&step, &g) >= 0.0 {
                inverse = scaled_identity(n, 1.0);
                step = g.iter().map(|v| -v).collect();
                // The first step along the gradient: a fifth of an octave in its largest entry.
                let largest = step.iter().fold(1e-300f64, |m, v| m.max(v.abs()));
                step.iter_mut().for_each(|v| *v *= 0.15 / largest);
            }
            let longest = step.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            // Corners move by at most a factor of e a step.
            let mut length = if longest > 1.0 { 1.0 / longest } else { 1.0 };
            let slope = dot(&step, &g);
            let along = |length: f64| -> Vec<f64> {
                x.iter().zip(&step).map(|(x, s)| x + length * s).collect()
            };
            let mut accepted: Option<(Vec<f64>, f64)> = None;
            let (mut short, mut long) = (0.0, f64::INFINITY);
            for _ in 0..TRIALS {
                let trial = along(length);
                let next = evaluate(&trial, value);
                if next < value + 1e-4 * length * slope {
                    if accepted.as_ref().is_none_or(|best| next < best.1) {
                        accepted = Some((trial, next));
                    }
                    let further = DIFFERENCE / longest;
                    let there = (evaluate(&along(length + further), next) - next) / further;
                    if there >= CURVED * slope || length * longest >= 1.0 {
                        break;
                    }
                    short = length;
                } else {
                    long = length;
                }
                length = match long.is_finite() {
                    true => short + 0.35 * (long - short),
                    false => (2.0 * short).min(1.0 / longest),
                };
            }
            let Some((trial, next)) = accepted else {
                if fresh {
                    break;
                }
                fresh = true;
                continue;
            };
            let next_gradient = gradient(&trial, next);
            let s: Vec<f64> = trial.iter().zip(&x).map(|(a, b)| a - b).collect();
            let y: Vec<f64> = next_gradient.iter().zip(&g).map(|(a, b)| a - b).collect();
            let sy = dot(&s, &y);
            if sy > 1e-12 {
                if fresh {
                    inverse = scaled_identity(n, sy / dot(&y, &y));
                }
                update(&mut inverse, &s, &y, sy);
                fresh = false;
            }
            let settled = value - next < 2e-6;
            (x, value, g) = (trial, next, next_gradient);
            if settled {
                break;
            }
        }
        (self.at(start, &x), value.exp())
    }
}

fn scaled_identity(n: usize, value: f64) -> Vec<Vec<f64>> {
    (0..n)
        .map(|i| (0..n).map(|j| if i == j { value } else { 0.0 }).collect())
        .collect()
}

/// H ← (I − syᵀ/sᵀy) H (I − ysᵀ/sᵀy) + ssᵀ/sᵀy.
fn update(inverse: &mut [Vec<f64>], s: &[f64], y: &[f64], sy: f64) {
    let hy: Vec<f64> = inverse.iter().map(|row| dot(row, y)).collect();
    let scale = (1.0 + dot(y, &hy) / sy) / sy;
    for (i, row) in inverse.iter_mut().enumerate() {
        for (j, v) in row.iter_mut().enumerate() {
            *v += scale * s[i] * s[j] - (hy[i] * s[j] + s[i] * hy[j]) / sy;
        }
    }
}
