//! Loop shaping by normalised coprime factors (Glover and McFarlane 1989): the controller u = K y that stabilises the
//! largest ball of perturbations of the factors of a shaped plant G. With X and Z of the two Riccati equations the
//! smallest level of ‖[K; I](I − GK)⁻¹[I G]‖∞ is γ = √(1 + λmax(XZ)), without a search; the margin is ε = 1/γ.

use super::riccati_cause::find_regulator_cause;
use crate::linalg::regulator::{Regulator, RegulatorSolution};
use crate::linalg::{Mat, NumericError, eigenvalues, solve, symmetric_eigen};
use crate::lti::balance::{Balancing, Reduction};
use crate::lti::connect::{lower_lft, stack_cols, stack_rows};
use crate::lti::norm::hinf_norm_and_growth;
use crate::lti::{Continuous, StateSpace};
use crate::robust::error::{Condition, SynthesisError};

/// Controller of a shaped plant with its certificate.
#[derive(Clone, Debug)]
pub struct CoprimeSolution {
    /// u = K y for the shaped plant.
    pub controller: StateSpace<Continuous>,
    /// Smallest level.
    pub gamma_opt: f64,
    /// Level of the controller.
    pub gamma: f64,
    /// Norm of its loop, computed independently.
    pub closed_loop_norm: f64,
    /// Frequency of that norm, rad/s.
    pub closed_loop_peak_rad_s: f64,
    /// Relative residuals of X and Z.
    pub residuals: [f64; 2],
    /// Largest growth rate of the loop, 1/s.
    pub growth_rate: f64,
}

/// Shares of the optimum by which a level is above it where none is given; a larger one serves where rounding is in the
/// way of the smaller.
const SLACKS: [f64; 3] = [1e-3, 1e-2, 1e-1];
/// Relative tolerance of the norm of the loop.
const NORM_TOL: f64 = 1e-9;
/// Share by which rounding may leave the norm of a loop above its level.
const ROUNDING: f64 = 1e-6;

/// Synthesis for a shaped plant; `level` asks for the controller at that level.
///
/// # Errors
/// [`SynthesisError`]: an equation without a solution, a level below the smallest one, a loop that misses its level.
pub fn shape_loop(plant: &StateSpace<Continuous>, level: Option<f64>) -> Result<CoprimeSolution, SynthesisError> {
    let control = regulator(plant);
    let (x, z) = (riccati(&control, "control")?, riccati(&regulator(&transpose(plant)), "filter")?);
    let product = &x.x * &z.x;
    let largest = eigenvalues(&product)?.iter().map(|v| v.re).fold(0.0, f64::max);
    let gamma_opt = (1.0 + largest).sqrt();
    let tried: Vec<f64> = match level {
        Some(gamma) if gamma <= gamma_opt || gamma.is_nan() => {
            return Err(SynthesisError::Infeasible {
                gamma,
                condition: Condition::Coupling { ratio: (gamma_opt / gamma).powi(2) },
            });
        }
        Some(gamma) => vec![gamma],
        None => SLACKS.map(|slack| gamma_opt * (1.0 + slack)).to_vec(),
    };
    let mut refuted = None;
    for gamma in tried {
        let controller = central(plant, &x, &z, gamma)?;
        let closed = lower_lft(&four_block(plant)?, &controller)?;
        let (norm, growth_rate) = match hinf_norm_and_growth(&closed, NORM_TOL) {
            Ok((norm, growth_rate)) => (norm, growth_rate),
            Err(error) => {
                refuted = Some(error.into());
                continue;
            }
        };
        if norm.norm <= gamma * (1.0 + ROUNDING) {
            return Ok(CoprimeSolution {
                controller,
                gamma_opt,
                gamma: gamma.max(norm.norm),
                closed_loop_norm: norm.norm,
                closed_loop_peak_rad_s: norm.peak_omega_rad_s,
                residuals: [x.residual, z.residual],
                growth_rate,
            });
        }
        refuted = Some(SynthesisError::Refuted { gamma, norm: norm.norm, growth_rate });
    }
    Err(refuted.unwrap_or(SynthesisError::NoLevel { gamma: gamma_opt, condition: Condition::Unsolved }))
}

/// Normalised left coprime factors [N M] of a system, G = M⁻¹N, ready for reduction: poles that are not stable are
/// reduced like the others, and what counts is the gap.
#[derive(Clone, Debug)]
pub struct CoprimeFactors {
    /// The factors, balanced.
    pub balancing: Balancing,
    inputs: usize,
}

