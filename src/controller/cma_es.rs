//! Covariance matrix adaptation evolution strategy: minimises a function without derivatives.
//! Hansen, "The CMA evolution strategy: a tutorial" (arXiv:1604.00772), figure 6, with its default constants.
//! Symbols: m mean, σ step, C covariance, p_σ and p_c evolution paths, μ_w effective parents. The population is
//! evaluated in parallel and ordered afterwards, so the result depends on the seed alone.

use crate::linalg::{Mat, NumericError, symmetric_eigen};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Settings of a run.
#[derive(Clone, Copy, Debug)]
pub struct CmaSettings {
    /// Points per generation; at least 4.
    pub population: usize,
    /// Generations at most.
    pub generations: usize,
    /// Initial step in every coordinate.
    pub step: f64,
    /// Seed.
    pub seed: u64,
    /// The run ends when σ times the largest standard deviation falls below this.
    pub tolerance: f64,
    /// The run ends when the best value is at or below this; −∞ for never.
    pub target: f64,
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct CmaOutcome {
    /// Best point seen.
    pub point: Vec<f64>,
    /// Its value.
    pub value: f64,
    /// Evaluations of the function.
    pub evaluations: usize,
}

/// Minimises `function` from `start`; `progress` gets generation and best value. NaN counts as infinite.
///
/// # Errors
/// [`NumericError`] when the eigendecomposition of the covariance fails.
pub fn minimise(
    function: &(dyn Fn(&[f64]) -> f64 + Sync),
    start: &[f64],
    settings: &CmaSettings,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<CmaOutcome, NumericError> {
    let (n, lambda) = (start.len(), settings.population.max(4));
    let nf = n as f64;
    let parents = lambda / 2;
    let raw: Vec<f64> = (0..parents)
        .map(|i| (0.5 * (lambda as f64 + 1.0)).ln() - (i as f64 + 1.0).ln())
        .collect();
    let total: f64 = raw.iter().sum();
    let weights: Vec<f64> = raw.iter().map(|w| w / total).collect();
    let mu = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
    let cc = (4.0 + mu / nf) / (nf + 4.0 + 2.0 * mu / nf);
    let cs = (mu + 2.0) / (nf + mu + 5.0);
    let c1 = 2.0 / ((nf + 1.3).powi(2) + mu);
    let cmu = (1.0 - c1).min(2.0 * (mu - 2.0 + 1.0 / mu) / ((nf + 2.0).powi(2) + mu));
    let damping = 1.0 + 2.0 * (((mu - 1.0) / (nf + 1.0)).sqrt() - 1.0).max(0.0) + cs;
    let expected = nf.sqrt() * (1.0 - 1.0 / (4.0 * nf) + 1.0 / (21.0 * nf * nf));

    let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
    let (mut mean, mut sigma) = (start.to_vec(), settings.step);
    let mut covariance = Mat::<f64>::identity(n, n);
    let (mut ps, mut pc) = (vec![0.0; n], vec![0.0; n]);
    let value_of = |x: &[f64]| {
        let value = function(x);
        if value.is_nan() { f64::INFINITY } else { value }
    };
    let (mut best, mut best_value) = (start.to_vec(), value_of(start));
    let mut evaluations = 1;
    for generation in 0..settings.generations {
        let (variances, axes) = symmetric_eigen(&covariance)?;
        // Rounding may leave a variance below zero; the floor keeps the ellipsoid full.
        let deviations: Vec<f64> = variances.iter().map(|v| v.max(1e-20).sqrt()).collect();
        let steps: Vec<Vec<f64>> = (0..lambda)
            .map(|_| {
                let z: Vec<f64> = (0..n).map(|_| normal(&mut random)).collect();
                (0..n)
                    .map(|i| (0..n).map(|k| axes[(i, k)] * deviations[k] * z[k]).sum())
                    .collect()
            })
            .collect();
        let points: Vec<Vec<f64>> = steps
            .iter()
            .map(|s| mean.iter().zip(s).map(|(m, s)| m + sigma * s).collect())
            .collect();
        let values: Vec<f64> = points.par_iter().map(|x| value_of(x)).collect();
        evaluations += lambda;
        let mut order: Vec<usize> = (0..lambda).collect();
        order.sort_by(|i, j| values[*i].total_cmp(&values[*j]));
        if values[order[0]] < best_value {
            best_value = values[order[0]];
            best.clone_from(&points[order[0]]);
        }
        progress(generation, best_value);
        let shift: Vec<f64> = (0..n)
            .map(|k| {
                weights
                    .iter()
                    .zip(&order)
                    .map(|(w, i)| w * steps[*i][k])
                    .sum()
            })
            .collect();
        mean = (0..n).map(|k| mean[k] + sigma * shift[k]).collect();
        // C^(−1/2)·shift
        let along: Vec<f64> = (0..n)
            .map(|k| (0..n).map(|i| axes[(i, k)] * shift[i]).sum::<f64>() / deviations[k])
            .collect();
        for i in 0..n {
            let whitened: f64 = (0..n).map(|k| axes[(i, k)] * along[k]).sum();
            ps[i] = (1.0 - cs) * ps[i] + (cs * (2.0 - cs) * mu).sqrt() * whitened;
        }
        let length = ps.iter().map(|p| p * p).sum::<f64>().sqrt();
        let decay = (1.0 - (1.0 - cs).powi(2 * (generation as i32 + 1))).sqrt();
        let h = if length / decay < (1.4 + 2.0 / (nf + 1.0)) * expected {
            1.0
        } else {
            0.0
        };
        for k in 0..n {
            pc[k] = (1.0 - cc) * pc[k] + h * (cc * (2.0 - cc) * mu).sqrt() * shift[k];
        }
        covariance = Mat::from_fn(n, n, |i, j| {
            let rank_mu: f64 = weights
                .iter()
                .zip(&order)
                .map(|(w, k)| w * steps[*k][i] * steps[*k][j])
                .sum();
            let keep = 1.0 - c1 - cmu + (1.0 - h) * c1 * cc * (2.0 - cc);
            keep * covariance[(i, j)] + c1 * pc[i] * pc[j] + cmu * rank_mu
        });
        sigma *= ((cs / damping) * (length / expected - 1.0)).exp();
        let widest = deviations.iter().fold(0.0f64, |a, b| a.max(*b));
        let done = best_value <= settings.target || !sigma.is_finite();
        if done || sigma * widest <= settings.tolerance {
            break;
        }
    }
    Ok(CmaOutcome {
        point: best,
        value: best_value,
        evaluations,
    })
}

/// Standard normal deviate (Box and Muller).
fn normal(random: &mut ChaCha8Rng) -> f64 {
    let u: f64 = 1.0 - random.random::<f64>();
    let v: f64 = random.random();
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}
