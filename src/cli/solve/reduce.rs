//! `muspin solve reduce`: A, B, C, D, orders (or max_error) → Hankel values, and per order the better of balanced
//! truncation and singular perturbation, or the latter alone, with the exact L∞ norm of its error.

use super::answer::{number, system};
use super::{Answer, Failure, Problem};
use crate::linalg::NumericError;
use crate::lti::balance::{Balancing, Reduction};
use serde_json::Value;

/// Solves the problem of the file.
pub(super) fn solve(problem: &Problem) -> Result<Answer, Failure> {
    let full = problem.system()?;
    let keeps_dc = problem.has("match_dc") && problem.flag("match_dc")?;
    let within = problem.has("max_error");
    let asked = if problem.has("orders") { problem.counts("orders")? } else { vec![] };
    let balancing = Balancing::with_check(&full)?;
    let mut answers = Answer::new();
    let with = |answers: Answer, order: usize, best: &Reduction| {
        let found = system(&best.system).with_number("error_hinf", best.error_hinf).with("method", best.method);
        answers.with(&order.to_string(), found)
    };
    let mut refused: Vec<(usize, String)> = vec![];
    for order in &asked {
        if *order > full.order() {
            refused.push((*order, format!("the system has {} states", full.order())));
        } else if *order < balancing.kept() {
            let kept = balancing.kept();
            refused.push((*order, format!("{kept} poles are not in the open left half plane, and are kept")));
        } else if let Some(best) = best_of(&balancing, *order, keeps_dc)? {
            answers = with(answers, *order, &best);
        }
    }
    // One impossible order does not refuse the others; where none is possible, there is no answer.
    if let Some((order, reason)) = refused.first().filter(|_| refused.len() == asked.len()) {
        return Err(problem
            .failure("orders", format!("{order} is not possible: {reason}"))
            .with_hint("ask for an order between the number of unstable poles and that of the states")
            .into());
    }
    let mut answer = Answer::new();
    if within {
        let allowed = problem.number("max_error")?;
        if allowed <= 0.0 {
            return Err(problem.failure("max_error", format!("must be positive, found {allowed}")).into());
        }
        if let Some((order, best)) = smallest_within(&balancing, full.order(), allowed, keeps_dc)? {
            answers = with(answers, order, &best);
            answer = answer.with("order_within_max_error", order);
        }
    }
    if !refused.is_empty() {
        let of_orders =
            |answers: Answer, (order, reason): &(usize, String)| answers.with(&order.to_string(), reason.as_str());
        answer = answer.with("refused", refused.iter().fold(Answer::new(), of_orders));
    }
    let values: Vec<Value> = balancing.hankel.iter().map(|h| number(*h)).collect();
    Ok(answer.with("hsv", values).with("kept_unstable", balancing.kept()).with("orders", answers))
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
    let first = balancing.kept() + balancing.hankel.iter().filter(|h| **h > allowed).count();
    for order in first..=full {
        if let Some(best) = best_of(balancing, order, keeps_dc)?.filter(|r| r.error_hinf <= allowed) {
            return Ok(Some((order, best)));
        }
    }
    Ok(None)
}
