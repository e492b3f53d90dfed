//! One step of the prox-linear method for a largest value under limits (Fletcher 1982; Drusvyatskiy and Paquette 2019):
//!
//!   minimise over p, t, s ≥ 0:   t + ρ Σ_g s_g + (λ/2)|p|²,   v_k + g_kᵀp ≤ t (objective),   v_k + g_kᵀp ≤ s_g
//!   (limits).
//!
//! A convex quadratic programme of as many variables as p has, and a few more; clarabel solves it.

use super::lmi::ProgrammeError;
use super::lmi::{QuadraticProgramme, Row};

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

/// A step with what the linear model promises.
#[derive(Clone, Debug)]
pub struct MinimaxStep {
    /// p.
    pub step: Vec<f64>,
    /// t + ρ Σ s at the step, without the proximal term.
    pub predicted: f64,
}

/// Values of the first programme, and those that join at most when a step violates more.
const FIRST_VALUES: usize = 40;
const JOINING: usize = 24;
/// What a value left out may exceed its level by: values are logarithms, and a step is judged by its fourth digit.
const VIOLATION: f64 = 1e-7;

/// The step for `values` with `limits` groups, penalty ρ and proximal weight λ.
///
/// Few of the values bind at a step. The programme is solved with the largest ones; those that its step would lift
/// above their level join until there are none, which is the solution with all of them.
///
/// # Errors
/// [`ProgrammeError`] when the interior-point iteration breaks down.
pub fn minimax_step(
    values: &[LinearValue],
    limits: usize,
    penalty: f64,
    proximal: f64,
) -> Result<MinimaxStep, ProgrammeError> {
    let levels_at_start = levels(values, limits, |v| v.value);
    let mut order: Vec<usize> = (0..values.len()).collect();
    let below = |k: &usize| levels_at_start[group(&values[*k])] - values[*k].value;
    order.sort_by(|a, b| below(a).total_cmp(&below(b)));
    let mut left = order.split_off(order.len().min(FIRST_VALUES));
    let mut taken = order;
    loop {
        let chosen: Vec<&LinearValue> = taken.iter().map(|k| &values[*k]).collect();
        let (step, reached) = restricted(&chosen, limits, penalty, proximal)?;
        let after = |v: &LinearValue| v.value + dot(&v.gradient, &step);
        let mut violated: Vec<(f64, usize)> = left
            .iter()
            .map(|k| (after(&values[*k]) - reached[group(&values[*k])], *k))
            .filter(|(above, _)| *above > VIOLATION)
            .collect();
        if violated.is_empty() {
            let found = levels(values, limits, after);
            let slacks: f64 = found[1..].iter().sum();
            let level = if found[0].is_finite() { found[0] } else { 0.0 };
            return Ok(MinimaxStep {
                predicted: level + penalty * slacks,
                step,
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
fn levels(values: &[LinearValue], limits: usize, of: impl Fn(&LinearValue) -> f64) -> Vec<f64> {
    let mut found = vec![0.0; 1 + limits];
    found[0] = f64::NEG_INFINITY;
    for value in values {
        let level = &mut found[group(value)];
        *level = level.max(of(value));
    }
    found
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The step for some of the values, and the level of each group that it reaches; minus infinity for an
/// objective of which no value takes part, so that one that is left out joins.
fn restricted(
    values: &[&LinearValue],
    limits: usize,
    penalty: f64,
    proximal: f64,
) -> Result<(Vec<f64>, Vec<f64>), ProgrammeError> {
    let n = values.first().map_or(0, |v| v.gradient.len());
    let (level, slack) = (n, n + 1);
    let mut objective = vec![0.0; n + 1 + limits];
    // Without an objective the level is free and costs nothing.
    let with_objective = values.iter().any(|v| v.limit.is_none());
    if with_objective {
        objective[level] = 1.0;
    }
    for g in 0..limits {
        objective[slack + g] = penalty;
    }
    let mut inequalities: Vec<Row> = (0..limits)
        .map(|g| Row {
            terms: vec![(slack + g, -1.0)],
            bound: 0.0,
        })
        .collect();
    for v in values {
        let bounded = v.limit.map_or(level, |g| slack + g);
        let mut terms: Vec<(usize, f64)> = v.gradient.iter().copied().enumerate().collect();
        terms.push((bounded, -1.0));
        inequalities.push(Row {
            terms,
            bound: -v.value,
        });
    }
    let mut diagonal = vec![proximal; n];
    diagonal.resize(objective.len(), 0.0);
    let programme = QuadraticProgramme {
        diagonal,
        objective,
        inequalities,
    };
    let mut step = programme.solve()?;
    let mut reached = step.split_off(n);
    for slack in &mut reached[1..] {
        *slack = slack.max(0.0);
    }
    if !with_objective {
        reached[0] = f64::NEG_INFINITY;
    }
    Ok((step, reached))
}
