//! `muspin solve reduce`: A, B, C, D, orders (or max_error) → Hankel values, and per order the better of balanced
//! truncation and singular perturbation, or the latter alone, with the exact L∞ norm of its error.

use super::answer::number;
use super::clock::Clock;
use super::{Answer, Failure, ProblemFields};
use crate::linalg::NumericError;
use crate::lti::balance::{Balancing, Reduction, frequency_weighted_balance};
use crate::lti::{Continuous, StateSpace};
use crate::robust::coprime::CoprimeFactors;
use serde_json::{Map, Value};

pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let clock = Clock::of(problem)?;
    let full = clock.plane_system(problem)?;
    if problem.has("coprime") && problem.flag("coprime")? {
        return reduce_factors(problem, clock, &full);
    }
    let keeps_dc = problem.has("match_dc") && problem.flag("match_dc")?;
    let within = problem.has("max_error");
    let asked = if problem.has("orders") { problem.counts("orders")? } else { vec![] };
    let weight = |field: &str| read_weight(problem, field, clock);
    let (input, output) = (weight("Wi")?, weight("Wo")?);
    let balancing = if input.is_some() || output.is_some() {
        frequency_weighted_balance(&full, input.as_ref(), output.as_ref())
            .map_err(|error| problem.failure("Wi, Wo", error))?
    } else {
        Balancing::with_check(&full)?
    };
    let mut answers = Answer::new();
    let with = |answers: Answer, order: usize, best: &Reduction| -> Result<Answer, NumericError> {
        let found = clock.answer(&best.system)?;
        let found = found.with_number("error_hinf", best.error_hinf).with("method", best.method);
        Ok(answers.with(&order.to_string(), found))
    };
    let mut left_out: Vec<(usize, usize, String)> = vec![];
    for (k, order) in asked.iter().enumerate() {
        let reason = if *order > full.order() {
            format!("the system has {} states", full.order())
        } else if *order < balancing.kept_states() {
            format!("{} poles are not stable and are kept", balancing.kept_states())
        } else {
            if let Some(best) = best_of(&balancing, *order, keeps_dc)? {
                answers = with(answers, *order, &best)?;
            }
            continue;
        };
        left_out.push((k, *order, reason));
    }
    // One impossible order does not refuse the others; where none is possible, there is no answer.
    if let (Some((k, order, reason)), true) = (left_out.first(), left_out.len() == asked.len()) {
        return Err(problem
            .failure(&format!("orders[{k}]"), format!("is {order}, but {reason}"))
            .with_hint(format!("ask for {} to {} states", balancing.kept_states(), full.order()))
            .into());
    }
    let mut answer = Answer::new();
    if within {
        let allowed = problem.number("max_error")?;
        if allowed <= 0.0 {
            return Err(problem.failure("max_error", format!("must be positive, found {allowed}")).into());
        }
        if let Some((order, best)) = smallest_within(&balancing, full.order(), allowed, keeps_dc)? {
            answers = with(answers, order, &best)?;
            answer = answer.with("order_within_max_error", order);
        }
    }
    if !left_out.is_empty() {
        let reasons = left_out.iter().map(|(_, order, reason)| (order.to_string(), Value::from(reason.as_str())));
        answer = answer.with("left_out", reasons.collect::<Map<_, _>>());
    }
    for (_, order, reason) in left_out {
        answer = answer.with_remark(format!("order {order} is left out: {reason}"));
    }
    let values: Vec<Value> = balancing.hankel.iter().map(|h| number(*h)).collect();
    Ok(answer.with("hsv", values).with("kept_unstable", balancing.kept_states()).with("orders", answers))
}

/// Reduction of the coprime factors, unstable poles included.
fn reduce_factors(problem: &ProblemFields, clock: Clock, full: &StateSpace<Continuous>) -> Result<Answer, Failure> {
    if let Some(field) = ["max_error", "match_dc", "Wi", "Wo"].into_iter().find(|field| problem.has(field)) {
        return Err(problem.failure(field, "does not go with `coprime`").into());
    }
    let factors = CoprimeFactors::new(full)?;
    let mut answers = Answer::new();
    let asked = if problem.has("orders") { problem.counts("orders")? } else { vec![] };
    for (k, order) in asked.into_iter().enumerate() {
        if order > full.order() {
            let rule = format!("is {order}, but the system has {} states", full.order());
            return Err(problem.failure(&format!("orders[{k}]"), rule).into());
        }
        let (system, error) = factors.reduce(order)?;
        answers = answers.with(&order.to_string(), clock.answer(&system)?.with_number("error_factors", error));
    }
    let values: Vec<Value> = factors.balancing.hankel.iter().map(|h| number(*h)).collect();
    Ok(Answer::new().with("hsv", values).with("kept_unstable", 0).with("orders", answers))
}

/// A weight of the error, which must be stable.
fn read_weight(problem: &ProblemFields, field: &str, clock: Clock) -> Result<Option<StateSpace<Continuous>>, Failure> {
    if !problem.has(field) {
        return Ok(None);
    }
    let weight = clock.in_plane(problem.system_in(field)?)?;
    let growth_rate = weight.growth_rate()?;
    if growth_rate >= 0.0 {
        return Err(problem.failure(field, "has a pole that is not stable").into());
    }
    Ok(Some(weight))
}

/// The better reduction to `order` states, or the one that keeps the DC gain.
fn best_of(balancing: &Balancing, order: usize, keeps_dc: bool) -> Result<Option<Reduction>, NumericError> {
    let wanted = |r: &Reduction| !keeps_dc || r.method == "singular_perturbation";
    Ok(balancing.reductions(order)?.into_iter().find(wanted))
}

/// The reduction of smallest order whose error is within `allowed`. No order cuts a Hankel value above the error.
fn smallest_within(
    balancing: &Balancing,
    full: usize,
    allowed: f64,
    keeps_dc: bool,
) -> Result<Option<(usize, Reduction)>, NumericError> {
    let first = balancing.kept_states() + balancing.hankel.iter().filter(|h| **h > allowed).count();
    for order in first..=full {
        if let Some(best) = best_of(balancing, order, keeps_dc)?.filter(|r| r.error_hinf <= allowed) {
            return Ok(Some((order, best)));
        }
    }
    Ok(None)
}
