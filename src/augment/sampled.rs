//! The plane as the sampled loop sees it, in the w plane of synthesis.
//!
//! Direct design: zero-order hold on every input, the delay beyond the hold's half sample as exact delay
//! (whole samples as shift registers, a fraction by splitting the hold), then the bilinear map
//! z = (1 + wT/2)/(1 − wT/2). A controller found in w goes back through the same map without any loss.
//! Emulation: continuous time with a Padé approximant of the whole delay.

use super::plane::{LOOPS, PlaneModel, before_commands};
use crate::linalg::{Mat, NumericError, exponential, solve};
use crate::lti::connect::append;
use crate::lti::{Continuous, Discrete, StateSpace};

/// Plane with hold and exact delay as a sampled system; ports as [`PlaneModel::state_space`].
///
/// # Errors
/// [`NumericError`] from the exponential.
pub fn sampled_plane(
    model: &PlaneModel,
    uncertain: &[usize],
) -> Result<StateSpace<Discrete>, NumericError> {
    let period = model.sample_time_s;
    let plane = model.state_space(uncertain)?;
    let pure_delay = (model.delay_s - 0.5 * period).max(0.0);
    // A fraction below a billionth of a sample is rounding of the decimal inputs.
    let samples = (pure_delay / period + 1e-9).floor();
    let fraction =
        ((pure_delay / period - samples).max(0.0) > 1e-9).then_some(pure_delay - samples * period);
    let (n, m) = (plane.order(), plane.inputs());
    let others = m - LOOPS;
    let (a_full, b_full) = hold(&plane.a, &plane.b, period)?;
    let time = Discrete { period_s: period };
    let Some(late) = fraction else {
        let sampled = StateSpace::new(a_full, b_full, plane.c.clone(), plane.d.clone(), time)?;
        return before_commands(&sampled, &shift_register(samples as usize, time));
    };
    // The old command acts during the first `late` seconds, the new one for the rest of the period.
    let bu = plane.b.submatrix(0, others, n, LOOPS).to_owned();
    let (a_rest, b_new) = hold(&plane.a, &bu, period - late)?;
    let (_, b_late) = hold(&plane.a, &bu, late)?;
    let b_old = &a_rest * &b_late;
    let order = n + LOOPS;
    let a = Mat::from_fn(order, order, |i, j| match (i < n, j < n) {
        (true, true) => a_full[(i, j)],
        (true, false) => b_old[(i, j - n)],
        _ => 0.0,
    });
    let b = Mat::from_fn(order, m, |i, j| match (i < n, j < others) {
        (true, true) => b_full[(i, j)],
        (true, false) => b_new[(i, j - others)],
        (false, true) => 0.0,
        (false, false) => f64::from(u8::from(i - n == j - others)),
    });
    let c = Mat::from_fn(plane.outputs(), order, |i, j| {
        if j < n { plane.c[(i, j)] } else { 0.0 }
    });
    let sampled = StateSpace::new(a, b, c, plane.d.clone(), time)?;
    before_commands(&sampled, &shift_register(samples as usize, time))
}

/// Plane in continuous time with a Padé approximant of `order` for the whole delay.
///
/// # Errors
/// [`NumericError`] as [`PlaneModel::state_space`].
pub fn continuous_plane(
    model: &PlaneModel,
    uncertain: &[usize],
    order: usize,
) -> Result<StateSpace<Continuous>, NumericError> {
    let plane = model.state_space(uncertain)?;
    if model.delay_s <= 0.0 || order == 0 {
        return Ok(plane);
    }
    let one = pade(model.delay_s, order)?;
    before_commands(&plane, &append(&one, &one))
}

/// Diagonal Padé approximant of e^{−sτ} of order n in controller form: D(−s)/D(s),
/// D(s) = Σ (2n−k)! n!/((2n)! k! (n−k)!) (τs)^k (Golub and Van Loan, section 9.3.1).
///
/// # Errors
/// [`NumericError`] when the delay is not finite.
pub fn pade(delay_s: f64, order: usize) -> Result<StateSpace<Continuous>, NumericError> {
    let n = order;
    // Coefficients of τˢ powers, with states scaled by 1/τ to keep numbers of order one.
    let mut coefficient = vec![1.0; n + 1];
    for k in 0..n {
        coefficient[k + 1] =
            coefficient[k] * (n - k) as f64 / ((2 * n - k) as f64 * (k + 1) as f64);
    }
    let lead = coefficient[n];
    let rate = 1.0 / delay_s;
    let a = Mat::from_fn(n, n, |i, j| {
        if i + 1 < n {
            if j == i + 1 { rate } else { 0.0 }
        } else {
            -rate * coefficient[j] / lead
        }
    });
    let b = Mat::from_fn(n, 1, |i, _| if i + 1 == n { rate } else { 0.0 });
    let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
    // Numerator minus sign·denominator leaves the coefficients of one parity, doubled.
    let c = Mat::from_fn(1, n, |_, j| {
        let numerator = if j % 2 == 0 {
            coefficient[j]
        } else {
            -coefficient[j]
        };
        (numerator - sign * coefficient[j]) / lead
    });
    StateSpace::new(a, b, c, Mat::from_fn(1, 1, |_, _| sign), Continuous)
}

