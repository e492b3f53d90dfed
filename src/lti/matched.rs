//! Matched poles and zeros: every pole and zero s goes to z = e^{sT}; zeros at infinity but one go to z = −1, the last
//! one stays, as between u(k) and y(k + 1); the gain is that of s → 0, after roots at zero are taken out on both sides
//! (Franklin, Powell and Workman, Digital Control of Dynamic Systems, section 6.3). One input and one output.

use super::connect::series;
use super::scale::balancing_of_dynamics;
use super::state_space::{Continuous, Discrete, StateSpace, TimeBase};
use super::zeros::{roots_off_zero, siso_zeros};
use crate::linalg::{Mat, NumericError, c64};

/// The sampled system with matched poles and zeros, in states of its own.
///
/// # Errors
/// [`NumericError`] for a period that is not positive, more than one input or output, an eigenvalue iteration that
/// fails, or a root whose image overflows.
pub fn match_roots(system: &StateSpace<Continuous>, period_s: f64) -> Result<StateSpace<Discrete>, NumericError> {
    let refused = |what, expected: &str, found: String| {
        Err(NumericError::Dimension { what, expected: expected.to_owned(), found })
    };
    if !(period_s.is_finite() && period_s > 0.0) {
        return refused("sample period", "a positive number", period_s.to_string());
    }
    if system.inputs() != 1 || system.outputs() != 1 {
        let found = format!("{} inputs and {} outputs", system.inputs(), system.outputs());
        return refused("matched poles and zeros", "one input and one output", found);
    }
    let time = Discrete { period_s };
    let even = system.scale_states(&balancing_of_dynamics(system));
    let poles = even.poles()?;
    let fastest = poles.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let radius = if fastest > 0.0 { fastest } else { 1.0 / period_s };
    let found = siso_zeros(&even, radius)?;
    if found.value == 0.0 || poles.is_empty() {
        return Ok(StateSpace::gain(system.d.clone(), time));
    }
    let (n, m) = (poles.len(), found.zeros.len());
    let (poles, zeros) = (roots_off_zero(poles, radius), roots_off_zero(found.zeros, radius));
    let at_zero = [n - poles.len(), m - zeros.len()];
    // G = g s^−k Π(1 − s/zero)/Π(1 − s/pole).
    let surplus = at_zero[0] as i32 - at_zero[1] as i32;
    let product = |roots: &[c64]| roots.iter().fold(c64::new(1.0, 0.0), |p, r| p * (1.0 - found.point / r)).re;
    let gain = found.value * found.point.powi(surplus) * product(&poles) / product(&zeros);
    let at_minus_one = (n - m).saturating_sub(1);
    // Π(1 − e^{sT}) over roots off zero.
    let images = |roots: &[c64]| roots.iter().fold(c64::new(1.0, 0.0), |p, r| p * -exp_minus_one(r * period_s)).re;
    let factor = gain * images(&poles) / images(&zeros) / 2f64.powi(at_minus_one as i32) * period_s.powi(surplus);
    let image = |roots: &[c64], ones: usize| -> Vec<c64> {
        let ones = std::iter::repeat_n(c64::new(1.0, 0.0), ones);
        roots.iter().map(|r| (r * period_s).exp()).chain(ones).collect()
    };
    let mut all_zeros = image(&zeros, at_zero[1]);
    all_zeros.extend(std::iter::repeat_n(c64::new(-1.0, 0.0), at_minus_one));
    chain(&image(&poles, at_zero[0]), &all_zeros, factor, time)
}

/// eˣ − 1 without cancellation.
fn exp_minus_one(x: c64) -> c64 {
    // Re: e^a cos b − 1 = (e^a − 1) cos b − 2 sin²(b/2).
    let (grown, half) = (x.re.exp_m1(), (0.5 * x.im).sin());
    c64::new(grown * x.im.cos() - 2.0 * half * half, x.re.exp() * x.im.sin())
}

/// factor Π(z − zero)/Π(z − pole) as a chain of systems of order one and two; no more zeros than poles, complex ones in
/// exact conjugate pairs.
pub(crate) fn chain<T: TimeBase>(
    poles: &[c64],
    zeros: &[c64],
    factor: f64,
    time: T,
) -> Result<StateSpace<T>, NumericError> {
    let (poles, mut zeros) = (groups(poles), groups(zeros));
    let mut chain = StateSpace::gain(Mat::from_fn(1, 1, |_, _| factor), time);
    for poles in poles {
        let fitting = zeros.iter().position(|group| group.len() <= poles.len());
        let own = fitting.map(|k| zeros.remove(k)).unwrap_or_default();
        chain = series(&chain, &section(&poles, &own, time)?)?;
    }
    Ok(chain)
}

/// Pairs of conjugate or of real roots, a single real one last.
fn groups(roots: &[c64]) -> Vec<Vec<c64>> {
    let mut list: Vec<Vec<c64>> = roots.iter().filter(|r| r.im > 0.0).map(|r| vec![*r, r.conj()]).collect();
    let real: Vec<c64> = roots.iter().filter(|r| r.im == 0.0).copied().collect();
    list.extend(real.chunks(2).map(<[c64]>::to_vec));
    list
}

/// Π(z − zero)/Π(z − pole) in companion form, one or two poles.
fn section<T: TimeBase>(poles: &[c64], zeros: &[c64], time: T) -> Result<StateSpace<T>, NumericError> {
    // Coefficients after the leading one.
    let rest = |roots: &[c64]| match roots {
        [] => vec![],
        [r] => vec![-r.re],
        [r, s, ..] => vec![-(r + s).re, (r * s).re],
    };
    let (n, lower, m) = (poles.len(), rest(poles), zeros.len());
    let upper = |k: usize| match (k + m).cmp(&n) {
        std::cmp::Ordering::Less => 0.0,
        std::cmp::Ordering::Equal => 1.0,
        std::cmp::Ordering::Greater => rest(zeros)[k + m - n - 1],
    };
    companion(upper, &lower, time)
}

/// Companion form of (u₀ sⁿ + … + uₙ)/(sⁿ + l₁ sⁿ⁻¹ + … + lₙ); `lower` begins with l₁.
pub(crate) fn companion<T: TimeBase>(
    upper: impl Fn(usize) -> f64,
    lower: &[f64],
    time: T,
) -> Result<StateSpace<T>, NumericError> {
    let (n, direct) = (lower.len(), upper(0));
    StateSpace::new(
        Mat::from_fn(n, n, |i, j| if i == 0 { -lower[j] } else { f64::from(u8::from(i == j + 1)) }),
        Mat::from_fn(n, 1, |i, _| f64::from(u8::from(i == 0))),
        Mat::from_fn(1, n, |_, j| upper(j + 1) - direct * lower[j]),
        Mat::from_fn(1, 1, |_, _| direct),
        time,
    )
}
