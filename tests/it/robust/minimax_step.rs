//! The step of the polish: a convex programme, so that no neighbour of its solution may be better.

use muspin::robust::minimax::step::{LinearValue, StepRule, minimax_step};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const LIMITS: usize = 3;
const PENALTY: f64 = 8.0;

fn rule(proximal: f64) -> StepRule {
    StepRule { limits: LIMITS, penalty: PENALTY, proximal }
}

/// t + ρ Σ s at a point, without the proximal term.
fn merit(values: &[LinearValue], p: &[f64]) -> f64 {
    let at = |v: &LinearValue| v.value + v.gradient.iter().zip(p).map(|(g, x)| g * x).sum::<f64>();
    let largest = |limit: Option<usize>| {
        let of = values.iter().filter(|v| v.limit == limit);
        of.map(&at).fold(f64::NEG_INFINITY, f64::max)
    };
    let limits: f64 = (0..LIMITS).map(|g| largest(Some(g)).max(0.0)).sum();
    let level = largest(None);
    PENALTY * limits + if level.is_finite() { level } else { 0.0 }
}

fn random_values(seed: u64, count: usize, n: usize, objective: bool) -> Vec<LinearValue> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|k| LinearValue {
            limit: match (k % (LIMITS + 1), objective) {
                (0, true) => None,
                (0, false) => Some(0),
                (g, _) => Some(g - 1),
            },
            // Values crowd just below their largest, as the lines round a peak do.
            value: -random.random::<f64>().powi(3),
            gradient: (0..n).map(|_| random.random::<f64>() - 0.5).collect(),
        })
        .collect()
}

#[test]
fn two_opposed_slopes_meet_where_the_closed_form_says() {
    // max(1 + p, −p) + (λ/2)p²: the kink at −1/2 as long as λ/2 is below the slope.
    let value = |value, slope| LinearValue { limit: None, value, gradient: vec![slope] };
    let found = minimax_step(&[value(1.0, 1.0), value(0.0, -1.0)], &[], &rule(0.1)).unwrap();
    assert!((found.step[0] + 0.5).abs() < 1e-6, "{found:?}");
    assert!((found.predicted - 0.5).abs() < 1e-6, "{found:?}");
    // One slope alone: p = −g/λ.
    let found = minimax_step(&[value(1.0, 1.0)], &[], &rule(2.0)).unwrap();
    assert!((found.step[0] + 0.5).abs() < 1e-6, "{found:?}");
}

#[test]
fn no_neighbour_of_the_step_is_better_over_all_values() {
    for (seed, objective) in [(1, true), (2, true), (3, false)] {
        // Far more values than the first programme takes.
        let values = random_values(seed, 300, 12, objective);
        let proximal = 0.5;
        let found = minimax_step(&values, &[], &rule(proximal)).unwrap();
        let total = |p: &[f64]| merit(&values, p) + 0.5 * proximal * p.iter().map(|x| x * x).sum::<f64>();
        let least = total(&found.step);
        let own = merit(&values, &found.step);
        assert!((found.predicted - own).abs() < 1e-6, "{} and {own}", found.predicted);
        let mut random = ChaCha8Rng::seed_from_u64(seed + 100);
        for size in [1e-4, 1e-3, 1e-2, 0.1] {
            for _ in 0..500 {
                let near: Vec<f64> = found.step.iter().map(|x| x + size * (random.random::<f64>() - 0.5)).collect();
                // The interior-point iteration ends with a gap of 1e-8 and the left-out values at 1e-7.
                assert!(total(&near) > least - 2e-6, "seed {seed}, size {size}");
            }
        }
    }
}

#[test]
fn values_expected_to_bind_do_not_change_the_step_and_the_weights_are_those_of_its_slopes() {
    for seed in [4, 5] {
        let values = random_values(seed, 300, 12, true);
        let total = |p: &[f64]| merit(&values, p) + 0.25 * p.iter().map(|x| x * x).sum::<f64>();
        let best = minimax_step(&values, &[], &rule(0.5)).unwrap();
        let weights: f64 = best.binding.iter().map(|(_, weight)| weight).sum();
        assert!(best.binding.len() <= 13 && weights >= 1.0 - 1e-6, "{best:?}");
        // The weights are those of the step: p = −Σ y g/λ.
        for (i, p) in best.step.iter().enumerate() {
            let of = best.binding.iter();
            let sum: f64 = of.map(|(k, y)| y * values[*k].gradient[i]).sum();
            assert!((p + sum / 0.5).abs() < 1e-3, "{p} and {}", -sum / 0.5);
        }
        let numbers: Vec<usize> = best.binding.iter().map(|(k, _)| *k).collect();
        let again = minimax_step(&values, &numbers, &rule(0.5)).unwrap();
        assert!((total(&again.step) - total(&best.step)).abs() < 1e-6);
    }
}

/// Least value of the dual programme, by weights y: −|Σ y g|²/2λ + Σ v y is below every value of the primal one.
fn dual(values: &[LinearValue], binding: &[(usize, f64)], proximal: f64) -> f64 {
    let n = values[0].gradient.len();
    let sum = |i: usize| -> f64 {
        let parts = binding.iter().map(|(k, y)| y * values[*k].gradient[i]);
        parts.sum()
    };
    let square: f64 = (0..n).map(|i| sum(i).powi(2)).sum();
    let linear: f64 = binding.iter().map(|(k, y)| y * values[*k].value).sum();
    linear - square / (2.0 * proximal)
}

#[test]
fn the_weights_prove_that_no_step_is_better() {
    for seed in 10..30 {
        let objective = seed % 3 != 0;
        let mut values = random_values(seed, 240, 94, objective);
        // Lines beside each other have nearly the same slopes, and some are there twice.
        for k in 0..values.len() - 8 {
            if k % 8 < 4 {
                let mut twin = values[k + 4].clone();
                twin.value = values[k].value;
                twin.gradient.iter_mut().for_each(|g| *g *= 1.0 + 1e-9 * (k % 3) as f64);
                values[k] = twin;
            }
        }
        let proximal = 10f64.powi(seed as i32 % 5 - 3);
        let found = minimax_step(&values, &[3, 17, 40], &rule(proximal)).unwrap();
        let square: f64 = found.step.iter().map(|p| p * p).sum();
        let primal = merit(&values, &found.step) + 0.5 * proximal * square;
        let below = dual(&values, &found.binding, proximal);
        let sums = |limit: Option<usize>| -> f64 {
            let of = found.binding.iter().filter(|(k, _)| values[*k].limit == limit);
            of.map(|(_, y)| y).sum()
        };
        assert!(found.binding.iter().all(|(_, y)| *y >= 0.0));
        assert!((0..LIMITS).all(|g| sums(Some(g)) <= PENALTY * (1.0 + 1e-9)));
        assert!(!objective || (sums(None) - 1.0).abs() < 1e-4, "{}", sums(None));
        // What does not bind by less than 1e-6 is left out of the list.
        assert!((primal - below).abs() < 1e-3, "seed {seed}: {primal} and {below}");
    }
}

#[test]
fn no_values_ask_for_no_step() {
    let found = minimax_step(&[], &[], &rule(0.5)).unwrap();
    assert!(found.step.is_empty() && found.binding.is_empty());
}
