//! Descent on a largest value under limits: prox-linear steps with an adaptive proximal weight and the curvature of the
//! Lagrangian, as its steps show it ([`Curvature`]).
//!
//! Merit φ = max log compliance + ρ Σ_limits max(0, largest log over its limit). Each step linearises the values near
//! their group's largest and solves a [`CurvedProgramme`] with ½ δxᵀ(λM + B)δx, in which δxᵀMδx is the mean square
//! relative change of the loop ([`Loss::metric`]), so that the step does not depend on how the controller is written. A
//! step that keeps little of what it promised is corrected once: the same linear model through the values found at its
//! end (Fletcher 1982), because the limits that bind bend away from each other along the step. A step that raises φ or
//! changes the encirclements of a rotor's det(I − G K) is refused and shortened; B learns from it all the same.

use super::loss::{Evaluation, Loss};
use super::structure::LawStructure;
use super::values::{LIMITS, Value, ValueGroup};
use crate::controller::{ControllerError, in_step};
use crate::linalg::dense::dot;
use crate::linalg::{Mat, NumericError};
use crate::robust::minimax::curvature::Curvature;
use crate::robust::minimax::proximal::{
    HEAVIEST, after_corrected_step, after_refusal, after_step, is_accepted, is_short,
};
use crate::robust::minimax::step::{CurvedProgramme, LinearValue, MinimaxStep, StepRule};

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
/// Values further (logarithms) below the largest of their group, of limits below zero if that is larger, take no part
/// in a step.
const WIDEST: f64 = 0.2;
/// Change of a value (logarithm) by a step that its evaluations allow for.
const STEP: f64 = 0.02;
/// Steps over which progress is judged.
const PATIENCE: usize = 6;
/// Proximal weight at the start: changes of the loop of a few percent.
const FIRST_WEIGHT: f64 = 1.0;
/// Added to the diagonal of the metric, relative to its trace, in units of the effect of each parameter: directions
/// that change nothing stay bounded.
const FLAT: f64 = 1e-9;
/// The metric is renewed after so many accepted steps.
const METRIC_AGE: usize = 4;
/// Weight of a parameter's own natural step in the metric.
const OWN_STEP: f64 = 1.0;
/// The metric takes one line of so many, and a relative change of K itself with this weight.
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
        Self { weight: FIRST_WEIGHT, curvature: Curvature::default() }
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

/// Where a descent stands.
struct DescentPoint {
    x: Vec<f64>,
    found: Evaluation,
    merit: f64,
    /// Values within this of the largest of their group were evaluated.
    reach: f64,
}

/// A step tried from a place.
struct StepTrial {
    step: MinimaxStep,
    place: DescentPoint,
    /// By how much the merit falls.
    kept: f64,
    /// The turns of every rotor that counts are those of the place.
    same: bool,
}

impl DescentPoint {
    fn new(loss: &mut Loss, law: &dyn LawStructure, x: Vec<f64>, reach: f64) -> Self {
        let mut found = loss.evaluate_near(law, &x, reach);
        loss.rescale(&mut found);
        let merit = found.merit(PENALTY);
        Self { x, found, merit, reach }
    }

    fn try_step(&self, loss: &mut Loss, law: &dyn LawStructure, step: MinimaxStep, reach: f64) -> StepTrial {
        let x = self.x.iter().zip(&step.step).map(|(v, s)| v + s).collect();
        let place = Self::new(loss, law, x, reach);
        let (before, after) = (&self.found.turns, &place.found.turns);
        StepTrial {
            same: (0..before.len()).all(|r| !loss.active[r] || after[r] == before[r]),
            kept: self.merit - place.merit,
            step,
            place,
        }
    }
}

/// Lowers the merit from `x`, in place; the number of steps tried.
pub(crate) fn descend(
    loss: &mut Loss,
    law: &dyn LawStructure,
    x: &mut Vec<f64>,
    effort: &Effort,
    memory: &mut Memory,
) -> Result<usize, ControllerError> {
    let mut place = DescentPoint::new(loss, law, std::mem::take(x), WIDEST);
    let steps = descend_from(&mut place, loss, law, effort, memory);
    *x = place.x;
    steps
}

