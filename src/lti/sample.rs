//! From continuous to sampled time and back: zero-order hold, first-order hold, impulse invariance, Tustin's rule,
//! Tustin with prewarping.
//! Hold: [Ad Bd; 0 I] = exp([A B; 0 0]·T). Tustin: s = k(z − 1)/(z + 1), k = 2/T, or ω/tan(ωT/2) when prewarped at ω.
//! The bilinear formulas keep H∞ norm, Hankel values and stability (Ad is the Cayley transform of A).

use super::connect::series;
use super::delay::{hold, sample_with_delay};
use super::scale::dynamics_scale;
use super::state_space::{Continuous, Discrete, StateSpace, TimeBase};
use crate::linalg::{Mat, NumericError, c64, eigenvalues, solve};

/// Zero-order hold: exact at the sample instants for inputs that are constant in between.
///
/// # Errors
/// [`NumericError`] for a period that is not positive, or an exponential that overflows.
pub fn zoh(system: &StateSpace<Continuous>, period_s: f64) -> Result<StateSpace<Discrete>, NumericError> {
    positive(period_s, "sample period")?;
    in_even_states(system, |s| {
        let (a, b) = hold(&s.a, &s.b, period_s)?;
        StateSpace::new(a, b, s.c.clone(), s.d.clone(), Discrete { period_s })
    })
}

/// [`zoh`] with all inputs late by any time `delay_s` ≥ 0: whole samples as a shift register behind the states, a
/// fraction by splitting the hold. Exact at the sample instants.
///
/// # Errors
/// As [`zoh`].
pub fn zoh_with_delay(
    system: &StateSpace<Continuous>,
    period_s: f64,
    delay_s: f64,
) -> Result<StateSpace<Discrete>, NumericError> {
    positive(period_s, "sample period")?;
    in_even_states(system, |s| sample_with_delay(s, s.inputs(), delay_s, period_s))
}

/// First-order hold: exact at the sample instants for inputs that run straight from sample to sample. With
/// Γ₁ = ∫e^{As}ds B and Γ₂ = ∫(T − s)e^{As}ds B/T: Bd = Γ₁ − Γ₂ + AdΓ₂, Dd = D + CΓ₂ (Franklin, Powell and Workman,
/// Digital Control of Dynamic Systems, section 6.3.2).
///
/// # Errors
/// As [`zoh`].
pub fn foh(system: &StateSpace<Continuous>, period_s: f64) -> Result<StateSpace<Discrete>, NumericError> {
    positive(period_s, "sample period")?;
    let (n, m) = (system.order(), system.inputs());
    in_even_states(system, |s| {
        // The input as a state that a rate drives.
        let ramp = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
            (true, true) => s.a[(i, j)],
            (true, false) => s.b[(i, j - n)],
            _ => 0.0,
        });
        let rate = Mat::from_fn(n + m, m, |i, j| if i == n + j { 1.0 / period_s } else { 0.0 });
        let (state, slope) = hold(&ramp, &rate, period_s)?;
        let part = |matrix: &Mat<f64>, column: usize, width: usize| matrix.submatrix(0, column, n, width).to_owned();
        let (a, level, slope) = (part(&state, 0, n), part(&state, n, m), part(&slope, 0, m));
        let b = &level - &slope + &a * &slope;
        StateSpace::new(a, b, s.c.clone(), &s.d + &s.c * &slope, Discrete { period_s })
    })
}

/// Impulse invariance: the impulse response is the continuous one at the sample instants times T. Bd = T e^{AT}B,
/// Dd = T C B.
///
/// # Errors
/// As [`zoh`], and a feedthrough, whose impulse has no samples.
pub fn match_impulse(system: &StateSpace<Continuous>, period_s: f64) -> Result<StateSpace<Discrete>, NumericError> {
    positive(period_s, "sample period")?;
    let largest = system.d.norm_max();
    if largest > 0.0 {
        return Err(NumericError::Dimension {
            what: "impulse invariance",
            expected: "a system without feedthrough".to_owned(),
            found: format!("D with entries up to {largest}"),
        });
    }
    in_even_states(system, |s| {
        let (a, _) = hold(&s.a, &s.b, period_s)?;
        let b = scale_matrix(&(&a * &s.b), period_s);
        StateSpace::new(a, b, s.c.clone(), scale_matrix(&(&s.c * &s.b), period_s), Discrete { period_s })
    })
}

/// The system with its inputs late by whole samples: a shift register before its states.
///
/// # Errors
/// [`NumericError`] from the connection.
pub fn delay_inputs(system: &StateSpace<Discrete>, samples: usize) -> Result<StateSpace<Discrete>, NumericError> {
    let (m, n) = (system.inputs(), samples * system.inputs());
    if samples == 0 {
        return Ok(system.clone());
    }
    let register = StateSpace::new(
        Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j + m))),
        Mat::from_fn(n, m, |i, j| f64::from(u8::from(i == j))),
        Mat::from_fn(m, n, |i, j| f64::from(u8::from(i + n == j + m))),
        Mat::zeros(m, m),
        system.time,
    )?;
    series(&register, system)
}

