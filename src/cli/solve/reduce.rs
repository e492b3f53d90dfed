//! `muspin solve reduce`: A, B, C, D, orders → Hankel values, and per order the better of balanced truncation and
//! singular perturbation with the exact L∞ norm of its error. An order that the system does not have is left out and
//! said.

use super::answer::{number, system};
use super::{Answer, Failure, Problem};
use crate::lti::balance::Balancing;
use serde_json::{Map, Value};

/// Solves the problem of the file.
pub(super) fn solve(problem: &Problem) -> Result<Answer, Failure> {
    let full = problem.system()?;
    let orders = problem.counts("orders")?;
    let balancing = Balancing::new(&full)?;
    let (mut answers, mut left_out) = (Answer::new(), vec![]);
    for (k, order) in orders.iter().enumerate() {
        let reason = if *order > full.order() {
            format!("the system has {} states", full.order())
        } else if *order < balancing.kept() {
            format!("{} poles are not in the open left half plane and are kept", balancing.kept())
        } else {
            let reductions = balancing.reductions(*order)?;
            if let Some(best) = reductions.first() {
                let one = system(&best.system).with_number("error_hinf", best.error_hinf).with("method", best.method);
                answers = answers.with(&order.to_string(), one);
            }
            continue;
        };
        left_out.push((k, *order, reason));
    }
    if let (Some((k, order, reason)), true) = (left_out.first(), left_out.len() == orders.len()) {
        return Err(problem
            .failure(&format!("orders[{k}]"), format!("is {order}, but {reason}"))
            .with_hint(format!("ask for {} to {} states", balancing.kept(), full.order()))
            .into());
    }
    let values: Vec<Value> = balancing.hankel.iter().map(|h| number(*h)).collect();
    let mut answer = Answer::new().with("hsv", values).with("kept_unstable", balancing.kept()).with("orders", answers);
    if !left_out.is_empty() {
        let reasons = left_out.iter().map(|(_, order, reason)| (order.to_string(), Value::from(reason.as_str())));
        answer = answer.with("left_out", reasons.collect::<Map<_, _>>());
    }
    for (_, order, reason) in left_out {
        answer = answer.with_remark(format!("order {order} is left out: {reason}"));
    }
    Ok(answer)
}