fn descend_from(
    place: &mut DescentPoint,
    loss: &mut Loss,
    law: &dyn LawStructure,
    effort: &Effort,
    memory: &mut Memory,
) -> Result<usize, ControllerError> {
    let mut metric = metric_of(loss, law, place)?;
    let mut age = 0;
    let mut history = vec![place.merit];
    let mut steps = 0;
    let mut rows = None;
    let mut likely: Vec<Value> = vec![];
    let mut known: Vec<Participant> = vec![];
    while steps < effort.steps {
        steps += 1;
        let participants = match rows.take() {
            Some(rows) => rows,
            None => participants_of(loss, law, place, &known),
        };
        let reach = next_reach(place, &participants);
        // No rotor counts whose loop is stable: there is nothing to descend on.
        if participants.is_empty() {
            break;
        }
        let programme = programme_of(&participants, &metric, memory);
        let first = programme.and_then(|programme| {
            let step = programme.step(&among(&participants, &likely))?;
            Some((programme, step))
        });
        let Some((mut programme, step)) = first else {
            memory.weight = after_refusal(memory.weight, false);
            rows = Some(participants);
            if memory.weight > HEAVIEST {
                break;
            }
            continue;
        };
        let promised = place.merit - step.predicted - memory.curvature.half_along(&step.step);
        if promised < 1e-3 * effort.tolerance {
            break;
        }
        let mut trial = place.try_step(loss, law, step, reach);
        let mut is_corrected = false;
        if trial.same && is_short(trial.kept, promised) {
            programme.revalue(values_at(&trial, &participants).into_iter());
            let binding: Vec<usize> = trial.step.binding.iter().map(|(k, _)| *k).collect();
            let again = programme.step(&binding);
            let again = again.map(|step| place.try_step(loss, law, step, reach));
            if let Some(again) = again.filter(|again| again.same && again.kept > trial.kept) {
                (trial, is_corrected) = (again, true);
            }
        }
        let (kept, same) = (trial.kept, trial.same);
        if same {
            known = binding_after(loss, law, &trial, &participants);
            let change = slope_change(&trial.step, &participants, &known);
            let step = &trial.step.step;
            memory.curvature.learn(step, &change, || metric.clone());
        }
        let binding = trial.step.binding.iter();
        likely = binding.map(|(k, _)| participants[*k].value).collect();
        if !(same && is_accepted(kept, promised)) {
            memory.weight = after_refusal(memory.weight, same && kept > -promised);
            rows = Some(participants);
            if memory.weight > HEAVIEST {
                break;
            }
            continue;
        }
        memory.weight = if is_corrected {
            after_corrected_step(memory.weight, kept, promised)
        } else {
            after_step(memory.weight, kept, promised)
        };
        *place = trial.place;
        history.push(place.merit);
        age += 1;
        if age >= METRIC_AGE {
            metric = metric_of(loss, law, place)?;
            age = 0;
        }
        let past = history.len().checked_sub(1 + PATIENCE).map(|k| history[k]);
        if past.is_some_and(|past| past - place.merit < effort.tolerance) {
            break;
        }
    }
    Ok(steps)
}

/// The programme of a step for the values that take part.
fn programme_of(participants: &[Participant], metric: &Mat<f64>, memory: &Memory) -> Option<CurvedProgramme> {
    let linear: Vec<LinearValue> = participants
        .iter()
        .map(|t| LinearValue { limit: t.value.group.limit(), value: t.value.value, gradient: t.slope.clone() })
        .collect();
    let rule = StepRule { limits: LIMITS, penalty: PENALTY, proximal: memory.weight };
    CurvedProgramme::new(&linear, metric, &memory.curvature, &rule)
}

/// Numbers of the values that take part among some.
fn among(participants: &[Participant], some: &[Value]) -> Vec<usize> {
    let is_one = |k: &usize| some.iter().any(|v| v.is_same(&participants[*k].value));
    (0..participants.len()).filter(is_one).collect()
}

/// Values before a step for which the linear model gives what was found at its end, or, where that was too low to be
/// kept, the most that it can have been.
fn values_at(trial: &StepTrial, participants: &[Participant]) -> Vec<f64> {
    let key = |v: &Value| (v.rotor, v.line, v.group, v.entry);
    let found = &trial.place.found;
    let mut after: Vec<&Value> = found.values.iter().collect();
    after.sort_by_key(|v| key(v));
    let value = |p: &Participant| {
        let found = match after.binary_search_by_key(&key(&p.value), |v| key(v)) {
            Ok(k) => after[k].value,
            Err(_) => reference(found, p.value.group) - trial.place.reach,
        };
        found - dot(&p.slope, &trial.step.step)
    };
    participants.iter().map(value).collect()
}

