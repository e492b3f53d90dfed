//! Descent on a largest value under limits: prox-linear steps with an adaptive proximal weight.
//!
//! Merit φ = max log compliance + ρ Σ_limits max(0, largest log over its limit). Each step linearises the values near
//! their group's largest and solves [`minimax_step`] in coordinates in which |p|² is the mean square relative change of
//! the loop (metric M of [`Loss::metric_rows`], p = M^{1/2} δx), so that the step does not depend on how the controller
//! is written. A step that raises φ or changes the encirclements of a rotor's det(I − G K) is refused and shortened.

use super::loss::{Evaluation, GROUPS, Group, LIMITS, Loss, Value};
use super::structure::Structure;
use crate::controller::{ControllerError, in_step};
use crate::linalg::{Mat, symmetric_eigen};
use crate::robust::mu::minimax_step::{LinearValue, minimax_step};
use rayon::prelude::*;

/// Effort of a descent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Steps tried at most.
    pub steps: usize,
    /// The descent ends when [`PATIENCE`] steps together lower the merit by less than this.
    pub tolerance: f64,
    /// Proximal weight at the start.
    pub first_weight: f64,
}

/// A descent that came to its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Descended {
    /// Steps tried.
    pub steps: usize,
    /// Proximal weight at the end.
    pub weight: f64,
}

/// Penalty ρ of a limit, far above what a limit is worth in stiffness (about one).
pub(crate) const PENALTY: f64 = 8.0;
/// Values this far (log) below their group's largest, of limits below zero if that is larger, take part in a step.
const WINDOW: f64 = 0.2;
/// Values at most in a step.
const LARGEST_PROGRAMME: usize = 240;
/// Steps over which progress is judged.
const PATIENCE: usize = 6;
/// Proximal weight at the start: |p| of a few percent.
pub(crate) const FIRST_WEIGHT: f64 = 1.0;
/// Smallest eigenvalue of the metric relative to its largest: directions that change nothing stay bounded.
const FLAT: f64 = 1e-9;
/// The metric is renewed after so many accepted steps.
const METRIC_AGE: usize = 4;
/// Weight of a parameter's own natural step in the metric.
const OWN_STEP: f64 = 1.0;
/// Lines skipped between the rows of the metric, and weight of a relative change of K itself.
const METRIC: (usize, f64) = (3, 0.2);

/// Lowers the merit from `x`, in place.
///
/// # Errors
/// [`ControllerError`] when the eigenvalues of the metric fail.
pub(crate) fn descend(
    loss: &mut Loss,
    law: &dyn Structure,
    x: &mut Vec<f64>,
    effort: &Effort,
) -> Result<Descended, ControllerError> {
    let mut found = loss.evaluate_near(law, x);
    loss.rescale(&mut found);
    let turns = found.turns.clone();
    let mut merit = found.merit(PENALTY);
    let mut weight = effort.first_weight;
    let mut whiten = whitening(loss, law, x, &found)?;
    let mut age = 0;
    let mut history = vec![merit];
    let mut steps = 0;
    let mut rows = None;
    while steps < effort.steps {
        steps += 1;
        let linear = match rows.take() {
            Some(rows) => rows,
            None => linearised(loss, law, x, &found, &whiten),
        };
        let Ok(step) = minimax_step(&linear, LIMITS, PENALTY, weight) else {
            weight *= 4.0;
            rows = Some(linear);
            if weight > 1e9 {
                break;
            }
            continue;
        };
        let trial: Vec<f64> = x
            .iter()
            .enumerate()
            .map(|(i, v)| {
                let own = &whiten[i];
                v + own.iter().zip(&step.step).map(|(w, p)| w * p).sum::<f64>()
            })
            .collect();
        let mut next = loss.evaluate_near(law, &trial);
        loss.rescale(&mut next);
        let next_merit = next.merit(PENALTY);
        let same = (0..turns.len()).all(|r| !loss.active[r] || next.turns[r] == turns[r]);
        let (promised, kept) = (merit - step.predicted, merit - next_merit);
        if promised < 1e-3 * effort.tolerance {
            break;
        }
        if !(same && kept > 0.05 * promised) {
            weight *= if same && kept > -promised { 2.0 } else { 4.0 };
            rows = Some(linear);
            if weight > 1e9 {
                break;
            }
            continue;
        }
        if kept > 0.6 * promised {
            weight = (weight * 0.4).max(1e-4);
        } else if kept < 0.25 * promised {
            weight *= 1.6;
        }
        *x = trial;
        found = next;
        merit = found.merit(PENALTY);
        history.push(merit);
        age += 1;
        if age >= METRIC_AGE {
            whiten = whitening(loss, law, x, &found)?;
            age = 0;
        }
        let past = history.len().checked_sub(1 + PATIENCE).map(|k| history[k]);
        if past.is_some_and(|past| past - merit < effort.tolerance) {
            break;
        }
    }
    Ok(Descended { steps, weight })
}

/// M^{-1/2}: parameters × coordinates, by rows.
fn whitening(
    loss: &Loss,
    law: &dyn Structure,
    x: &[f64],
    found: &Evaluation,
) -> Result<Vec<Vec<f64>>, ControllerError> {
    let n = law.parameters();
    let mut rows = loss.metric_rows(law, x, found, METRIC);
    for (k, natural) in law.natural_steps(x).into_iter().enumerate() {
        let mut row = vec![0.0; n];
        row[k] = OWN_STEP / natural;
        rows.push(row);
    }
    let jacobian = Mat::from_fn(rows.len(), n, |i, j| rows[i][j]);
    // Parameters in units of their own effect, so that the floor below acts on directions, not on units.
    let unit: Vec<f64> = (0..n)
        .map(|j| {
            let size = rows.iter().map(|r| r[j] * r[j]).sum::<f64>().sqrt();
            if size > 0.0 { 1.0 / size } else { 1.0 }
        })
        .collect();
    let scaled = Mat::from_fn(rows.len(), n, |i, j| jacobian[(i, j)] * unit[j]);
    let metric = scaled.transpose() * &scaled;
    let (values, vectors) = symmetric_eigen(&metric).map_err(in_step("metric of the polish"))?;
    let floor = FLAT * values.last().copied().unwrap_or(1.0);
    Ok((0..n)
        .map(|i| {
            (0..n)
                .map(|k| unit[i] * vectors[(i, k)] / values[k].max(floor).sqrt())
                .collect()
        })
        .collect())
}

/// Values near the largest of their group with derivatives in whitened coordinates.
fn linearised(
    loss: &Loss,
    law: &dyn Structure,
    x: &[f64],
    found: &Evaluation,
    whiten: &[Vec<f64>],
) -> Vec<LinearValue> {
    let n = law.parameters();
    let chosen = near_largest(found);
    chosen
        .par_iter()
        .map(|value| {
            let g = loss.gradient(law, x, found, value);
            let mut gradient = vec![0.0; n];
            for (own, g) in whiten.iter().zip(&g) {
                for (out, w) in gradient.iter_mut().zip(own) {
                    *out += g * w;
                }
            }
            LinearValue {
                limit: value.group.limit(),
                value: value.value,
                gradient,
            }
        })
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
