//! Weighting functions of the generalized plant as state-space systems.
//! First order between two levels: W(s) = (h s + d p)/(s + p), p = 2π f_c √(h/d), so that W(0) = d, W(∞) = h and
//! |W(j2πf_c)| = √(h d) exactly, for d > h and for d < h.
//! Roll-on of the control weight: W(s) = (1/limit)·((1 + s/ω₁)/(1 + s/(r ω₁)))², flat in band, r² times steeper above.

use crate::linalg::{Mat, NumericError};
use crate::lti::connect::series;
use crate::lti::{Continuous, StateSpace};
use std::f64::consts::TAU;

/// First-order weight with DC value `dc`, high-frequency value `hf` and geometric-mean crossing at `crossover_hz`.
///
/// # Errors
/// [`NumericError::NotFinite`] when a value is not finite or not positive.
pub fn level_change(
    dc: f64,
    hf: f64,
    crossover_hz: f64,
) -> Result<StateSpace<Continuous>, NumericError> {
    if ![dc, hf, crossover_hz]
        .iter()
        .all(|v| v.is_finite() && *v > 0.0)
    {
        return Err(NumericError::NotFinite {
            what: "first-order weight (levels and crossover must be positive)",
        });
    }
    let pole = TAU * crossover_hz * (hf / dc).sqrt();
    // (h s + d p)/(s + p) = h + (d − h) p/(s + p); the state carries √|…| on both sides.
    let residue = (dc - hf) * pole;
    let split = residue.abs().sqrt();
    first_order(pole, split, residue.signum() * split, hf)
}

/// Leaky integrator: DC value `dc`, falling with 1/s above `leak_hz`.
///
/// # Errors
/// As [`level_change`].
pub fn leaky_integrator(dc: f64, leak_hz: f64) -> Result<StateSpace<Continuous>, NumericError> {
    if ![dc, leak_hz].iter().all(|v| v.is_finite() && *v > 0.0) {
        return Err(NumericError::NotFinite {
            what: "integral weight (gain and corner must be positive)",
        });
    }
    let pole = TAU * leak_hz;
    let split = (dc * pole).sqrt();
    first_order(pole, split, split, 0.0)
}

/// Control weight: 1/`limit` in band, second-order rise from `corner_hz`, flat again at `ratio` times the corner.
///
/// # Errors
/// As [`level_change`].
pub fn roll_on(
    limit: f64,
    corner_hz: f64,
    ratio: f64,
) -> Result<StateSpace<Continuous>, NumericError> {
    let stage = level_change(1.0, ratio, corner_hz * ratio.sqrt())?;
    let both = series(&stage, &stage)?;
    Ok(both.scale_outputs(&Mat::from_fn(1, 1, |_, _| 1.0 / limit)))
}

fn first_order(
    pole: f64,
    input: f64,
    output: f64,
    direct: f64,
) -> Result<StateSpace<Continuous>, NumericError> {
    let one = |x: f64| Mat::from_fn(1, 1, |_, _| x);
    StateSpace::new(one(-pole), one(input), one(output), one(direct), Continuous)
}
