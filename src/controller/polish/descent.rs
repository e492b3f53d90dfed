//! Descent on a largest value under limits: prox-linear steps with an adaptive proximal weight and the curvature of the
//! Lagrangian, as its steps show it ([`Curvature`]).
//!
//! Merit φ = max log compliance + ρ Σ_limits max(0, largest log over its limit). Each step linearises the values near
//! their group's largest and solves [`curved_step`] with ½ δxᵀ(λM + B)δx, in which δxᵀMδx is the mean square relative
//! change of the loop ([`Loss::metric`]), so that the step does not depend on how the controller is written. A step that raises φ or changes the encirclements of a rotor's det(I −
//! G K) is refused and shortened; B learns from it all the same.

use super::loss::{Evaluation, Loss};
use super::structure::Structure;
use super::values::{GROUPS, Group, LIMITS, Value, WINDOW};
use crate::controller::{ControllerError, in_step};
use crate::linalg::{Mat, NumericError};
use crate::robust::minimax::curvature::Curvature;
use crate::robust::minimax::proximal::{HEAVIEST, after_refusal, after_step, is_accepted};
use crate::robust::minimax::step::{LinearValue, MinimaxStep, StepRule, curved_step};

/// Effort of a descent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Steps tried at most.
    pub steps: usize,
    /// The descent ends when [`PATIENCE`] steps together lower the merit by less than this.
    pub tolerance: f64,
}

/// Penalty ρ of a limit, far above what a limit is worth in stiffness (about one).
pub(crate) const PENALTY: f64 = 8.0;
/// Values at most in a step.
const LARGEST_PROGRAMME: usize = 240;
/// Steps over which progress is judged.
const PATIENCE: usize = 6;
/// Proximal weight at the start: changes of the loop of a few percent.
const FIRST_WEIGHT: f64 = 1.0;
/// Share of the metric's trace that is added: directions that change nothing stay bounded.
const FLAT: f64 = 1e-9;
/// The metric is renewed after so many accepted steps.
const METRIC_AGE: usize = 4;
/// Weight of a parameter's own natural step in the metric.
const OWN_STEP: f64 = 1.0;
/// Every so many lines one of the metric, and weight of a relative change of K itself.
const METRIC: (usize, f64) = (3, 0.2);

/// What a descent keeps from one round to the next.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    /// Proximal weight.
    pub weight: f64,
    /// Curvature learnt from the steps.
    pub curvature: Curvature,
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            weight: FIRST_WEIGHT,
            curvature: Curvature::default(),
        }
    }
}

impl Memory {
    /// For another descent: it does not begin with shorter steps than the first.
    pub(crate) fn begin(&mut self) {
        self.weight = self.weight.min(FIRST_WEIGHT);
    }
}

/// A value that takes part in a step, with its derivative by the parameters.
struct Participant {
    value: Value,
    slope: Vec<f64>,
}

/// Lowers the merit from `x`, in place; the number of steps tried.
///
/// # Errors
/// [`ControllerError`] when the eigenvalues of the metric fail.
pub(crate) fn descend(
    loss: &mut Loss,
    law: &dyn Structure,
    x: &mut Vec<f64>,
    (effort, memory): (&Effort, &mut Memory),
) -> Result<usize, ControllerError> {
    let mut found = loss.evaluate_near(law, x);
    loss.rescale(&mut found);
    let turns = found.turns.clone();
    let mut merit = found.merit(PENALTY);
    let mut metric = metric_of(loss, law, x, &found)?;
    let mut age = 0;
    let mut history = vec![merit];
    let mut steps = 0;
    let mut rows = None;
    let mut likely: Vec<Value> = vec![];
    while steps < effort.steps {
        steps += 1;
        let participants = match rows.take() {
            Some(rows) => rows,
            None => participants_of(loss, law, x, &found),
        };
        // No rotor counts whose loop is stable: there is nothing to descend on.
        if participants.is_empty() {
            break;
        }
        let step = step_for(&participants, &likely, &metric, memory);
        let Some(MinimaxStep {
            step,
            predicted,
            binding,
        }) = step
        else {
            memory.weight = after_refusal(memory.weight, false);
            rows = Some(participants);
            if memory.weight > HEAVIEST {
                break;
            }
            continue;
        };
        let trial: Vec<f64> = x.iter().zip(&step).map(|(v, s)| v + s).collect();
        let mut next = loss.evaluate_near(law, &trial);
        loss.rescale(&mut next);
        let next_merit = next.merit(PENALTY);
        let same = (0..turns.len()).all(|r| !loss.active[r] || next.turns[r] == turns[r]);
        let (promised, kept) = (
            merit - predicted - memory.curvature.half_along(&step),
            merit - next_merit,
        );
        if promised < 1e-3 * effort.tolerance {
            break;
        }
        let accepted = same && is_accepted(kept, promised);
        if same {
            let change = slope_change((loss, law), (&trial, &next), &participants, &binding);
            memory.curvature.learn(&step, &change, || metric.clone());
        }
        likely = binding
            .iter()
            .map(|(k, _)| participants[*k].value)
            .collect();
        if !accepted {
            memory.weight = after_refusal(memory.weight, same && kept > -promised);
            rows = Some(participants);
            if memory.weight > HEAVIEST {
                break;
            }
            continue;
        }
        memory.weight = after_step(memory.weight, kept, promised);
        *x = trial;
        found = next;
        merit = found.merit(PENALTY);
        history.push(merit);
        age += 1;
        if age >= METRIC_AGE {
            metric = metric_of(loss, law, x, &found)?;
            age = 0;
        }
        let past = history.len().checked_sub(1 + PATIENCE).map(|k| history[k]);
        if past.is_some_and(|past| past - merit < effort.tolerance) {
            break;
        }
    }
    Ok(steps)
}

