//! A continuous controller K(s) that approximates a sampled one: poles s = ln(z)/Tₛ, and the C and D with which K(jω)
//! comes closest to K(e^{jωTₛ}) in the least-squares sense, each frequency weighted by 1/‖K‖. The hold is not part of
//! it. Blocks whose poles have no useful logarithm (at and left of zero, repeated ones) are mapped by the bilinear rule
//! instead. Near the Nyquist frequency no K(s) approximates a sampled controller well: the error over frequency is part
//! of the result.

use super::modal::block_diagonalise;
use super::{ControllerError, in_step};
use crate::linalg::{Mat, NumericError, c64, max_singular_value_complex, solve, solve_complex};
use crate::lti::{Continuous, Discrete, StateSpace};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Share of the Nyquist frequency up to which K(s) is fitted and its error stated.
pub(crate) const FITTED_SHARE: f64 = 0.5;
/// Frequencies of the fit, evenly in the logarithm over four decades below its end.
const FREQUENCIES: usize = 240;
/// Poles whose angle lies beyond this share of the half circle lie where nothing is fitted; their logarithm jumps to
/// the conjugate pole.
const LARGEST_ANGLE: f64 = 0.9 * PI;
/// A modal pair is a rotation up to this, relative to its size; other pairs are nearly a double real pole.
const ROTATION: f64 = 1e-6;

/// K(s) with its error.
#[derive(Clone, Debug)]
pub struct ContinuousFit {
    /// The continuous controller, same order.
    pub law: StateSpace<Continuous>,
    /// (frequency, Hz; largest singular value of the difference over that of the sampled controller).
    pub relative_error: Vec<(f64, f64)>,
}

impl ContinuousFit {
    /// Largest relative error up to a frequency.
    pub fn error_to(&self, frequency_hz: f64) -> f64 {
        let below = self.relative_error.iter().filter(|p| p.0 <= frequency_hz);
        below.map(|p| p.1).fold(0.0, f64::max)
    }
}

/// Fits K(s) to a sampled controller.
///
/// # Errors
/// [`ControllerError::Numeric`] when an eigenvalue iteration fails, the fit is singular or a pole lies at z = −1;
/// [`ControllerError::Inaccurate`] when no block form reproduces the transfer matrix.
pub fn continuous_fit(law: &StateSpace<Discrete>) -> Result<ContinuousFit, ControllerError> {
    let named = in_step("continuous approximation");
    let modal = block_diagonalise(law)?;
    let system = &modal.system;
    let period_s = law.time.period_s;
    let n = system.order();
    let mut a = Mat::zeros(n, n);
    let mut start = 0;
    for size in &modal.blocks {
        let block = system.a.submatrix(start, start, *size, *size).to_owned();
        let image = match logarithm(&block) {
            Some(logarithm) => scaled_by(&logarithm, 1.0 / period_s),
            None => {
                let one = Mat::<f64>::identity(*size, *size);
                // The factors commute: (A + I)⁻¹(A − I).
                let image = solve(&(&block + &one), &(&block - &one)).map_err(&named)?;
                scaled_by(&image, 2.0 / period_s)
            }
        };
        a.submatrix_mut(start, start, *size, *size).copy_from(&image);
        start += size;
    }
    let samples = samples(law, system, &a);
    let (mut c, mut d) = (Mat::zeros(system.outputs(), n), Mat::zeros(system.outputs(), system.inputs()));
    let rows: Result<Vec<(Vec<usize>, Vec<f64>)>, NumericError> = (0..system.outputs())
        .into_par_iter()
        .map(|output| {
            // Only states that this output reads: what is decoupled stays decoupled.
            let read: Vec<usize> = (0..n).filter(|k| system.c[(output, *k)] != 0.0).collect();
            let row = least_squares(&samples, output, &read)?;
            Ok((read, row))
        })
        .collect();
    for (output, (read, row)) in rows.map_err(&named)?.into_iter().enumerate() {
        for (value, k) in row.iter().zip(&read) {
            c[(output, *k)] = *value;
        }
        for j in 0..system.inputs() {
            d[(output, j)] = row[read.len() + j];
        }
    }
    let fitted = StateSpace::new(a, system.b.clone(), c, d, Continuous).map_err(&named)?;
    let relative_error = samples
        .par_iter()
        .map(|sample| {
            let difference = fitted.transfer(c64::new(0.0, sample.omega_rad_s)) - &sample.wanted;
            let size = max_singular_value_complex(&sample.wanted).max(f64::MIN_POSITIVE);
            (sample.omega_rad_s / (2.0 * PI), max_singular_value_complex(&difference) / size)
        })
        .collect();
    Ok(ContinuousFit { law: fitted, relative_error })
}

