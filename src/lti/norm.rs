//! L∞ norm of a stable system by level sets, with certified bounds: ‖G‖∞ = sup_ω σmax(C(jωI − A)⁻¹B + D).
//! H(γ) = [A + BR⁻¹DᵀC, BR⁻¹Bᵀ; −Cᵀ(I + DR⁻¹Dᵀ)C, −(A + BR⁻¹DᵀC)ᵀ], R = γ²I − DᵀD.
//! Seeds: DC, infinity, every pole frequency, and a log grid. States are balanced first (without that, badly scaled
//! magnetic-bearing loops lose five digits).

use super::level_set::{axis_frequencies, peak};
use super::responder::FrequencyResponder;
use super::sample::inverse_tustin;
use super::scale::balancing;
use super::state_space::{Continuous, Discrete, StateSpace, TimeBase};
use crate::linalg::equal_planes::EqualPlanes;
use crate::linalg::{Mat, NumericError, c64, max_singular_value, max_singular_value_complex, solve};
use rayon::prelude::*;
use thiserror::Error;

/// Why a norm could not be computed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NormError {
    /// The system is not stable, so the H∞ norm does not exist.
    #[error("the system is unstable: its growth rate is {growth_rate:.6e} 1/s, the norm does not exist")]
    Unstable {
        /// Largest growth rate of a pole, 1/s.
        growth_rate: f64,
    },
    /// A numeric failure.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// H∞ norm with its certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HinfNorm {
    /// Gain attained at the peak frequency.
    pub norm: f64,
    /// Peak frequency, rad/s; infinity for s = ∞.
    pub peak_omega_rad_s: f64,
    /// Level that no frequency reaches.
    pub upper: f64,
}

/// H∞ norm of a stable continuous system to a relative tolerance (1e-10 is a good choice).
///
/// # Errors
/// [`NormError::Unstable`] when a pole is not in the open left half plane.
pub fn hinf_norm(system: &StateSpace<Continuous>, rel_tol: f64) -> Result<HinfNorm, NormError> {
    Ok(hinf_norm_and_growth(system, rel_tol)?.0)
}

/// H∞ norm of a stable continuous system, and its growth rate (1/s): both from one computation of the poles.
pub(crate) fn hinf_norm_and_growth(
    system: &StateSpace<Continuous>,
    rel_tol: f64,
) -> Result<(HinfNorm, f64), NormError> {
    let poles = system.poles()?;
    let growth_rate = poles.iter().map(|p| p.re).fold(f64::NEG_INFINITY, f64::max);
    if growth_rate >= 0.0 {
        return Err(NormError::Unstable { growth_rate });
    }
    Ok((linf_norm_with(system, &poles, rel_tol)?, growth_rate))
}

/// L∞ norm over the imaginary axis of a system without poles on it, stable or not.
///
/// # Errors
/// [`NumericError`] when an eigenvalue iteration fails or a pole lies on the axis.
pub fn linf_norm(system: &StateSpace<Continuous>, rel_tol: f64) -> Result<HinfNorm, NumericError> {
    linf_norm_with(system, &system.poles()?, rel_tol)
}

/// H∞ norm of a stable sampled system: the bilinear map z = (1 + sT/2)/(1 − sT/2) keeps the gain on the boundary.
///
/// # Errors
/// [`NormError::Unstable`] when a pole is not inside the unit circle.
pub fn hinf_norm_discrete(system: &StateSpace<Discrete>, rel_tol: f64) -> Result<HinfNorm, NormError> {
    hinf_norm_with_poles(system, &system.poles()?, rel_tol)
}

/// [`hinf_norm_discrete`] of a system with these poles.
pub(crate) fn hinf_norm_with_poles(
    system: &StateSpace<Discrete>,
    poles: &[c64],
    rel_tol: f64,
) -> Result<HinfNorm, NormError> {
    let growth_rate = system.time.largest_growth_rate(poles);
    if growth_rate >= 0.0 {
        return Err(NormError::Unstable { growth_rate });
    }
    // Poles of the mapped system.
    let unit = 2.0 / system.time.period_s;
    let mapped: Vec<c64> = poles.iter().map(|z| (z - 1.0) / (z + 1.0) * unit).collect();
    let mapped = linf_norm_with(&inverse_tustin(system)?, &mapped, rel_tol)?;
    Ok(HinfNorm { peak_omega_rad_s: system.time.true_frequency(mapped.peak_omega_rad_s), ..mapped })
}

/// Whether the gain of a sampled system, which the caller knows to be stable, stays below `level` at every frequency.
/// One eigenvalue problem, no search: where H(γ) has an eigenvalue on the axis, or near it, the gain itself decides
/// there and between its neighbours.
/// `planes` are those of the states, where two planes may be equal.
/// The frequency (rad/s) and gain of the largest value met come with the answer.
pub(crate) fn stays_below(
    system: &StateSpace<Discrete>,
    level: f64,
    planes: Option<&EqualPlanes>,
) -> Result<(bool, f64, f64), NumericError> {
    let mapped = inverse_tustin(system)?;
    let scale = balancing(&mapped);
    let s = mapped.scale_states(&match planes {
        Some(planes) => planes.with_equal_partners(&scale),
        None => scale,
    });
    let mut met = (max_singular_value(&s.d), f64::INFINITY);
    if met.0 < level {
        let h = hamiltonian(&s, level)?;
        // States, then costates.
        let both = planes.map(|planes| planes.followed_by(planes));
        let mut near = axis_frequencies(&EqualPlanes::eigenvalues_on(both.as_ref(), &h)?);
        let between: Vec<f64> = near.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
        near.extend(between);
        let responder = (!near.is_empty()).then(|| FrequencyResponder::new(&s));
        for (omega, responder) in near.into_iter().zip(responder.iter().cycle()) {
            let gain = max_singular_value_complex(&responder.at_or_infinity(omega));
            // NaN stands for a pole on the axis.
            if gain.is_nan() || gain > met.0 {
                met = (if gain.is_nan() { f64::INFINITY } else { gain }, omega);
            }
        }
    }
    Ok((met.0 < level, system.time.true_frequency(met.1), met.0))
}

