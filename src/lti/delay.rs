//! Pure delays as systems: Padé approximant in continuous time, shift registers and split holds in sampled time.

use super::state_space::{Continuous, Discrete, StateSpace};
use crate::linalg::equal_planes::EqualPlanes;
use crate::linalg::exponential::exponentials;
use crate::linalg::{Mat, NumericError};

/// Diagonal Padé approximant of e^{−sτ} of order n, D(−s)/D(s) with
/// D(s) = Σ_k (2n−k)! n!/((2n)! k! (n−k)!) (τs)^k (Golub and Van Loan, section 9.3.1), states scaled by 1/τ.
/// Order 0 is the gain 1.
pub(crate) fn pade_delay(delay_s: f64, order: usize) -> Result<StateSpace<Continuous>, NumericError> {
    let n = order;
    let mut coefficient = vec![1.0; n + 1];
    for k in 0..n {
        coefficient[k + 1] = coefficient[k] * (n - k) as f64 / ((2 * n - k) as f64 * (k + 1) as f64);
    }
    let (lead, rate) = (coefficient[n], 1.0 / delay_s);
    let a = Mat::from_fn(n, n, |i, j| {
        if i + 1 < n { f64::from(u8::from(j == i + 1)) * rate } else { -rate * coefficient[j] / lead }
    });
    let b = Mat::from_fn(n, 1, |i, _| if i + 1 == n { rate } else { 0.0 });
    // D(−s) = ±D(s) + twice the terms of the other parity.
    let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    let c = Mat::from_fn(1, n, |_, j| {
        let own = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
        (own - sign) * coefficient[j] / lead
    });
    StateSpace::new(a, b, c, Mat::from_fn(1, 1, |_, _| sign), Continuous)
}

/// Hold equivalents over `seconds`: (e^{At}, ∫₀ᵗ e^{As}ds B).
///
/// # Errors
/// [`NumericError`] from the exponential.
pub fn hold(a: &Mat<f64>, b: &Mat<f64>, seconds: f64) -> Result<(Mat<f64>, Mat<f64>), NumericError> {
    let [held] = holds(a, b, [seconds], None)?;
    Ok(held)
}

/// [`hold`] over several times. `planes` are those of the states, then of the inputs, where two planes may be equal.
fn holds<const K: usize>(
    a: &Mat<f64>,
    b: &Mat<f64>,
    seconds: [f64; K],
    planes: Option<&EqualPlanes>,
) -> Result<[(Mat<f64>, Mat<f64>); K], NumericError> {
    let (n, m) = (a.nrows(), b.ncols());
    // Inputs in a unit, a power of two, in which they weigh as much as the states: their rows are zero, so that
    // balancing leaves them.
    let ratio = (b.norm_max() / a.norm_max()).log2().round().exp2();
    let unit = if ratio.is_normal() { ratio } else { 1.0 };
    let block = Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => a[(i, j)],
        (true, false) => b[(i, j - n)] / unit,
        _ => 0.0,
    });
    let parts = |e: Mat<f64>| (e.submatrix(0, 0, n, n).to_owned(), Mat::from_fn(n, m, |i, j| e[(i, n + j)] * unit));
    Ok(exponentials(&block, seconds, planes)?.map(parts))
}

/// Sampled equivalent of a continuous system with zero-order hold on every input, its first `delayed` inputs reaching
/// it `delay_s` later than the others: whole samples as a shift register, a fraction by splitting the hold. Exact.
///
/// # Errors
/// [`NumericError`] from the exponential.
pub fn sample_with_delay(
    system: &StateSpace<Continuous>,
    delayed: usize,
    delay_s: f64,
    period_s: f64,
) -> Result<StateSpace<Discrete>, NumericError> {
    sample_planes(system, delayed, delay_s, period_s, None)
}

/// [`sample_with_delay`] of a system whose states and then inputs belong to `planes`, which may be equal.
pub(crate) fn sample_planes(
    system: &StateSpace<Continuous>,
    delayed: usize,
    delay_s: f64,
    period_s: f64,
    planes: Option<&EqualPlanes>,
) -> Result<StateSpace<Discrete>, NumericError> {
    let (n, m) = (system.order(), system.inputs());
    let ratio = (delay_s / period_s).max(0.0);
    // A fraction below a billionth of a sample is rounding of the decimal inputs.
    let whole = (ratio + 1e-9).floor() as usize;
    let late = (ratio - whole as f64).max(0.0) * period_s;
    let split = late > 1e-9 * period_s;
    let continuous = (&system.a, &system.b);
    let (a_full, b_full, b_new, b_old) = if split {
        let [(a_late, b_late), (a_rest, b_rest)] = holds(continuous.0, continuous.1, [late, period_s - late], planes)?;
        // What the first part of the sample does goes on through the second.
        let b_early = &a_rest * &b_late;
        let of_commands = |b: &Mat<f64>| b.subcols(0, delayed).to_owned();
        let (b_new, b_old) = (of_commands(&b_rest), of_commands(&b_early));
        (&a_rest * &a_late, b_rest + b_early, b_new, b_old)
    } else {
        let [(a_full, b_full)] = holds(continuous.0, continuous.1, [period_s], planes)?;
        let b_new = b_full.subcols(0, delayed).to_owned();
        (a_full, b_full, b_new, Mat::zeros(n, delayed))
    };
    // Registers, newest command first: u(k−1), …, u(k−steps).
    let steps = whole + usize::from(split);
    let order = n + steps * delayed;
    let register = |age: usize, j: usize| n + (age - 1) * delayed + j;
    let mut a = Mat::zeros(order, order);
    let mut b = Mat::zeros(order, m);
    let mut c = Mat::zeros(system.outputs(), order);
    let mut d = system.d.clone();
    for i in 0..n {
        for j in 0..n {
            a[(i, j)] = a_full[(i, j)];
        }
        for j in 0..delayed {
            if whole == 0 {
                b[(i, j)] = b_new[(i, j)];
            } else {
                a[(i, register(whole, j))] = b_new[(i, j)];
            }
            if split {
                a[(i, register(whole + 1, j))] = b_old[(i, j)];
            }
        }
        for j in delayed..m {
            b[(i, j)] = b_full[(i, j)];
        }
    }
    for j in 0..delayed {
        if steps > 0 {
            b[(register(1, j), j)] = 1.0;
        }
        for age in 1..steps {
            a[(register(age + 1, j), register(age, j))] = 1.0;
        }
    }
    for i in 0..system.outputs() {
        for j in 0..n {
            c[(i, j)] = system.c[(i, j)];
        }
        // At a sample instant the feedthrough of a late command still is the older one.
        for j in 0..delayed {
            if steps > 0 {
                c[(i, register(steps, j))] = d[(i, j)];
                d[(i, j)] = 0.0;
            }
        }
    }
    StateSpace::new(a, b, c, d, Discrete { period_s })
}
