//! Reduction by balancing: Hankel singular values, balanced truncation (Moore 1981; square-root method of Tombs and
//! Postlethwaite 1987) and singular perturbation, which keeps the DC gain (Liu and Anderson 1989). The error of both is
//! at most twice the sum of the cut Hankel values. Unstable poles are split off and kept (Safonov et al. 1990).
//! Frequency-weighted (Enns 1984): gramians of the weighted cascades, for reduction that minds the closed loop.

use super::connect::{add, append, series};
use super::norm::linf_norm;
use super::scale::{balancing, balancing_of_dynamics};
use super::state_space::{Continuous, StateSpace};
use crate::linalg::doubled::Doubled;
use crate::linalg::gramian::{jacobi_svd, observability_factor, reachability_factor};
use crate::linalg::lyapunov::{lyapunov, sylvester};
use crate::linalg::schur::schur;
use crate::linalg::{Mat, NumericError, solve, symmetric_eigen};

/// Largest accepted relative error of the equations that balanced gramians satisfy: half the digits.
const LARGEST_RESIDUAL: f64 = 1e-8;

/// A system split into its stable part, balanced, and the part that reduction keeps.
#[derive(Clone, Debug)]
pub struct Balancing {
    /// Hankel values of the stable part, descending (weighted ones when weights were given).
    pub hankel: Vec<f64>,
    stable: StateSpace<Continuous>,
    kept: StateSpace<Continuous>,
    /// Wᵀ x are balanced coordinates, x = T·(them); n_s×k, k the numerical rank.
    left: Mat<f64>,
    right: Mat<f64>,
    /// Weights of the error at the input and at the output.
    weights: [Option<StateSpace<Continuous>>; 2],
}

/// Hankel singular values of the stable part, descending.
///
/// # Errors
/// [`NumericError`] when the split or a gramian fails.
pub fn hankel_values(system: &StateSpace<Continuous>) -> Result<Vec<f64>, NumericError> {
    Ok(Balancing::with_check(system)?.hankel)
}

/// Balanced truncation to `order` states, unstable ones included.
///
/// # Errors
/// [`NumericError`] when the order is smaller than the number of poles that must be kept, or a step fails.
pub fn balanced_truncation(
    system: &StateSpace<Continuous>,
    order: usize,
) -> Result<StateSpace<Continuous>, NumericError> {
    Balancing::with_check(system)?.truncate_states(order)
}

/// Singular perturbation to `order` states, unstable ones included; keeps the DC gain.
///
/// # Errors
/// As [`balanced_truncation`].
pub fn singular_perturbation(
    system: &StateSpace<Continuous>,
    order: usize,
) -> Result<StateSpace<Continuous>, NumericError> {
    Balancing::with_check(system)?.residualise_states(order)
}

/// Balancing of K for the weighted error W_o (K − K_r) W_i; absent weights are 1. The weights must be stable.
///
/// # Errors
/// [`NumericError`] when channel counts differ, a weight is unstable, or a gramian fails.
pub fn frequency_weighted_balance(
    system: &StateSpace<Continuous>,
    input_weight: Option<&StateSpace<Continuous>>,
    output_weight: Option<&StateSpace<Continuous>>,
) -> Result<Balancing, NumericError> {
    let (stable, kept) = split(system)?;
    // The factor of the states of K in the gramian of the cascade; its rows are what the cascade adds.
    let n = stable.order();
    let reach = || -> Result<Mat<f64>, NumericError> {
        let Some(w) = input_weight else {
            return Ok(reachability_factor(&stable.a, &stable.b)?.to_double());
        };
        // series() puts the states of its first system first: K comes last.
        let cascade = series(w, &stable)?;
        let factor = reachability_factor(&cascade.a, &cascade.b)?.to_double();
        let own = factor.submatrix(w.order(), 0, n, cascade.order());
        Ok(own.to_owned())
    };
    let observe = || -> Result<Mat<f64>, NumericError> {
        let Some(w) = output_weight else {
            return Ok(observability_factor(&stable.a, &stable.c)?.to_double());
        };
        let cascade = series(&stable, w)?;
        let factor = observability_factor(&cascade.a, &cascade.c)?.to_double();
        Ok(factor.submatrix(0, 0, n, cascade.order()).to_owned())
    };
    let (reach, observe) = rayon::join(reach, observe);
    let (reach, observe) = (reach?, observe?);
    let found = Balancing::from_factors(stable, kept, &Doubled::from_f64(&reach), &Doubled::from_f64(&observe));
    Ok(Balancing { weights: [input_weight.cloned(), output_weight.cloned()], ..found })
}

