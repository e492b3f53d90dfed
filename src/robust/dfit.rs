//! Fit of a D-scale: a stable, minimum-phase d(s) of given order with |d(jω)| close to given magnitudes.
//!
//!   minimise  max over the data of  weight · |ln(|d(jω)| / magnitude)|
//!
//! `dfit_linear` finds the global optimum of the unweighted problem in the coefficients of |d|², `dfit_polish` removes what
//! the linear programmes leave and takes the weights in. Orders are fitted upwards: a higher order also starts from the
//! lower one with a pole and a zero added, so its error is never larger.

use super::dfit_factors::{Factors, Limits};
use super::dfit_linear;
use super::dfit_polish::{polish, weighted_error};
use crate::linalg::NumericError;
use crate::lti::{Continuous, StateSpace};
use thiserror::Error;

/// What is wrong with the data of a fit.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DfitError {
    /// Lists of different or zero length.
    #[error(
        "omega, magnitude and weight need the same length of at least 2, found {omega}, {magnitude} and {weight}"
    )]
    Lengths {
        /// Number of frequencies.
        omega: usize,
        /// Number of magnitudes.
        magnitude: usize,
        /// Number of weights.
        weight: usize,
    },
    /// A value outside its range.
    #[error("{field}[{index}] is {value}: {rule}")]
    Value {
        /// Name of the list.
        field: &'static str,
        /// Position, from 0.
        index: usize,
        /// The value.
        value: f64,
        /// What is asked.
        rule: &'static str,
    },
    /// A dense computation failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// Magnitudes over frequency with weights.
#[derive(Clone, Debug)]
pub struct Magnitudes {
    /// Frequencies, rad/s, ascending.
    pub omega_rad_s: Vec<f64>,
    /// Positive magnitudes.
    pub magnitude: Vec<f64>,
    /// Non-negative weights of the log error.
    pub weight: Vec<f64>,
    /// Ranges of corner frequencies and damping ratios; three decades beyond the data unless set otherwise.
    pub limits: Limits,
}

/// ln of the damping ratios of a fit: sharper corners than ζ = 1e-3 cannot be told from noise of the data, and ζ = 1e4
/// separates the two real roots by eight decades.
const LN_DAMPING: (f64, f64) = (-6.9, 9.2);

impl Magnitudes {
    /// Frequency, magnitude and weight of every point.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let both = self.omega_rad_s.iter().zip(&self.magnitude);
        both.zip(&self.weight)
            .map(|((w, m), weight)| (*w, *m, *weight))
    }

    /// Checked data.
    ///
    /// # Errors
    /// [`DfitError`] naming the field, the position and the rule.
    pub fn new(omega: Vec<f64>, magnitude: Vec<f64>, weight: Vec<f64>) -> Result<Self, DfitError> {
        let lengths = (omega.len(), magnitude.len(), weight.len());
        if lengths.0 != lengths.1 || lengths.0 != lengths.2 || lengths.0 < 2 {
            return Err(DfitError::Lengths {
                omega: lengths.0,
                magnitude: lengths.1,
                weight: lengths.2,
            });
        }
        let check = |field, list: &[f64], rule, good: &dyn Fn(usize, f64) -> bool| {
            let bad = list.iter().enumerate().find(|(k, v)| !good(*k, **v));
            match bad {
                None => Ok(()),
                Some((index, value)) => Err(DfitError::Value {
                    field,
                    index,
                    value: *value,
                    rule,
                }),
            }
        };
        let ascending = |k: usize, v: f64| {
            v.is_finite()
                && v >= 0.0
                && (k == 0 || v > omega[k - 1])
                && (k + 1 < lengths.0 || v > 0.0)
        };
        check(
            "omega",
            &omega,
            "frequencies must be finite, not negative and ascending",
            &ascending,
        )?;
        check(
            "magnitude",
            &magnitude,
            "must be finite and positive",
            &|_, v| v.is_finite() && v > 0.0,
        )?;
        check(
            "weight",
            &weight,
            "must be finite and not negative",
            &|_, v| v.is_finite() && v >= 0.0,
        )?;
        let (lo, hi) = corner_range(&omega);
        Ok(Self {
            omega_rad_s: omega,
            magnitude,
            weight,
            limits: Limits {
                ln_omega: (lo - BEYOND, hi + BEYOND),
                ln_damping: LN_DAMPING,
            },
        })
    }

    /// The constant with the smallest weighted error.
    fn constant(&self) -> Factors {
        let logs = self.magnitude.iter().map(|m| m.ln());
        let (lo, hi) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        polish(self, Factors::constant(0.5 * (lo + hi)), 3)
    }
}