/// Tustin's rule, s = (2/T)(z − 1)/(z + 1).
///
/// # Errors
/// [`NumericError`] for a period that is not positive, or a pole at s = 2/T.
pub fn tustin(system: &StateSpace<Continuous>, period_s: f64) -> Result<StateSpace<Discrete>, NumericError> {
    positive(period_s, "sample period")?;
    in_even_states(system, |s| bilinear(s, 2.0 / period_s, period_s))
}

/// Tustin's rule with k = ω/tan(ωT/2): the response at ω is kept exactly.
///
/// # Errors
/// As [`tustin`], and a prewarp frequency that is not between 0 and π/T.
pub fn tustin_prewarped(
    system: &StateSpace<Continuous>,
    period_s: f64,
    omega_rad_s: f64,
) -> Result<StateSpace<Discrete>, NumericError> {
    positive(period_s, "sample period")?;
    positive(omega_rad_s, "prewarp frequency")?;
    let half = 0.5 * omega_rad_s * period_s;
    if half >= std::f64::consts::FRAC_PI_2 {
        return Err(NumericError::Dimension {
            what: "prewarp frequency",
            expected: format!("below pi/T = {:.6e} rad/s", std::f64::consts::PI / period_s),
            found: format!("{omega_rad_s:.6e} rad/s"),
        });
    }
    in_even_states(system, |s| bilinear(s, omega_rad_s / half.tan(), period_s))
}

/// Inverse of [`tustin`], in the same state coordinates: z = (1 + sT/2)/(1 − sT/2). Norm and Hankel values are kept.
///
/// # Errors
/// [`NumericError::PoleAtNyquist`] for a pole at z = −1.
pub fn inverse_tustin(system: &StateSpace<Discrete>) -> Result<StateSpace<Continuous>, NumericError> {
    in_even_states(system, inverse_bilinear)
}

fn inverse_bilinear(system: &StateSpace<Discrete>) -> Result<StateSpace<Continuous>, NumericError> {
    let n = system.order();
    let k = 2.0 / system.time.period_s;
    let one = Mat::<f64>::identity(n, n);
    let plus = &system.a + &one;
    let named = |error| match error {
        NumericError::Singular { .. } => NumericError::PoleAtNyquist,
        other => other,
    };
    let (pa, pb) = (solve(&plus, &(&system.a - &one)).map_err(named)?, solve(&plus, &system.b)?);
    let c = right_divide(&system.c, &plus)?;
    StateSpace::new(
        scale_matrix(&pa, k),
        scale_matrix(&pb, k),
        scale_matrix(&c, 2.0),
        &system.d - &system.c * &pb,
        Continuous,
    )
}

/// With M = kI − A: Ad = M⁻¹(kI + A), Bd = 2M⁻¹B, Cd = k C M⁻¹, Dd = D + C M⁻¹B; the states stay those of A to first
/// order in T.
fn bilinear(system: &StateSpace<Continuous>, k: f64, period_s: f64) -> Result<StateSpace<Discrete>, NumericError> {
    let n = system.order();
    let shift = scale_matrix(&Mat::identity(n, n), k);
    let minus = &shift - &system.a;
    let named = |error| pole_at_centre(&system.a, k).unwrap_or(error);
    let (ad, b) = (solve(&minus, &(&shift + &system.a)).map_err(named)?, solve(&minus, &system.b).map_err(named)?);
    let c = right_divide(&system.c, &minus)?;
    StateSpace::new(ad, scale_matrix(&b, 2.0), scale_matrix(&c, k), &system.d + &system.c * &b, Discrete { period_s })
}

/// The failure of Tustin's rule for a pole where it has its own.
fn pole_at_centre(a: &Mat<f64>, k: f64) -> Option<NumericError> {
    // The accuracy of eigenvalues, some digits above rounding.
    let near = |pole: &c64| (pole - k).norm() <= 1e-12 * (k + a.norm_l2());
    let poles = eigenvalues(a).ok()?;
    poles.iter().any(near).then_some(NumericError::PoleOfMap { map: "Tustin's rule", point: k })
}

/// A map of systems that keeps state coordinates, on even rows and columns of A where they are far from it: a companion
/// form as it is given has entries tens of decades apart.
fn in_even_states<T: TimeBase, U: TimeBase>(
    system: &StateSpace<T>,
    map: impl Fn(&StateSpace<T>) -> Result<StateSpace<U>, NumericError>,
) -> Result<StateSpace<U>, NumericError> {
    let Some(scale) = dynamics_scale(&system.a) else {
        return map(system);
    };
    let mapped = map(&system.scale_states(&scale))?;
    // States of a delay come behind and keep their scale.
    let mut back: Vec<f64> = scale.iter().map(|t| t.recip()).collect();
    back.resize(mapped.order(), 1.0);
    Ok(mapped.scale_states(&back))
}

/// C M⁻¹.
fn right_divide(c: &Mat<f64>, m: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    Ok(solve(&m.transpose().to_owned(), &c.transpose().to_owned())?.transpose().to_owned())
}

fn scale_matrix(m: &Mat<f64>, factor: f64) -> Mat<f64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| factor * m[(i, j)])
}

fn positive(value: f64, what: &'static str) -> Result<(), NumericError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(NumericError::Dimension { what, expected: "a positive number".into(), found: format!("{value}") })
}