impl Balancing {
    /// Splits and balances a system.
    ///
    /// # Errors
    /// [`NumericError`] when the split or a gramian fails.
    pub fn new(system: &StateSpace<Continuous>) -> Result<Self, NumericError> {
        let (stable, kept) = split(system)?;
        let reach = reachability_factor(&stable.a, &stable.b)?;
        let observe = observability_factor(&stable.a, &stable.c)?;
        Ok(Self::from_factors(stable, kept, &reach, &observe))
    }

    /// Splits and balances a system in any state coordinates, companion forms for instance, and checks the result.
    ///
    /// # Errors
    /// [`NumericError::Contradiction`] when no coordinates give gramians that satisfy their equations, and as
    /// [`Self::new`].
    pub fn with_check(system: &StateSpace<Continuous>) -> Result<Self, NumericError> {
        let (stable, kept) = split_scaled(system, balancing_of_dynamics)?;
        let balance = |stable: StateSpace<Continuous>| -> Result<Self, NumericError> {
            let reach = reachability_factor(&stable.a, &stable.b)?;
            let observe = observability_factor(&stable.a, &stable.c)?;
            let found = Self::from_factors(stable, kept.clone(), &reach, &observe);
            found.check()?;
            Ok(found)
        };
        // Small values keep their digits in the coordinates as given, if these serve at all.
        balance(stable.clone()).or_else(|_| balance(input_normal(&stable)?))
    }

    /// Checks the values on the balanced system: A Σ + Σ Aᵀ + B Bᵀ = 0 and Aᵀ Σ + Σ A + Cᵀ C = 0, which no step before
    /// has used, and the largest of them against the H∞ norm, which none exceeds.
    fn check(&self) -> Result<(), NumericError> {
        let k = self.right.ncols();
        let balanced = self.balance_states(k);
        let sigma = Mat::from_fn(k, k, |i, j| if i == j { self.hankel[i] } else { 0.0 });
        let equations = [
            (&balanced.a * &sigma, &balanced.b * balanced.b.transpose()),
            (balanced.a.transpose() * &sigma, balanced.c.transpose() * &balanced.c),
        ];
        for (product, square) in equations {
            let residual = (&product + product.transpose() + &square).norm_l2();
            let share = residual / (2.0 * product.norm_l2() + square.norm_l2()).max(f64::MIN_POSITIVE);
            if share.is_nan() || share > LARGEST_RESIDUAL {
                return Err(NumericError::Contradiction {
                    what: "equations of the balanced gramians",
                    residual: share,
                });
            }
        }
        let largest = self.hankel.first().copied().unwrap_or(0.0);
        let norm = linf_norm(&self.stable, LARGEST_RESIDUAL)?.upper;
        if largest > (1.0 + LARGEST_RESIDUAL) * norm {
            return Err(NumericError::Contradiction {
                what: "largest Hankel value above the H-infinity norm",
                residual: largest / norm - 1.0,
            });
        }
        Ok(())
    }

    fn from_factors(
        stable: StateSpace<Continuous>,
        kept: StateSpace<Continuous>,
        reach: &Doubled,
        observe: &Doubled,
    ) -> Self {
        let (n, cols) = (stable.order(), reach.hi.ncols());
        // Square for the Jacobi method when a weight has widened a factor.
        let product = observe.transpose_times(reach).to_double();
        let size = product.nrows().max(cols);
        let square =
            Mat::from_fn(size, size, |i, j| if i < product.nrows() && j < cols { product[(i, j)] } else { 0.0 });
        let (u, s, v) = jacobi_svd(&square);
        // Values below rounding of the largest have no reliable directions.
        let first = s.first().copied().unwrap_or(0.0);
        let rank = s.iter().take(n).take_while(|x| **x > 1e-14 * first).count();
        let (lr, lo) = (reach.to_double(), observe.to_double());
        let right = Mat::from_fn(n, rank, |i, j| (0..cols).map(|k| lr[(i, k)] * v[(k, j)]).sum::<f64>() / s[j].sqrt());
        let left =
            Mat::from_fn(n, rank, |i, j| (0..lo.ncols()).map(|k| lo[(i, k)] * u[(k, j)]).sum::<f64>() / s[j].sqrt());
        Self { hankel: s.into_iter().take(n).collect(), stable, kept, left, right, weights: [None, None] }
    }

    /// Number of poles that are not reduced: those not in the open left half plane.
    pub(crate) fn kept_states(&self) -> usize {
        self.kept.order()
    }

