//! H2 synthesis: the controller u = K y that makes the energy of the impulse responses from w to z smallest, and LQG,
//! which is the same problem with the roots of the weights as errors and of the covariances as disturbances.
//! Two Riccati equations: X with F of the cost (C1, D12), Y with L of the noise (B1, D21). Continuous time:
//! K = (A − B2F − LC2, L, −F), ‖·‖² = tr(B1'XB1) + tr(RFYF'). Sampled time, with the measurement of the same instant
//! (Chen and Francis, Optimal Sampled-Data Control Systems, 1995, section 6.6): u = −F x̂ + L0 e with the innovation e
//! of covariance E = D21D21' + C2YC2', ‖·‖² = tr(D11'D11 + B1'XB1) + tr(H(FYF' − L0EL0')), H = D12'D12 + B2'XB2.

use super::riccati_cause::find_regulator_cause;
use crate::linalg::regulator::{Regulator, RegulatorSolution};
use crate::linalg::riccati::RiccatiError;
use crate::linalg::{Mat, NumericError, solve, symmetric_eigen};
use crate::lti::connect::{block2, lower_lft, stack_cols, stack_rows};
use crate::lti::norm::NormError;
use crate::lti::{StateSpace, TimeBase};
use thiserror::Error;

/// Why there is no H2 controller to return.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum H2Error {
    /// A Riccati equation without a solution.
    #[error("{which} Riccati equation: {source}{}", cause.as_ref().map_or(String::new(), |c| format!("; {c}")))]
    Riccati {
        /// "control (cost of C1, D12)" or "filter (noise of B1, D21)".
        which: &'static str,
        /// Reason.
        source: RiccatiError,
        /// The condition on the data that fails, in terms of the equation.
        cause: Option<String>,
    },
    /// A direct path from w to z in continuous time.
    #[error("D11 has entries up to {largest:.6e}: in continuous time the H2 norm is infinite with it")]
    Feedthrough {
        /// Largest entry of D11.
        largest: f64,
    },
    /// Weights or covariances that are not positive semidefinite.
    #[error("{which} has the negative eigenvalue {least:.3e} (the largest is {largest:.3e})")]
    Indefinite {
        /// The matrix.
        which: &'static str,
        /// Smallest eigenvalue.
        least: f64,
        /// Largest eigenvalue.
        largest: f64,
    },
    /// The norm of the loop contradicts the optimum.
    #[error("the H2 norm of the loop, {norm:.9e}, differs from the optimum of the Riccati equations, {optimum:.9e}")]
    Refuted {
        /// Norm of the loop.
        norm: f64,
        /// Optimum.
        optimum: f64,
    },
    /// A norm that could not be computed.
    #[error(transparent)]
    Norm(#[from] NormError),
    /// A numeric failure.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// Controller with its certificate.
#[derive(Clone, Debug)]
pub struct H2Solution<T: TimeBase> {
    /// u = K y.
    pub controller: StateSpace<T>,
    /// H2 norm of the loop, by its gramian.
    pub norm: f64,
    /// The same by the Riccati equations.
    pub optimum: f64,
    /// u = −F x of the measured state.
    pub control_gain: Mat<f64>,
    /// L of the predicting observer x̂₊ = A x̂ + B2 u + L e.
    pub filter_gain: Mat<f64>,
    /// Relative residuals of X and Y.
    pub residuals: [f64; 2],
    /// Largest growth rate of the loop, 1/s.
    pub growth_rate: f64,
}

/// Largest accepted relative difference of norm and optimum: the squares lose half the digits of small differences.
const LARGEST_DIFFERENCE: f64 = 1e-6;

/// Synthesis for a plant whose last inputs are controls and whose last outputs are measurements; `norm` is the H2 norm
/// of its time base.
///
/// # Errors
/// [`H2Error`] names the equation, the condition or the check that fails.
pub fn synthesise_h2<T: TimeBase>(
    plant: &StateSpace<T>,
    controls: usize,
    measurements: usize,
    norm: impl Fn(&StateSpace<T>) -> Result<f64, NormError>,
) -> Result<H2Solution<T>, H2Error> {
    let p = Parts::of(plant, controls, measurements);
    let largest = p.d11.norm_max();
    if !T::IS_SAMPLED && largest > 0.0 {
        return Err(H2Error::Feedthrough { largest });
    }
    let control = p.regulator(T::IS_SAMPLED).riccati("control (cost of C1, D12)")?;
    let filter = p.transposed().regulator(T::IS_SAMPLED).riccati("filter (noise of B1, D21)")?;
    let (f, l) = (&control.gain, filter.gain.transpose().to_owned());
    let (x, y) = (&control.x, &filter.x);
    let (bt, dt) = (p.b2.transpose(), p.d12.transpose());
    let trace = |m: Mat<f64>| (0..m.nrows()).map(|i| m[(i, i)]).sum::<f64>();
    // Cost of a unit of u, gain of the innovation.
    let (weight, direct, credit) = if T::IS_SAMPLED {
        let weight = dt * &p.d12 + bt * x * &p.b2;
        let covariance = &p.d21 * p.d21.transpose() + &p.c2 * y * p.c2.transpose();
        let disturbance_gain = solve(&weight, &(bt * x * &p.b1 + dt * &p.d11))?;
        let wanted = f * y * p.c2.transpose() + disturbance_gain * p.d21.transpose();
        // −L0 = (FYC2' + F0D21')E⁻¹.
        let direct = -(solve(&covariance, &wanted.transpose().to_owned())?.transpose());
        let credit = trace(&weight * &direct * &covariance * direct.transpose());
        (weight, direct, credit)
    } else {
        (dt * &p.d12, Mat::zeros(controls, measurements), 0.0)
    };
    let square =
        trace(p.d11.transpose() * &p.d11 + p.b1.transpose() * x * &p.b1) + trace(&weight * f * y * f.transpose());
    let optimum = (square - credit).max(0.0).sqrt();
    let output = -f - &direct * &p.c2;
    let inner = StateSpace::new(&p.a - &l * &p.c2 + &p.b2 * &output, &l + &p.b2 * &direct, output, direct, plant.time)?;
    let controller = with_direct_path(&inner, &p.d22)?;
    let closed = lower_lft(plant, &controller)?;
    let norm = norm(&closed)?;
    // Terms of opposite sign leave the rounding of the larger ones.
    if (norm - optimum).abs() > LARGEST_DIFFERENCE * norm.max(square.sqrt()) {
        return Err(H2Error::Refuted { norm, optimum });
    }
    Ok(H2Solution {
        controller,
        norm,
        optimum,
        control_gain: control.gain,
        filter_gain: l,
        residuals: [control.residual, filter.residual],
        growth_rate: closed.growth_rate()?,
    })
}

/// The plant of an LQG problem: w are unit noises through the root of their covariance, z the root of the cost.
/// `plant` is u → y, `cost` [Q S; S' R] and `noise` [W N; N' V].
///
/// # Errors
/// [`H2Error::Indefinite`].
pub fn pose_lqg<T: TimeBase>(
    plant: &StateSpace<T>,
    cost: &Mat<f64>,
    noise: &Mat<f64>,
) -> Result<StateSpace<T>, H2Error> {
    let (n, m, p) = (plant.order(), plant.inputs(), plant.outputs());
    let errors = root(cost, "[Q S; S' R]")?;
    let noises = root(noise, "[W N; N' V]")?.transpose().to_owned();
    let (z, w) = (errors.nrows(), noises.ncols());
    let part = |m: &Mat<f64>, i, j, h, k| m.submatrix(i, j, h, k).to_owned();
    let d = block2(&Mat::zeros(z, w), &part(&errors, 0, n, z, m), &part(&noises, n, 0, p, w), &plant.d);
    Ok(StateSpace::new(
        plant.a.clone(),
        stack_cols(&part(&noises, 0, 0, n, w), &plant.b),
        stack_rows(&part(&errors, 0, 0, z, n), &plant.c),
        d,
        plant.time,
    )?)
}

/// C with C'C a positive semidefinite matrix.
fn root(m: &Mat<f64>, which: &'static str) -> Result<Mat<f64>, H2Error> {
    // An eigenvalue below zero by the rounding of the data is zero.
    const ROUNDING: f64 = 1e-12;
    let (values, vectors) = symmetric_eigen(m)?;
    let largest = values.last().copied().unwrap_or(0.0);
    let least = values.first().copied().unwrap_or(0.0);
    if least < -ROUNDING * largest.max(-least) && least < 0.0 {
        return Err(H2Error::Indefinite { which, least, largest });
    }
    let n = m.nrows();
    Ok(Mat::from_fn(n, n, |i, j| values[i].max(0.0).sqrt() * vectors[(j, i)]))
}

/// K of y, from K of y − D22 u.
fn with_direct_path<T: TimeBase>(inner: &StateSpace<T>, d22: &Mat<f64>) -> Result<StateSpace<T>, NumericError> {
    let (m, p) = (inner.outputs(), inner.inputs());
    // (y, u) to (u, y − D22 u).
    let minus = Mat::from_fn(p, m, |i, j| -d22[(i, j)]);
    let junction = block2(&Mat::zeros(m, p), &Mat::identity(m, m), &Mat::identity(p, p), &minus);
    lower_lft(&StateSpace::gain(junction, inner.time), inner)
}

/// Blocks of a generalized plant.
struct Parts {
    a: Mat<f64>,
    b1: Mat<f64>,
    b2: Mat<f64>,
    c1: Mat<f64>,
    c2: Mat<f64>,
    d11: Mat<f64>,
    d12: Mat<f64>,
    d21: Mat<f64>,
    d22: Mat<f64>,
}

impl Parts {
    fn of<T: TimeBase>(s: &StateSpace<T>, controls: usize, measurements: usize) -> Self {
        let (n, m1, p1) = (s.order(), s.inputs() - controls, s.outputs() - measurements);
        let part = |m: &Mat<f64>, i, j, h, w| m.submatrix(i, j, h, w).to_owned();
        Self {
            a: s.a.clone(),
            b1: part(&s.b, 0, 0, n, m1),
            b2: part(&s.b, 0, m1, n, controls),
            c1: part(&s.c, 0, 0, p1, n),
            c2: part(&s.c, p1, 0, measurements, n),
            d11: part(&s.d, 0, 0, p1, m1),
            d12: part(&s.d, 0, m1, p1, controls),
            d21: part(&s.d, p1, 0, measurements, m1),
            d22: part(&s.d, p1, m1, measurements, controls),
        }
    }

    fn transposed(&self) -> Self {
        let t = |m: &Mat<f64>| m.transpose().to_owned();
        Self {
            a: t(&self.a),
            b1: t(&self.c1),
            b2: t(&self.c2),
            c1: t(&self.b1),
            c2: t(&self.b2),
            d11: t(&self.d11),
            d12: t(&self.d21),
            d21: t(&self.d12),
            d22: t(&self.d22),
        }
    }

    /// The cost of C1 and D12 on A and B2.
    fn regulator(&self, is_sampled: bool) -> Side {
        let (ct, dt) = (self.c1.transpose(), self.d12.transpose());
        Side(Regulator {
            a: self.a.clone(),
            b: self.b2.clone(),
            q: ct * &self.c1,
            r: dt * &self.d12,
            s: ct * &self.d12,
            is_sampled,
        })
    }
}

struct Side(Regulator);

impl Side {
    fn riccati(&self, which: &'static str) -> Result<RegulatorSolution, H2Error> {
        self.0.solve().map_err(|source| {
            let cause = find_regulator_cause(&self.0).ok().flatten();
            H2Error::Riccati { which, source, cause }
        })
    }
}
