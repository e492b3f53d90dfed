//! One step of the prox-linear method for a largest value under limits (Fletcher 1982; Drusvyatskiy and Paquette 2019):
//!
//!   minimise over p, t, s ≥ 0:   t + ρ Σ_g s_g + (λ/2)|p|²,   v_k + g_kᵀp ≤ t (objective),   v_k + g_kᵀp ≤ s_g
//!   (limits).
//!
//! A convex quadratic programme, solved by clarabel in its dual form.

use super::lmi::{ProgrammeError, QuadraticProgramme, Row};
use crate::linalg::Mat;
use crate::linalg::dense::dot;

/// A value with its linearisation.
#[derive(Clone, Debug)]
pub struct LinearValue {
    /// `None`: part of the objective. Some(g): limit of group g, asked to be at most zero.
    pub limit: Option<usize>,
    /// v.
    pub value: f64,
    /// g, one entry per coordinate of p.
    pub gradient: Vec<f64>,
}

/// Penalties of a step.
#[derive(Clone, Copy, Debug)]
pub struct StepRule {
    /// Number of limits.
    pub limits: usize,
    /// ρ.
    pub penalty: f64,
    /// λ.
    pub proximal: f64,
}

/// A step with what the linear model promises.
#[derive(Clone, Debug)]
pub struct MinimaxStep {
    /// p.
    pub step: Vec<f64>,
    /// t + ρ Σ s at the step, without the proximal term.
    pub predicted: f64,
    /// Numbers and weights y of the values that bind: p = −Σ y g/λ.
    pub binding: Vec<(usize, f64)>,
}

/// Values of the first programme, and those that join at most when a step violates more.
const FIRST_VALUES: usize = 40;
const JOINING: usize = 24;
/// What a value left out may exceed its level by: values are logarithms, and a step is judged by its fourth digit.
const VIOLATION: f64 = 1e-7;
/// A value with a smaller weight does not bind.
const BINDS: f64 = 1e-6;

/// The step for `values`; those of the numbers `likely` are expected to bind.
///
/// Few of the values bind at a step. The programme is solved with the largest ones and the likely ones; those that its
/// step would lift above their level join until there are none, which is the solution with all of them.
///
/// # Errors
/// [`ProgrammeError`] when the interior-point iteration breaks down.
pub fn minimax_step(
    values: &[LinearValue],
    likely: &[usize],
    rule: &StepRule,
) -> Result<MinimaxStep, ProgrammeError> {
    let levels_at_start = levels(values, rule.limits, |v| v.value);
    let merit = |levels: &[f64]| {
        let level = if levels[0].is_finite() {
            levels[0]
        } else {
            0.0
        };
        level + rule.penalty * levels[1..].iter().sum::<f64>()
    };
    let below = |k: &usize| levels_at_start[group(&values[*k])] - values[*k].value;
    let (mut taken, mut left): (Vec<usize>, Vec<usize>) =
        (0..values.len()).partition(|k| likely.contains(k));
    left.sort_by(|a, b| below(a).total_cmp(&below(b)));
    let further = FIRST_VALUES.saturating_sub(taken.len()).max(JOINING);
    taken.extend(left.drain(..further.min(left.len())));
    loop {
        let chosen: Vec<&LinearValue> = taken.iter().map(|k| &values[*k]).collect();
        let (step, weights) = restricted(&chosen, rule)?;
        let after = |v: &LinearValue| v.value + dot(&v.gradient, &step);
        let reached = levels(chosen.iter().copied(), rule.limits, after);
        let mut violated: Vec<(f64, usize)> = left
            .iter()
            .map(|k| (after(&values[*k]) - reached[group(&values[*k])], *k))
            .filter(|(above, _)| *above > VIOLATION)
            .collect();
        if violated.is_empty() {
            let binding = taken.into_iter().zip(weights);
            return Ok(MinimaxStep {
                predicted: merit(&levels(values, rule.limits, after)),
                step,
                binding: binding.filter(|(_, weight)| *weight > BINDS).collect(),
            });
        }
        violated.sort_by(|a, b| b.0.total_cmp(&a.0));
        violated.truncate(JOINING);
        taken.extend(violated.iter().map(|(_, k)| *k));
        left.retain(|k| !taken.contains(k));
    }
}

/// 0 for the objective, 1 + g for limit g.
fn group(value: &LinearValue) -> usize {
    value.limit.map_or(0, |g| 1 + g)
}

/// Largest value of each group; limits count from zero.
fn levels<'a>(
    values: impl IntoIterator<Item = &'a LinearValue>,
    limits: usize,
    of: impl Fn(&LinearValue) -> f64,
) -> Vec<f64> {
    let mut found = vec![0.0; 1 + limits];
    found[0] = f64::NEG_INFINITY;
    for value in values {
        let level = &mut found[group(value)];
        *level = level.max(of(value));
    }
    found
}

/// The step for some of the values, and their weights.
///
/// The dual has one variable per value, the weight y_k ≥ 0 of its slope in the step p = −Σ y_k g_k/λ:
///   minimise |Σ y_k g_k|²/2λ − Σ v_k y_k,   Σ y = 1 over the objective,   Σ y ≤ ρ over each limit.
/// Its matrix is as small as the number of values, the primal one has as many rows and all coordinates besides.
fn restricted(
    values: &[&LinearValue],
    rule: &StepRule,
) -> Result<(Vec<f64>, Vec<f64>), ProgrammeError> {
    let (n, m) = (values.first().map_or(0, |v| v.gradient.len()), values.len());
    let sum_over = |limit: Option<usize>, bound: f64| Row {
        terms: (0..m)
            .filter(|k| values[*k].limit == limit)
            .map(|k| (k, 1.0))
            .collect(),
        bound,
    };
    let kept = |row: &Row| !row.terms.is_empty();
    let not_negative = (0..m).map(|k| Row {
        terms: vec![(k, -1.0)],
        bound: 0.0,
    });
    let groups = (0..rule.limits).map(|g| sum_over(Some(g), rule.penalty));
    let programme = QuadraticProgramme {
        quadratic: Mat::from_fn(m, m, |i, j| match i <= j {
            true => dot(&values[i].gradient, &values[j].gradient) / rule.proximal,
            false => 0.0,
        }),
        objective: values.iter().map(|v| -v.value).collect(),
        // Without an objective the level is free and costs nothing.
        equalities: Some(sum_over(None, 1.0)).into_iter().filter(kept).collect(),
        inequalities: groups.filter(kept).chain(not_negative).collect(),
    };
    let weights = programme.solve()?;
    let mut step = vec![0.0; n];
    for (v, weight) in values.iter().zip(&weights) {
        for (p, g) in step.iter_mut().zip(&v.gradient) {
            *p -= weight * g / rule.proximal;
        }
    }
    Ok((step, weights))
}
