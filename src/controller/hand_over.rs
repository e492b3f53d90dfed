//! Bumpless hand-over: states with which a controller continues another one's output. Of all states with
//! C x + D y = u (u the last output, y the displacement now) it takes those that move the output least afterwards,
//! with y held: the increments u(k+1) − u(k) = C Aᵏ w, w = (A − I) x + B y, have the least sum of squares over a
//! finite horizon, wᵀP w with P = Σ (Aᵀ)ᵏCᵀC Aᵏ. A controller without an integrator then moves to its own output with
//! its slowest poles. The states are a linear map of y and u, computed once: x = G [y; u].

use super::arithmetic::{FixedRow, to_fixed_row};
use super::realise::{ProductTerm, Row};
use super::scaling::ScaledRealisation;
use super::{ControllerError, in_step};
use crate::linalg::{Mat, NumericError, eigenvalues, solve};
use crate::lti::{Discrete, StateSpace};

/// The horizon is 2 to this power of samples: 51 ms at 20 kHz, longer than a levitated rotor takes to settle.
const HORIZON_DOUBLINGS: u32 = 10;
/// A controller with unstable modes of its own has a shorter horizon: until the fastest of them has grown by this
/// factor, six digits in the sum of squares.
const LARGEST_GROWTH: f64 = 1e3;
/// Weight of the states themselves, relative to that of the increments: decides only where the increments do not, nine
/// digits below what counts and seven above rounding.
const STATE_WEIGHT: f64 = 1e-9;

/// G in both arithmetics; sources of the rows are [y; u].
#[derive(Clone, Debug)]
pub struct HandOver {
    /// Scaled states from y (m) and u (A); coefficients exactly representable in single precision.
    pub float32: Vec<Row>,
    /// States from fractions of full scale.
    pub q31: Vec<FixedRow>,
}

/// The map from displacement and last output to the states.
///
/// # Errors
/// [`ControllerError::Numeric`] when the least-squares problem is singular, [`ControllerError::Range`] when a
/// coefficient does not fit Q31.
pub fn hand_over(scaled: &ScaledRealisation) -> Result<HandOver, ControllerError> {
    let system = scaled.rows.to_state_space()?;
    let (input, output) = (scaled.limits.input_m, scaled.limits.output_a);
    let m = system.inputs();
    let map = state_map(&system, input, output)?;
    let rows = |factor: &dyn Fn(usize) -> f64| -> Vec<Row> {
        (0..map.nrows())
            .map(|i| {
                (0..map.ncols()).map(|j| ProductTerm { source: j, coefficient: map[(i, j)] * factor(j) }).collect()
            })
            .collect()
    };
    let single = |row: Row| -> Row {
        row.into_iter().map(|t| ProductTerm { coefficient: f64::from(t.coefficient as f32), ..t }).collect()
    };
    let normalised = rows(&|j| if j < m { input } else { output });
    Ok(HandOver {
        float32: rows(&|_| 1.0).into_iter().map(single).collect(),
        q31: normalised.iter().map(to_fixed_row).collect::<Result<_, _>>()?,
    })
}

/// G (n × (m + p)); the ranges of y and u balance the problem.
fn state_map(system: &StateSpace<Discrete>, input_range: f64, output_range: f64) -> Result<Mat<f64>, ControllerError> {
    let (n, m, p) = (system.order(), system.inputs(), system.outputs());
    if n == 0 {
        return Ok(Mat::zeros(0, m + p));
    }
    let b = times(&system.b, input_range);
    let c = times(&system.c, 1.0 / output_range);
    let d = times(&system.d, input_range / output_range);
    let weight = output_energy(&system.a, &c).map_err(in_step("bumpless hand-over"))?;
    let step = &system.a - Mat::<f64>::identity(n, n);
    let mut cost = step.transpose() * &weight * &step;
    let mean = (0..n).map(|i| cost[(i, i)]).sum::<f64>() / n as f64;
    for i in 0..n {
        cost[(i, i)] += STATE_WEIGHT * if mean > 0.0 { mean } else { 1.0 };
    }
    let named = in_step("bumpless hand-over");
    // Without the condition: x₀ = −H⁻¹ (A − I)ᵀ P B y. With it: x = x₀ + H⁻¹Cᵀ(C H⁻¹Cᵀ)⁻¹ (u − D y − C x₀).
    let pull = step.transpose() * &weight * &b;
    let free = times(&solve(&cost, &pull).map_err(&named)?, -1.0);
    let reach = solve(&cost, &c.transpose().to_owned()).map_err(&named)?;
    let mut gain = &c * &reach;
    let largest = gain.norm_max();
    for i in 0..p {
        // An output that no state reaches cannot be continued; the term keeps it from dividing by zero.
        gain[(i, i)] += if largest > 0.0 { 1e-13 * largest } else { 1.0 };
    }
    let missing = times(&(&c * &free + &d), -1.0);
    let corrected = solve(&gain, &missing).map_err(&named)?;
    let continued = solve(&gain, &Mat::identity(p, p)).map_err(&named)?;
    let from_y = &free + &reach * &corrected;
    let from_u = &reach * &continued;
    Ok(Mat::from_fn(
        n,
        m + p,
        |i, j| {
            if j < m { from_y[(i, j)] / input_range } else { from_u[(i, j - m)] / output_range }
        },
    ))
}

fn times(matrix: &Mat<f64>, factor: f64) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| factor * matrix[(i, j)])
}

/// Σ (Aᵀ)ᵏCᵀC Aᵏ over the horizon, by doubling.
fn output_energy(a: &Mat<f64>, c: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    let poles = eigenvalues(a)?;
    let radius = poles.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let doublings = if radius > 1.0 {
        let samples = LARGEST_GROWTH.ln() / radius.ln();
        (samples.max(1.0).log2() as u32).min(HORIZON_DOUBLINGS)
    } else {
        HORIZON_DOUBLINGS
    };
    let (mut sum, mut power) = (c.transpose() * c, a.to_owned());
    for _ in 0..doublings {
        sum = &sum + power.transpose() * &sum * &power;
        power = &power * &power;
    }
    Ok(sum)
}