impl CoprimeFactors {
    /// The factors of a system.
    ///
    /// # Errors
    /// [`SynthesisError`] for modes that are neither stable nor observed, and steps that fail.
    pub fn new(system: &StateSpace<Continuous>) -> Result<Self, SynthesisError> {
        let (p, m) = (system.outputs(), system.inputs());
        let filter = regulator(&transpose(system));
        let gain = riccati(&filter, "filter")?.gain.transpose().to_owned();
        // R⁻¹ᐟ² of R = I + DD'.
        let (values, vectors) = symmetric_eigen(&filter.r)?;
        let root = Mat::from_fn(p, p, |i, j| {
            (0..p).map(|k| vectors[(i, k)] * vectors[(j, k)] / values[k].sqrt()).sum::<f64>()
        });
        let factors = StateSpace::new(
            &system.a - &gain * &system.c,
            stack_cols(&(&system.b - &gain * &system.d), &-&gain),
            &root * &system.c,
            &root * stack_cols(&system.d, &Mat::identity(p, p)),
            Continuous,
        )?;
        Ok(Self { balancing: Balancing::with_check(&factors)?, inputs: m })
    }

    /// The system of `order` states and the H∞ norm of the error of its factors, a bound of the gap.
    ///
    /// # Errors
    /// [`NumericError`] when a step fails.
    pub fn reduce(&self, order: usize) -> Result<(StateSpace<Continuous>, f64), NumericError> {
        let found = self.balancing.reductions(order)?.into_iter().next();
        let Some(Reduction { system: f, error_hinf, .. }) = found else {
            return Err(NumericError::NotFinite { what: "coprime factors" });
        };
        let (n, m, p) = (f.order(), self.inputs, f.outputs());
        let part = |matrix: &Mat<f64>, rows: usize, from: usize, width: usize| {
            matrix.submatrix(0, from, rows, width).to_owned()
        };
        let over = part(&f.d, p, m, p);
        let (c, d) = (solve(&over, &f.c)?, solve(&over, &part(&f.d, p, 0, m))?);
        let driven = part(&f.b, n, m, p);
        let system = StateSpace::new(&f.a - &driven * &c, part(&f.b, n, 0, m) - &driven * &d, c, d, Continuous)?;
        Ok((system, error_hinf))
    }
}

/// The cost y'y + u'u.
fn regulator(s: &StateSpace<Continuous>) -> Regulator {
    let (ct, dt) = (s.c.transpose(), s.d.transpose());
    let m = s.inputs();
    Regulator {
        a: s.a.clone(),
        b: s.b.clone(),
        q: ct * &s.c,
        r: Mat::<f64>::identity(m, m) + dt * &s.d,
        s: ct * &s.d,
        is_sampled: false,
    }
}

fn transpose(s: &StateSpace<Continuous>) -> StateSpace<Continuous> {
    let of = |m: &Mat<f64>| m.transpose().to_owned();
    StateSpace { a: of(&s.a), b: of(&s.c), c: of(&s.b), d: of(&s.d), time: Continuous }
}

fn riccati(side: &Regulator, which: &'static str) -> Result<RegulatorSolution, SynthesisError> {
    side.solve().map_err(|source| match find_regulator_cause(side) {
        Ok(Some(cause)) => SynthesisError::Partition(format!("{which} Riccati equation: {cause}")),
        _ => SynthesisError::Regulator { which, source },
    })
}

/// The controller of a level (Zhou, Doyle and Glover, Robust and Optimal Control, 1996, section 18.3, for D = 0; the
/// direct path as in McFarlane and Glover 1992).
fn central(
    s: &StateSpace<Continuous>,
    x: &RegulatorSolution,
    z: &RegulatorSolution,
    gamma: f64,
) -> Result<StateSpace<Continuous>, NumericError> {
    let n = s.order();
    let square = gamma * gamma;
    let product = &x.x * &z.x;
    let l = Mat::from_fn(n, n, |i, j| product[(i, j)] + if i == j { 1.0 - square } else { 0.0 });
    let right = &z.x * s.c.transpose();
    let gain = solve(&l.transpose().to_owned(), &Mat::from_fn(n, s.outputs(), |i, j| square * right[(i, j)]))?;
    let read = &s.c - &s.d * &x.gain;
    let a = &s.a - &s.b * &x.gain + &gain * read;
    StateSpace::new(a, gain, s.b.transpose() * &x.x, -s.d.transpose(), Continuous)
}

/// The plant of the norm: w = (at y, at u), z = (u, y), y = G(u + w₂) + w₁.
fn four_block(s: &StateSpace<Continuous>) -> Result<StateSpace<Continuous>, NumericError> {
    let (n, m, p) = (s.order(), s.inputs(), s.outputs());
    let b = stack_cols(&stack_cols(&Mat::zeros(n, p), &s.b), &s.b);
    let c = stack_rows(&stack_rows(&Mat::zeros(m, n), &s.c), &s.c);
    let own = stack_cols(&stack_cols(&Mat::identity(p, p), &s.d), &s.d);
    let first = stack_cols(&Mat::zeros(m, p + m), &Mat::identity(m, m));
    StateSpace::new(s.a.clone(), b, c, stack_rows(&stack_rows(&first, &own), &own), Continuous)
}