/// The sampled system in the w plane, s = (2/T)(z − 1)/(z + 1): same transfer matrix at z = (1 + sT/2)/(1 − sT/2).
///
/// # Errors
/// [`NumericError::Singular`] when z = −1 is a pole.
pub fn to_w_plane(sampled: &StateSpace<Discrete>) -> Result<StateSpace<Continuous>, NumericError> {
    let (n, period) = (sampled.order(), sampled.time.period_s);
    let plus = Mat::<f64>::identity(n, n) + &sampled.a;
    // (I + Φ)⁻¹ [Φ − I, Γ]: with X = (I + Φ)⁻¹, A = (2/T) X(Φ − I), B = (2/T) X Γ, C = 2C X… kept symmetric in √T.
    let minus = &sampled.a - Mat::<f64>::identity(n, n);
    let right = solve(&plus, &minus)?;
    let xb = solve(&plus, &sampled.b)?;
    let xc = solve(
        &plus.transpose().to_owned(),
        &sampled.c.transpose().to_owned(),
    )?;
    let root = (2.0f64 / period).sqrt() * 2f64.sqrt();
    let a = Mat::from_fn(n, n, |i, j| 2.0 / period * right[(i, j)]);
    let b = Mat::from_fn(n, sampled.inputs(), |i, j| root * xb[(i, j)]);
    let c = Mat::from_fn(sampled.outputs(), n, |i, j| root * xc[(j, i)]);
    let d = &sampled.d - &sampled.c * &xb;
    StateSpace::new(a, b, c, d, Continuous)
}

/// Back from the w plane: Tustin's map, z = (1 + sT/2)/(1 − sT/2).
///
/// # Errors
/// [`NumericError::Singular`] when s = 2/T is a pole.
pub fn from_w_plane(
    system: &StateSpace<Continuous>,
    period_s: f64,
) -> Result<StateSpace<Discrete>, NumericError> {
    let n = system.order();
    let half = 0.5 * period_s;
    let scaled = |sign: f64| {
        Mat::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) + sign * half * system.a[(i, j)]
        })
    };
    let minus = scaled(-1.0);
    let a = solve(&minus, &scaled(1.0))?;
    let xb = solve(&minus, &system.b)?;
    let xc = solve(
        &minus.transpose().to_owned(),
        &system.c.transpose().to_owned(),
    )?;
    let root = period_s.sqrt();
    let b = Mat::from_fn(n, system.inputs(), |i, j| root * xb[(i, j)]);
    let c = Mat::from_fn(system.outputs(), n, |i, j| root * xc[(j, i)]);
    let d_extra = &system.c * &xb;
    let d = Mat::from_fn(system.outputs(), system.inputs(), |i, j| {
        system.d[(i, j)] + half * d_extra[(i, j)]
    });
    StateSpace::new(a, b, c, d, Discrete { period_s })
}

/// Φ = e^{Ah} and Γ = ∫₀ʰ e^{Aτ}dτ B from one exponential of [[A, B], [0, 0]]h (Van Loan 1978).
fn hold(a: &Mat<f64>, b: &Mat<f64>, step_s: f64) -> Result<(Mat<f64>, Mat<f64>), NumericError> {
    let (n, m) = (a.nrows(), b.ncols());
    let joint = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => a[(i, j)] * step_s,
        (true, false) => b[(i, j - n)] * step_s,
        _ => 0.0,
    });
    let e = exponential(&joint)?;
    Ok((
        e.submatrix(0, 0, n, n).to_owned(),
        e.submatrix(0, n, n, m).to_owned(),
    ))
}

/// z^{−samples} for each command.
fn shift_register(samples: usize, time: Discrete) -> StateSpace<Discrete> {
    let n = samples * LOOPS;
    if n == 0 {
        return StateSpace::gain(Mat::identity(LOOPS, LOOPS), time);
    }
    let link = |to: usize, from: usize| f64::from(u8::from(to == from));
    StateSpace {
        a: Mat::from_fn(
            n,
            n,
            |i, j| if i >= LOOPS { link(i - LOOPS, j) } else { 0.0 },
        ),
        b: Mat::from_fn(n, LOOPS, link),
        c: Mat::from_fn(LOOPS, n, |i, j| link(n - LOOPS + i, j)),
        d: Mat::zeros(LOOPS, LOOPS),
        time,
    }
}
