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
pub(crate) struct LinearValue {
    /// `None`: part of the objective. Some(g): limit of group g, asked to be at most zero.
    pub limit: Option<usize>,
    /// v.
    pub value: f64,
    /// g, one entry per coordinate of p.
    pub gradient: Vec<f64>,
}

/// A step with what the linear model promises.
#[derive(Clone, Debug)]
pub(crate) struct MinimaxStep {
    /// p.
    pub step: Vec<f64>,
    /// t + ρ Σ s at the step, without the proximal term.
    pub predicted: f64,
}

/// The step for `values` with `limits` groups, penalty ρ and proximal weight λ.
///
/// # Errors
/// [`ProgrammeError`] when the interior-point iteration breaks down.
pub(crate) fn minimax_step(
    values: &[LinearValue],
    limits: usize,
    penalty: f64,
    proximal: f64,
) -> Result<MinimaxStep, ProgrammeError> {
    let n = values.first().map_or(0, |v| v.gradient.len());
    let (level, slack) = (n, n + 1);
    let mut objective = vec![0.0; n + 1 + limits];
    // Without an objective the level is free and costs nothing.
    if values.iter().any(|v| v.limit.is_none()) {
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
    let end = programme.solve()?;
    let (step, levels) = end.split_at(n);
    let slacks: f64 = levels[1..].iter().map(|s| s.max(0.0)).sum();
    Ok(MinimaxStep {
        predicted: programme.objective[level] * levels[0] + penalty * slacks,
        step: step.to_vec(),
    })
}
