//! Magnitudes over frequency that a D-scale is fitted to, checked.

use super::factors::FitRanges;
use crate::linalg::NumericError;
use thiserror::Error;

/// What is wrong with the data of a fit.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DfitError {
    /// Lists of different or zero length.
    #[error("omega, magnitude and weight need the same length of at least 2, found {omega}, {magnitude} and {weight}")]
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
    pub limits: FitRanges,
}

/// ln of the damping ratios of a fit: sharper corners than ζ = 1e-3 cannot be told from noise of the data, and ζ = 1e4
/// separates the two real roots by eight decades.
const LN_DAMPING: (f64, f64) = (-6.9, 9.2);

impl Magnitudes {
    /// Frequency, magnitude and weight of every point.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let both = self.omega_rad_s.iter().zip(&self.magnitude);
        both.zip(&self.weight).map(|((w, m), weight)| (*w, *m, *weight))
    }

    /// Checked data.
    ///
    /// # Errors
    /// [`DfitError`] naming the field, the position and the rule.
    pub fn new(omega: Vec<f64>, magnitude: Vec<f64>, weight: Vec<f64>) -> Result<Self, DfitError> {
        let lengths = (omega.len(), magnitude.len(), weight.len());
        if lengths.0 != lengths.1 || lengths.0 != lengths.2 || lengths.0 < 2 {
            return Err(DfitError::Lengths { omega: lengths.0, magnitude: lengths.1, weight: lengths.2 });
        }
        let check = |field, list: &[f64], rule, good: &dyn Fn(usize, f64) -> bool| {
            let bad = list.iter().enumerate().find(|(k, v)| !good(*k, **v));
            match bad {
                None => Ok(()),
                Some((index, value)) => Err(DfitError::Value { field, index, value: *value, rule }),
            }
        };
        let ascending = |k: usize, v: f64| {
            v.is_finite() && v >= 0.0 && (k == 0 || v > omega[k - 1]) && (k + 1 < lengths.0 || v > 0.0)
        };
        check("omega", &omega, "frequencies must be finite, not negative and ascending", &ascending)?;
        check("magnitude", &magnitude, "must be finite and positive", &|_, v| v.is_finite() && v > 0.0)?;
        check("weight", &weight, "must be finite and not negative", &|_, v| v.is_finite() && v >= 0.0)?;
        let (lo, hi) = corner_range(&omega);
        Ok(Self {
            omega_rad_s: omega,
            magnitude,
            weight,
            limits: FitRanges { ln_omega: (lo - BEYOND, hi + BEYOND), ln_damping: LN_DAMPING },
        })
    }
}

/// Corners may lie three decades beyond the data.
pub(super) const BEYOND: f64 = 6.9;

/// ln of the first positive and the last frequency.
pub(super) fn corner_range(omega: &[f64]) -> (f64, f64) {
    let lo = omega.iter().find(|w| **w > 0.0).map_or(0.0, |w| w.ln());
    let hi = omega.last().map_or(0.0, |w| w.max(1e-300).ln());
    (lo, hi)
}