/// Frequencies at which to look first: pole moduli and resonances, and a log grid three decades beyond them.
pub fn seeds(poles: &[c64]) -> Vec<f64> {
    let mut list = Vec::with_capacity(poles.len() + 48);
    for p in poles.iter().filter(|p| p.im >= 0.0 && p.norm() > 0.0) {
        list.push(p.norm());
        // Modulus, damped frequency and peak differ by ζ²: below a damping of 0.03 by less than the width of the peak.
        if p.im > 0.0 && p.re.abs() > 0.03 * p.im {
            list.push(p.im);
            list.push((p.im * p.im - p.re * p.re).max(0.0).sqrt());
        }
    }
    list.retain(|w| *w > 0.0);
    let lo = list.iter().copied().fold(f64::INFINITY, f64::min);
    let hi = list.iter().copied().fold(0.0, f64::max);
    if hi > 0.0 {
        // Poles at rounding level would stretch the grid without adding a place to look.
        let lo = lo.max(1e-9 * hi) / 1e3;
        let points = 40;
        let ratio = (1e3 * hi / lo).powf(1.0 / f64::from(points));
        list.extend((0..=points).map(|k| lo * ratio.powi(k)));
    }
    list.sort_by(f64::total_cmp);
    list.dedup();
    list
}

/// The frequencies of [`seeds`], zero and infinity, with their values.
pub(crate) fn places(poles: &[c64], value: &(dyn Fn(f64) -> f64 + Sync)) -> Vec<(f64, f64)> {
    let mut list = seeds(poles);
    list.extend([0.0, f64::INFINITY]);
    list.into_par_iter().with_min_len(SIDE_BY_SIDE).map(|omega| (omega, value(omega))).collect()
}

/// Frequencies that one thread takes at least: one of a small system takes as long as handing it on.
const SIDE_BY_SIDE: usize = 8;

fn linf_norm_with(system: &StateSpace<Continuous>, poles: &[c64], rel_tol: f64) -> Result<HinfNorm, NumericError> {
    let direct = max_singular_value(&system.d);
    if system.order() == 0 || system.inputs() == 0 || system.outputs() == 0 {
        return Ok(HinfNorm { norm: direct, peak_omega_rad_s: f64::INFINITY, upper: direct });
    }
    let s = system.scale_states(&balancing(system));
    let responder = FrequencyResponder::new(&s);
    let value = |w: f64| {
        let v = max_singular_value_complex(&responder.at_or_infinity(w));
        if v.is_nan() { f64::INFINITY } else { v }
    };
    // Gains below rounding of B, C and D are zero.
    let floor = f64::EPSILON * f64::EPSILON * (direct + s.b.norm_l2() * s.c.norm_l2());
    if floor == 0.0 {
        return Ok(HinfNorm { norm: 0.0, peak_omega_rad_s: 0.0, upper: 0.0 });
    }
    let found = peak(&value, &places(poles, &value), floor, &|g| hamiltonian(&s, g), rel_tol)?;
    let zero = found.lower <= floor;
    Ok(HinfNorm { norm: if zero { 0.0 } else { found.lower }, peak_omega_rad_s: found.omega_rad_s, upper: found.upper })
}

/// H(γ) of the module for balanced states: axis eigenvalues jω are the frequencies where a gain meets γ.
pub(crate) fn hamiltonian(s: &StateSpace<Continuous>, gamma: f64) -> Result<Mat<f64>, NumericError> {
    let (n, m) = (s.order(), s.inputs());
    let dtd = s.d.transpose() * &s.d;
    // Everything is divided by γ: gains of 1e±8 stay in range.
    let r = Mat::from_fn(m, m, |i, j| f64::from(u8::from(i == j)) - dtd[(i, j)] / gamma / gamma);
    let dtc = s.d.transpose() * &s.c;
    let x = solve(&r, &s.b.transpose().to_owned())?;
    let y = solve(&r, &dtc)?;
    let (bx, by) = (&s.b * &x, &s.b * &y);
    let (cc, dy) = (s.c.transpose() * &s.c, dtc.transpose() * &y);
    Ok(Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => s.a[(i, j)] + by[(i, j)] / gamma / gamma,
        (true, false) => bx[(i, j - n)] / gamma,
        (false, true) => -(cc[(i - n, j)] + dy[(i - n, j)] / gamma / gamma) / gamma,
        (false, false) => -s.a[(j - n, i - n)] - by[(j - n, i - n)] / gamma / gamma,
    }))
}