    /// Balanced truncation to `order` states.
    ///
    /// # Errors
    /// [`NumericError`] when `order` is below the number of poles that are not in the open left half plane.
    pub fn truncate_states(&self, order: usize) -> Result<StateSpace<Continuous>, NumericError> {
        Ok(append_outputs(&self.truncated_part(self.stable_order(order)?), &self.kept))
    }

    /// Singular perturbation to `order` states.
    pub(crate) fn residualise_states(&self, order: usize) -> Result<StateSpace<Continuous>, NumericError> {
        Ok(append_outputs(&self.residualised_part(self.stable_order(order)?)?, &self.kept))
    }

    /// Both reductions with their L∞ errors, weighted ones where there are weights; the better one first.
    pub(crate) fn reductions(&self, order: usize) -> Result<Vec<Reduction>, NumericError> {
        let r = self.stable_order(order)?;
        let parts =
            [("balanced_truncation", self.truncated_part(r)), ("singular_perturbation", self.residualised_part(r)?)];
        let mut list = Vec::with_capacity(2);
        for (method, part) in parts {
            // The kept part cancels in the difference.
            let minus = part
                .scale_outputs(&Mat::from_fn(part.outputs(), part.outputs(), |i, j| if i == j { -1.0 } else { 0.0 }));
            let mut difference = add(&self.stable, &minus)?;
            if let Some(weight) = &self.weights[0] {
                difference = series(weight, &difference)?;
            }
            if let Some(weight) = &self.weights[1] {
                difference = series(&difference, weight)?;
            }
            let error = linf_norm(&difference, 1e-9)?;
            list.push(Reduction { method, system: append_outputs(&part, &self.kept), error_hinf: error.norm });
        }
        list.sort_by(|x, y| x.error_hinf.total_cmp(&y.error_hinf));
        Ok(list)
    }

    fn stable_order(&self, order: usize) -> Result<usize, NumericError> {
        if order < self.kept_states() {
            return Err(NumericError::Dimension {
                what: "reduced order",
                expected: format!("at least {} (the poles that are not stable)", self.kept_states()),
                found: order.to_string(),
            });
        }
        Ok((order - self.kept_states()).min(self.stable.order()))
    }

    fn balance_states(&self, r: usize) -> StateSpace<Continuous> {
        let (left, right) =
            (self.left.submatrix(0, 0, self.left.nrows(), r), self.right.submatrix(0, 0, self.right.nrows(), r));
        StateSpace {
            a: left.transpose() * &self.stable.a * right,
            b: left.transpose() * &self.stable.b,
            c: &self.stable.c * right,
            d: self.stable.d.clone(),
            time: Continuous,
        }
    }

    fn truncated_part(&self, r: usize) -> StateSpace<Continuous> {
        if r >= self.stable.order() {
            return self.stable.clone();
        }
        self.balance_states(r.min(self.left.ncols()))
    }