struct FitSample {
    omega_rad_s: f64,
    /// K(e^{jωT}).
    wanted: Mat<c64>,
    /// (jωI − A)⁻¹B.
    states: Mat<c64>,
    weight: f64,
}

fn samples(law: &StateSpace<Discrete>, modal: &StateSpace<Discrete>, a: &Mat<f64>) -> Vec<FitSample> {
    let n = a.nrows();
    let b = Mat::from_fn(n, modal.inputs(), |i, j| c64::new(modal.b[(i, j)], 0.0));
    (0..FREQUENCIES)
        .into_par_iter()
        .map(|k| {
            let decades = 4.0 * (k as f64 / (FREQUENCIES - 1) as f64 - 1.0);
            let angle = FITTED_SHARE * PI * 10f64.powf(decades);
            let omega_rad_s = angle / law.time.period_s;
            let wanted = law.transfer(c64::from_polar(1.0, angle));
            let resolvent = Mat::from_fn(n, n, |i, j| {
                let own = if i == j { omega_rad_s } else { 0.0 };
                c64::new(-a[(i, j)], own)
            });
            let states = if n == 0 { b.clone() } else { solve_complex(&resolvent, &b) };
            let weight = 1.0 / wanted.norm_l2().max(f64::MIN_POSITIVE);
            FitSample { omega_rad_s, wanted, states, weight }
        })
        .collect()
}

/// Row [c, d] of one output over the states read and all inputs, by normal equations with columns of unit size.
fn least_squares(samples: &[FitSample], output: usize, read: &[usize]) -> Result<Vec<f64>, NumericError> {
    let inputs = samples.first().map_or(0, |s| s.wanted.ncols());
    let unknowns = read.len() + inputs;
    let equations = 2 * inputs * samples.len();
    let (mut matrix, mut wanted) = (Mat::zeros(equations, unknowns), Mat::zeros(equations, 1));
    for (k, sample) in samples.iter().enumerate() {
        for j in 0..inputs {
            for part in 0..2 {
                let row = 2 * (k * inputs + j) + part;
                let pick = |z: c64| sample.weight * if part == 0 { z.re } else { z.im };
                for (column, state) in read.iter().enumerate() {
                    matrix[(row, column)] = pick(sample.states[(*state, j)]);
                }
                matrix[(row, read.len() + j)] = pick(c64::new(1.0, 0.0));
                wanted[(row, 0)] = pick(sample.wanted[(output, j)]);
            }
        }
    }
    let sizes: Vec<f64> = (0..unknowns)
        .map(|j| {
            let size = matrix.col(j).norm_l2();
            if size > 0.0 { size } else { 1.0 }
        })
        .collect();
    let unit = Mat::from_fn(equations, unknowns, |i, j| matrix[(i, j)] / sizes[j]);
    let mut normal = unit.transpose() * &unit;
    for j in 0..unknowns {
        // A state that no input reaches has a column of zeros; 1e-13 is above rounding of the sums only.
        normal[(j, j)] += 1e-13;
    }
    let solution = solve(&normal, &(unit.transpose() * &wanted))?;
    Ok((0..unknowns).map(|j| solution[(j, 0)] / sizes[j]).collect())
}

/// Logarithm of a block with one real pole or one pair as a rotation, when it is a useful one.
fn logarithm(block: &Mat<f64>) -> Option<Mat<f64>> {
    match block.nrows() {
        1 if block[(0, 0)] > 0.0 => Some(Mat::from_fn(1, 1, |_, _| block[(0, 0)].ln())),
        2 => {
            let (real, imaginary) = (block[(0, 0)], block[(0, 1)]);
            let size = real.hypot(imaginary);
            let angle = imaginary.atan2(real);
            let rotation =
                (block[(1, 1)] - real).abs() <= ROTATION * size && (block[(1, 0)] + imaginary).abs() <= ROTATION * size;
            (rotation && angle.abs() < LARGEST_ANGLE).then(|| {
                Mat::from_fn(2, 2, |i, j| match (i, j) {
                    (0, 1) => angle,
                    (1, 0) => -angle,
                    _ => size.ln(),
                })
            })
        }
        _ => None,
    }
}

fn scaled_by(matrix: &Mat<f64>, factor: f64) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| factor * matrix[(i, j)])
}
