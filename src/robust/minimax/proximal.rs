//! The proximal weight of a descent: larger after a step that kept little of what the linear model promised, smaller
//! after one that kept most of it.

/// Weight at which a descent gives up: the step is below rounding.
pub(crate) const HEAVIEST: f64 = 1e9;
/// Smallest weight.
const LIGHTEST: f64 = 1e-4;
/// Share of its promise that a step has to keep to be accepted.
const LEAST: f64 = 0.05;
/// Above the first share the next step may be longer, below the second one it is shorter.
const LONGER: f64 = 0.6;
const SHORTER: f64 = 0.25;

/// True when a step keeps enough of what it promised.
pub(crate) fn is_accepted(kept: f64, promised: f64) -> bool {
    kept > LEAST * promised
}

/// The weight after a step that was accepted.
pub(crate) fn after_step(weight: f64, kept: f64, promised: f64) -> f64 {
    if kept > LONGER * promised {
        (weight * 0.4).max(LIGHTEST)
    } else if kept < SHORTER * promised {
        weight * 1.6
    } else {
        weight
    }
}

/// The weight after a step that was refused; `near` when it lost no more than it promised.
pub(crate) fn after_refusal(weight: f64, near: bool) -> f64 {
    weight * if near { 2.0 } else { 4.0 }
}