    fn residualised_part(&self, r: usize) -> Result<StateSpace<Continuous>, NumericError> {
        let all = self.left.ncols();
        if r >= self.stable.order() || r >= all {
            return Ok(self.truncated_part(r));
        }
        let full = self.balance_states(all);
        let part = |m: &Mat<f64>, i, j, h, w| m.submatrix(i, j, h, w).to_owned();
        let q = all - r;
        let (m, p) = (full.inputs(), full.outputs());
        let fast = part(&full.a, r, r, q, q);
        let x = solve(&fast, &part(&full.a, r, 0, q, r))?;
        let y = solve(&fast, &part(&full.b, r, 0, q, m))?;
        let (a12, c2) = (part(&full.a, 0, r, r, q), part(&full.c, 0, r, p, q));
        StateSpace::new(
            part(&full.a, 0, 0, r, r) - &a12 * &x,
            part(&full.b, 0, 0, r, m) - &a12 * &y,
            part(&full.c, 0, 0, p, r) - &c2 * &x,
            &full.d - &c2 * &y,
            Continuous,
        )
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Reduction {
    /// "balanced_truncation" or "singular_perturbation".
    pub method: &'static str,
    /// The reduced system, kept poles included.
    pub system: StateSpace<Continuous>,
    /// L∞ norm of full minus reduced, between the weights.
    pub error_hinf: f64,
}

/// A stable system in coordinates in which its reachability gramian is about one, where Lyapunov equations and A are
/// well conditioned. The gramian of working precision serves to find them; the change of coordinates is one of doubled
/// precision, so that it costs no digit of the system.
fn input_normal(s: &StateSpace<Continuous>) -> Result<StateSpace<Continuous>, NumericError> {
    // Directions below the accuracy of the gramian; the root of it is the condition number of the change.
    const SMALLEST_SHARE: f64 = 1e-13;
    const INVERSE_STEPS: usize = 3;
    let n = s.order();
    let gramian = lyapunov(&s.a.transpose().to_owned(), &(&s.b * s.b.transpose()))?;
    let (values, vectors) = symmetric_eigen(&gramian)?;
    let largest = values.last().copied().unwrap_or(0.0);
    let roots: Vec<f64> = values.iter().map(|v| v.max(SMALLEST_SHARE * largest).sqrt()).collect();
    if roots.iter().any(|r| !r.is_normal()) {
        return Ok(s.clone());
    }
    let change = Doubled::from_f64(&Mat::from_fn(n, n, |i, j| vectors[(i, j)] * roots[j]));
    let mut inverse = Doubled::from_f64(&Mat::from_fn(n, n, |i, j| vectors[(j, i)] / roots[i]));
    let one = Doubled::from_f64(&Mat::identity(n, n));
    for _ in 0..INVERSE_STEPS {
        // X + X(I − TX): every step doubles the digits.
        let defect = one.plus(&change.times(&inverse).scale_power(-1.0));
        inverse = inverse.plus(&inverse.times(&defect));
    }
    StateSpace::new(
        inverse.times(&Doubled::from_f64(&s.a)).times(&change).to_double(),
        inverse.times(&Doubled::from_f64(&s.b)).to_double(),
        Doubled::from_f64(&s.c).times(&change).to_double(),
        s.d.clone(),
        Continuous,
    )
}

/// Stable part (with the feedthrough) and the rest (without), G = G_s + G_u: ordered Schur form, then a Sylvester
/// equation takes the coupling out.
///
/// # Errors
/// [`NumericError`] when the Schur form fails.
pub fn split(
    system: &StateSpace<Continuous>,
) -> Result<(StateSpace<Continuous>, StateSpace<Continuous>), NumericError> {
    split_scaled(system, balancing)
}

/// [`split`] in states of this scaling.
fn split_scaled(
    system: &StateSpace<Continuous>,
    scale: fn(&StateSpace<Continuous>) -> Vec<f64>,
) -> Result<(StateSpace<Continuous>, StateSpace<Continuous>), NumericError> {
    let s = system.scale_states(&scale(system));
    let n = s.order();
    let form = schur(&s.a)?;
    // Poles on the axis come out at rounding level: they have no gramian and are kept.
    let margin = -1e-13 * s.a.norm_l2();
    if form.eigenvalues().iter().all(|v| v.re < margin) {
        let none = StateSpace::gain(Mat::zeros(s.outputs(), s.inputs()), Continuous);
        return Ok((s, none));
    }
    let (form, k) = form.reorder(|v| v.re < margin);
    let part = |m: &Mat<f64>, i, j, h, w| m.submatrix(i, j, h, w).to_owned();
    let (b, c) = (form.z.transpose() * &s.b, &s.c * &form.z);
    let (a11, a12, a22) = (part(&form.t, 0, 0, k, k), part(&form.t, 0, k, k, n - k), part(&form.t, k, k, n - k, n - k));
    // x1 = x̃1 + X x2 decouples: A11 X − X A22 + A12 = 0.
    let minus = |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| -m[(i, j)]);
    let x = sylvester(&a11, &minus(&a22), &minus(&a12))?;
    let (m, p) = (s.inputs(), s.outputs());
    let (b1, b2) = (part(&b, 0, 0, k, m), part(&b, k, 0, n - k, m));
    let (c1, c2) = (part(&c, 0, 0, p, k), part(&c, 0, k, p, n - k));
    let stable = StateSpace::new(a11, b1 - &x * &b2, c1.clone(), s.d.clone(), Continuous)?;
    let kept = StateSpace::new(a22, b2, c2 + c1 * &x, Mat::zeros(p, m), Continuous)?;
    let scaled = stable.scale_states(&scale(&stable));
    Ok((scaled, kept))
}

/// Sum of two systems with equal channels.
fn append_outputs(first: &StateSpace<Continuous>, second: &StateSpace<Continuous>) -> StateSpace<Continuous> {
    let both = append(first, second);
    let (m, p) = (first.inputs(), first.outputs());
    let inputs = Mat::from_fn(2 * m, m, |i, j| if i % m == j { 1.0 } else { 0.0 });
    let outputs = Mat::from_fn(p, 2 * p, |i, j| if j % p == i { 1.0 } else { 0.0 });
    both.scale_inputs(&inputs).scale_outputs(&outputs)
}
