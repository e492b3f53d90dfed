//! Fit of a D-scale: a stable, minimum-phase d(s) of given order with |d(jω)| close to given magnitudes.
//!
//!   minimise  max over the data of  weight · |ln(|d(jω)| / magnitude)|
//!
//! `linear` comes near the global optimum of the unweighted problem in the coefficients of |d|², `polish` removes
//! what the linear programmes leave and takes the weights in. Orders are fitted upwards: a higher order also starts
//! from the lower one with a pole and a zero added, so its error is never larger.

pub(crate) mod exchange;
pub mod factors;
pub(crate) mod linear;
pub(crate) mod magnitudes;
pub(crate) mod metric;
pub(crate) mod polish;

use crate::lti::{Continuous, StateSpace};
use factors::Factors;
use linear::Units;
use magnitudes::corner_range;
pub use magnitudes::{DfitError, Magnitudes};
use polish::{polish, weighted_error};

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
    let mut fits = vec![realise_fit(data, constant(data))?];
    for order in 1..=highest {
        let lower = fits[order - 1].factors.clone();
        let mut best = embed_order(data, &lower);
        let mut error = weighted_error(data, &best);
        // Below this the lower order is exact already.
        if error > 1e-9 {
            for start in starts(data, &best, &lower) {
                let trial = polish(data, start, 60);
                let next = weighted_error(data, &trial);
                if next < error {
                    (best, error) = (trial, next);
                }
            }
        }
        fits.push(realise_fit(data, best)?);
    }
    Ok(fits)
}

/// One fit of a given order with little effort: the linear programmes from a constant, and a short polish.
pub fn fit_quick(data: &Magnitudes, order: usize) -> Factors {
    let constant = constant(data);
    if order == 0 {
        return constant;
    }
    let mut best = constant.clone();
    for _ in 0..order {
        best = embed_order(data, &best);
    }
    let start = linear::fit(data, &best, Units::Flat);
    match start.or_else(|| linear::fit(data, &best, Units::Start)) {
        Some(start) => {
            let trial = polish(data, start, 40);
            if weighted_error(data, &trial) < weighted_error(data, &best) { trial } else { best }
        }
        None => polish(data, best, 20),
    }
}

/// The lower order with a pole and a zero that cancel, in the middle of the data.
fn embed_order(data: &Magnitudes, lower: &Factors) -> Factors {
    let (lo, hi) = corner_range(&data.omega_rad_s);
    let middle = 0.5 * (lo + hi);
    lower.extend_factors(middle, middle)
}

/// What the linear programmes find, and the lower order with a pole and a zero set apart at several places.
fn starts(data: &Magnitudes, embedded: &Factors, lower: &Factors) -> Vec<Factors> {
    let mut list = vec![];
    for units in [Units::Start, Units::Flat] {
        list.extend(linear::fit(data, embedded, units));
    }
    let (lo, hi) = corner_range(&data.omega_rad_s);
    for k in 0..3 {
        let place = lo + (hi - lo) * (f64::from(k) + 0.5) / 3.0;
        list.push(lower.extend_factors(place - 0.3, place + 0.3));
        list.push(lower.extend_factors(place + 0.3, place - 0.3));
    }
    list
}

/// State space and errors of a fit.
///
/// # Errors
/// [`DfitError::Numeric`] when a parameter is not finite.
pub fn realise_fit(data: &Magnitudes, factors: Factors) -> Result<DFit, DfitError> {
    let system = factors.state_space()?;
    let (mut plain, mut weighted) = (0.0f64, 0.0f64);
    for (w, m, weight) in data.points() {
        let value = system.transfer(crate::linalg::c64::new(0.0, w))[(0, 0)].norm();
        let error = (value / m).ln().abs();
        plain = plain.max(error);
        weighted = weighted.max(error * weight);
    }
    Ok(DFit { factors, max_abs_ln_error: plain, max_weighted_ln_error: weighted, system })
}

/// The constant with the smallest weighted error.
fn constant(data: &Magnitudes) -> Factors {
    let logs = data.magnitude.iter().map(|m| m.ln());
    let (lo, hi) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    polish(data, Factors::constant(0.5 * (lo + hi)), 3)
}