/// Corners may lie three decades beyond the data.
const BEYOND: f64 = 6.9;

/// ln of the first positive and the last frequency.
fn corner_range(omega: &[f64]) -> (f64, f64) {
    let lo = omega.iter().find(|w| **w > 0.0).map_or(0.0, |w| w.ln());
    let hi = omega.last().map_or(0.0, |w| w.max(1e-300).ln());
    (lo, hi)
}

/// A fit with its certificate.
#[derive(Clone, Debug)]
pub struct DFit {
    /// Poles and zeros.
    pub factors: Factors,
    /// max |ln(|d|/magnitude)|, evaluated from the state space.
    pub max_abs_ln_error: f64,
    /// The same times the weight.
    pub max_weighted_ln_error: f64,
    /// Stable realisation of d with a stable inverse.
    pub system: StateSpace<Continuous>,
}

/// Fits of order 0, 1, … `highest`; the weighted error never grows with the order.
///
/// # Errors
/// [`DfitError::Numeric`] when a fit cannot be realised.
pub fn fit_up_to(data: &Magnitudes, highest: usize) -> Result<Vec<DFit>, DfitError> {
    let mut fits = vec![realised(data, data.constant())?];
    for order in 1..=highest {
        let lower = fits[order - 1].factors.clone();
        let mut best = embedded(data, &lower);
        let mut error = weighted_error(data, &best);
        // Below this the lower order is exact already.
        if error > 1e-9 {
            for start in starts(data, order, &lower) {
                let trial = polish(data, start, 60);
                let next = weighted_error(data, &trial);
                if next < error {
                    (best, error) = (trial, next);
                }
            }
        }
        fits.push(realised(data, best)?);
    }
    Ok(fits)
}

/// One fit of a given order with little effort: the linear programmes from a constant, and a short polish.
pub fn fit_quick(data: &Magnitudes, order: usize) -> Factors {
    let constant = data.constant();
    if order == 0 {
        return constant;
    }
    let mut best = constant.clone();
    for _ in 0..order {
        best = embedded(data, &best);
    }
    match dfit_linear::fit(data, order, &constant) {
        Some(start) => {
            let trial = polish(data, start, 40);
            if weighted_error(data, &trial) < weighted_error(data, &best) {
                trial
            } else {
                best
            }
        }
        None => polish(data, best, 20),
    }
}

/// The lower order with a pole and a zero that cancel, in the middle of the data.
fn embedded(data: &Magnitudes, lower: &Factors) -> Factors {
    let (lo, hi) = corner_range(&data.omega_rad_s);
    let middle = 0.5 * (lo + hi);
    lower.extended(middle, middle)
}

/// The optimum of the linear programmes, and the lower order with a pole and a zero set apart at several places.
fn starts(data: &Magnitudes, order: usize, lower: &Factors) -> Vec<Factors> {
    let mut list = vec![];
    list.extend(dfit_linear::fit(data, order, lower));
    let (lo, hi) = corner_range(&data.omega_rad_s);
    for k in 0..3 {
        let place = lo + (hi - lo) * (f64::from(k) + 0.5) / 3.0;
        list.push(lower.extended(place - 0.3, place + 0.3));
        list.push(lower.extended(place + 0.3, place - 0.3));
    }
    list
}

/// State space and errors of a fit.
///
/// # Errors
/// [`DfitError::Numeric`] when a parameter is not finite.
pub fn realised(data: &Magnitudes, factors: Factors) -> Result<DFit, DfitError> {
    let system = factors.state_space()?;
    let (mut plain, mut weighted) = (0.0f64, 0.0f64);
    for (w, m, weight) in data.points() {
        let value = system.transfer(crate::linalg::c64::new(0.0, w))[(0, 0)].norm();
        let error = (value / m).ln().abs();
        plain = plain.max(error);
        weighted = weighted.max(error * weight);
    }
    Ok(DFit {
        factors,
        max_abs_ln_error: plain,
        max_weighted_ln_error: weighted,
        system,
    })
}