/// The values that bind a step with their derivatives at its end.
fn binding_after(
    loss: &Loss,
    law: &dyn LawStructure,
    trial: &StepTrial,
    participants: &[Participant],
) -> Vec<Participant> {
    let binding = trial.step.binding.iter();
    let values = binding.map(|(k, _)| participants[*k].value).collect();
    with_slopes(loss, law, &trial.place, values)
}

/// Slope of the Lagrangian at the end of a step less that before it; `after` are the values that bind it, in their
/// order.
fn slope_change(step: &MinimaxStep, participants: &[Participant], after: &[Participant]) -> Vec<f64> {
    let change = |i: usize| {
        let parts = step.binding.iter().zip(after);
        parts.map(|((k, weight), after)| weight * (after.slope[i] - participants[*k].slope[i])).sum()
    };
    (0..step.step.len()).map(change).collect()
}

/// The metric of a step: mean square relative change of the loop, and natural steps.
fn metric_of(loss: &Loss, law: &dyn LawStructure, place: &DescentPoint) -> Result<Mat<f64>, ControllerError> {
    let x = &place.x;
    let mut metric = loss.metric(&*law.with(x), &place.found, METRIC.0, METRIC.1);
    let n = metric.nrows();
    for (k, natural) in law.natural_steps(x).into_iter().enumerate() {
        // In units of the effect of each parameter the diagonal is one and the trace n.
        let own = metric[(k, k)] + (OWN_STEP / natural).powi(2);
        metric[(k, k)] = own * (1.0 + FLAT * n as f64);
    }
    if metric.is_all_finite() {
        return Ok(metric);
    }
    Err(in_step("metric of the polish")(NumericError::NotFinite { what: "metric" }))
}

/// Values near the largest of their group with their derivatives, of which some are known.
fn participants_of(
    loss: &Loss,
    law: &dyn LawStructure,
    place: &DescentPoint,
    known: &[Participant],
) -> Vec<Participant> {
    let values = near_largest(place);
    let known_of = |value: &Value| known.iter().find(|own| own.value.is_same(value));
    let unknown = values.iter().filter(|value| known_of(value).is_none());
    let unknown = unknown.copied().collect();
    let mut others = with_slopes(loss, law, place, unknown).into_iter();
    let of = |value: Value| match known_of(&value) {
        Some(known) => Some(Participant { value, slope: known.slope.clone() }),
        None => others.next(),
    };
    values.into_iter().filter_map(of).collect()
}

/// Values with their derivatives at a place.
fn with_slopes(loss: &Loss, law: &dyn LawStructure, place: &DescentPoint, values: Vec<Value>) -> Vec<Participant> {
    let slopes = loss.gradients(&*law.with(&place.x), &place.found, &values);
    let both = values.into_iter().zip(slopes);
    both.map(|(value, slope)| Participant { value, slope }).collect()
}

/// What a value is compared with: the largest of its group and, for limits, zero if that is larger.
fn reference(found: &Evaluation, group: ValueGroup) -> f64 {
    group.reference(found.largest(group), 0.0)
}

/// How far a value is below its reference.
fn below(found: &Evaluation, value: &Value) -> f64 {
    reference(found, value.group) - value.value
}

/// The values that can be the largest after a step: [`LARGEST_PROGRAMME`] of those nearest to their reference.
fn near_largest(place: &DescentPoint) -> Vec<Value> {
    let below = |v: &Value| below(&place.found, v);
    let values = place.found.values.iter();
    let mut chosen: Vec<Value> = values.filter(|v| below(v) < place.reach).copied().collect();
    if chosen.len() > LARGEST_PROGRAMME {
        chosen.select_nth_unstable_by(LARGEST_PROGRAMME, |a, b| below(a).total_cmp(&below(b)));
        chosen.truncate(LARGEST_PROGRAMME);
        chosen.sort_by(|a, b| below(a).total_cmp(&below(b)));
    }
    chosen
}

/// The reach of the evaluations of the next step: twice that of the values that take part in it, and a step.
fn next_reach(place: &DescentPoint, participants: &[Participant]) -> f64 {
    let used = if participants.len() < LARGEST_PROGRAMME {
        place.reach
    } else {
        let below = participants.iter().map(|p| below(&place.found, &p.value));
        below.fold(0.0, f64::max)
    };
    (2.0 * used + STEP).min(WIDEST)
}
