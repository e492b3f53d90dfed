//! `muspin solve reduce`: A, B, C, D, orders → Hankel values, and per order the better of balanced truncation and
//! singular perturbation with the exact L∞ norm of its error.

use super::answer::{number, system};
use super::{Answer, Failure, Problem};
use crate::lti::balance::Balancing;
use serde_json::Value;

/// Solves the problem of the file.
pub(super) fn solve(problem: &Problem) -> Result<Answer, Failure> {
    let full = problem.system()?;
    let orders = problem.counts("orders")?;
    if let Some((k, order)) = orders.iter().enumerate().find(|(_, order)| **order > full.order()) {
        return Err(problem
            .failure(&format!("orders[{k}]"), format!("is {order}, but the system has {} states", full.order()))
            .into());
    }
    let balancing = Balancing::with_check(&full)?;
    let mut answers = Answer::new();
    for (k, order) in orders.iter().enumerate() {
        if *order < balancing.kept() {
            return Err(problem
                .failure(
                    &format!("orders[{k}]"),
                    format!("is {order}, but {} poles are not in the open left half plane", balancing.kept()),
                )
                .with_hint("poles that are not stable are kept: ask for a larger order")
                .into());
        }
        let reductions = balancing.reductions(*order)?;
        let Some(best) = reductions.first() else {
            continue;
        };
        answers = answers.with(
            &order.to_string(),
            system(&best.system).with_number("error_hinf", best.error_hinf).with("method", best.method),
        );
    }
    let values: Vec<Value> = balancing.hankel.iter().map(|h| number(*h)).collect();
    Ok(Answer::new().with("hsv", values).with("kept_unstable", balancing.kept()).with("orders", answers))
}