/// The step of the parameters for the values that take part, of which `likely` bound at the step before.
fn step_for(
    participants: &[Participant],
    likely: &[Value],
    metric: &Mat<f64>,
    memory: &Memory,
) -> Option<MinimaxStep> {
    let linear: Vec<LinearValue> = participants
        .iter()
        .map(|t| LinearValue {
            limit: t.value.group.limit(),
            value: t.value.value,
            gradient: t.slope.clone(),
        })
        .collect();
    let likely: Vec<usize> = (0..participants.len())
        .filter(|k| likely.iter().any(|v| v.is_same(&participants[*k].value)))
        .collect();
    let rule = StepRule {
        limits: LIMITS,
        penalty: PENALTY,
        proximal: memory.weight,
    };
    curved_step(&linear, &likely, (metric, &memory.curvature), &rule)
}

/// Slope of the Lagrangian at `trial` less that before the step.
fn slope_change(
    (loss, law): (&Loss, &dyn Structure),
    (trial, next): (&[f64], &Evaluation),
    participants: &[Participant],
    binding: &[(usize, f64)],
) -> Vec<f64> {
    let fixed = law.with(trial);
    let values: Vec<Value> = binding
        .iter()
        .map(|(k, _)| participants[*k].value)
        .collect();
    let after = loss.gradients(&*fixed, next, &values);
    let change = |i: usize| {
        let parts = binding.iter().zip(&after);
        parts
            .map(|((k, weight), after)| weight * (after[i] - participants[*k].slope[i]))
            .sum()
    };
    (0..law.parameters()).map(change).collect()
}

/// The metric of a step: mean square relative change of the loop, and natural steps.
fn metric_of(
    loss: &Loss,
    law: &dyn Structure,
    x: &[f64],
    found: &Evaluation,
) -> Result<Mat<f64>, ControllerError> {
    let mut metric = loss.metric(&*law.with(x), found, METRIC);
    let n = metric.nrows();
    for (k, natural) in law.natural_steps(x).into_iter().enumerate() {
        // In units of a parameter's own effect the largest eigenvalue is at most n: what is added acts on directions,
        // not on units.
        let own = metric[(k, k)] + (OWN_STEP / natural).powi(2);
        metric[(k, k)] = own * (1.0 + FLAT * n as f64);
    }
    if metric.is_all_finite() {
        return Ok(metric);
    }
    Err(in_step("metric of the polish")(NumericError::NotFinite {
        what: "metric",
    }))
}

/// Values near the largest of their group with their derivatives.
fn participants_of(
    loss: &Loss,
    law: &dyn Structure,
    x: &[f64],
    found: &Evaluation,
) -> Vec<Participant> {
    let fixed = law.with(x);
    let values = near_largest(found);
    let slopes = loss.gradients(&*fixed, found, &values);
    let both = values.into_iter().zip(slopes);
    both.map(|(value, slope)| Participant { value, slope })
        .collect()
}

/// The values that can be the largest after a step: near their group's largest and, for limits, near zero.
fn near_largest(found: &Evaluation) -> Vec<Value> {
    let reference = GROUPS.map(|g| {
        let largest = found.largest(g);
        if g == Group::Compliance {
            largest
        } else {
            largest.max(0.0)
        }
    });
    let below = |v: &Value| reference[v.group as usize] - v.value;
    let mut chosen: Vec<Value> = found
        .values
        .iter()
        .filter(|v| below(v) < WINDOW)
        .copied()
        .collect();
    if chosen.len() > LARGEST_PROGRAMME {
        chosen.sort_by(|a, b| below(a).total_cmp(&below(b)));
        chosen.truncate(LARGEST_PROGRAMME);
    }
    chosen
}
