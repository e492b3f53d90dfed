//! H2 norm: the root of the energy of the impulse responses, ‖C L‖ with P = L Lᵀ, AP + PAᵀ + BBᵀ = 0, and the same by
//! the other gramian, which shares no step with it. In sampled time ‖G‖² = tr(C P Cᵀ + D Dᵀ), P = APAᵀ + BBᵀ: the
//! bilinear map takes that equation to the continuous one, with P and Q times 2/k and k/2, k = 2/T.

use super::norm::NormError;
use super::sample::inverse_tustin;
use super::scale::{balancing, balancing_of_dynamics};
use super::state_space::{Continuous, Discrete, StateSpace, TimeBase};
use crate::linalg::gramian::{observability_factor, reachability_factor};
use crate::linalg::{Mat, NumericError};

/// Largest accepted relative difference of the two ways: half the digits.
const LARGEST_DIFFERENCE: f64 = 1e-8;

/// H2 norm with its certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct H2Norm {
    /// The norm.
    pub norm: f64,
    /// Relative difference of the norms by the two gramians.
    pub difference: f64,
}

/// H2 norm of a stable continuous system without feedthrough.
///
/// # Errors
/// [`NormError::Unstable`]; a feedthrough, with which the norm is infinite; a gramian that fails.
pub fn h2_norm(system: &StateSpace<Continuous>) -> Result<H2Norm, NormError> {
    let largest = system.d.norm_max();
    if largest > 0.0 {
        return Err(NumericError::Dimension {
            what: "H2 norm",
            expected: "a system without feedthrough, with which it is infinite".to_owned(),
            found: format!("D with entries up to {largest}"),
        }
        .into());
    }
    check_stability(system)?;
    both_ways(system, [&system.c, &system.b], [1.0; 2])
}

/// H2 norm of a stable sampled system: the root of the sum of the squared samples of its impulse responses.
///
/// # Errors
/// [`NormError::Unstable`], or a gramian that fails.
pub fn h2_norm_discrete(system: &StateSpace<Discrete>) -> Result<H2Norm, NormError> {
    check_stability(system)?;
    let k = 2.0 / system.time.period_s;
    let found = both_ways(&inverse_tustin(system)?, [&system.c, &system.b], [2.0 / k, 0.5 * k])?;
    Ok(H2Norm { norm: found.norm.hypot(system.d.norm_l2()), ..found })
}

fn check_stability<T: TimeBase>(system: &StateSpace<T>) -> Result<(), NormError> {
    let growth_rate = system.growth_rate()?;
    if growth_rate >= 0.0 { Err(NormError::Unstable { growth_rate }) } else { Ok(()) }
}

/// ‖C L‖ by either gramian of a stable system; the factors are those of the squares.
fn both_ways(s: &StateSpace<Continuous>, ends: [&Mat<f64>; 2], factors: [f64; 2]) -> Result<H2Norm, NormError> {
    let mut closest = f64::INFINITY;
    // Companion forms have even rows and columns by A alone.
    for scale in [balancing(s), balancing_of_dynamics(s)] {
        let even = s.scale_states(&scale);
        let n = s.order();
        let [c, b] = ends;
        let c = Mat::from_fn(c.nrows(), n, |i, j| c[(i, j)] * scale[j]);
        let b = Mat::from_fn(n, b.ncols(), |i, j| b[(i, j)] / scale[i]);
        let reach = reachability_factor(&even.a, &even.b)?.to_double();
        let observe = observability_factor(&even.a, &even.c)?.to_double();
        let norm = (c * reach).norm_l2() * factors[0].sqrt();
        let other = (observe.transpose() * b).norm_l2() * factors[1].sqrt();
        let difference = if norm == other { 0.0 } else { (norm - other).abs() / norm.max(other) };
        if difference <= LARGEST_DIFFERENCE {
            return Ok(H2Norm { norm, difference });
        }
        closest = closest.min(difference);
    }
    Err(NumericError::Contradiction { what: "H2 norm by the two gramians", residual: closest }.into())
}
