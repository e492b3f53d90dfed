//! Whether coefficients as they are held still have the transfer function that was designed: the largest change,
//! relative to the response at its own frequency, from far below the slowest pole to the Nyquist frequency. A change by
//! a share δ with the same number of unstable poles leaves every loop stable whose complementary sensitivity stays
//! below 1/δ (small gain).

use super::{ControllerError, in_step};
use crate::linalg::{Mat, c64};
use crate::lti::{Discrete, StateSpace};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Largest accepted change: 0.09 dB and 0.6° of phase, of which loops have decibels and tens of degrees; no loop with a
/// peak of its complementary sensitivity below 100 becomes unstable by it.
pub(crate) const LARGEST_CHANGE: f64 = 0.01;
/// Where the response is smaller than this share of its peak, the change is taken relative to that: notches are as deep
/// as rounding allows.
const SMALLEST_SHARE: f64 = 1e-3;
/// Share of the Nyquist frequency from which the peak is taken: an integrator has none at low frequency.
const PEAK_FROM: f64 = 1e-3;
/// Lowest frequency compared, as a share of Nyquist: a millihertz at 20 kHz.
const LOWEST_SHARE: f64 = 1e-7;
const POINTS_A_DECADE: i32 = 20;
/// Half width of the narrowest resonance that is resolved: rounding of single precision moves a narrower one by its
/// width.
const NARROWEST: f64 = 1e-7;
/// Poles this near the unit circle count as on it: at 100 kHz they decay within hours.
pub(crate) const ON_CIRCLE: f64 = 1e-9;

/// The largest change and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TransferChange {
    /// Relative to the response; NaN where a response is not finite.
    pub relative: f64,
    /// Angle on the unit circle.
    pub angle: f64,
}

impl TransferChange {
    /// No change.
    pub(crate) const NONE: Self = Self { relative: 0.0, angle: 0.0 };

    /// The larger one; NaN is largest.
    pub(crate) fn or_larger(self, relative: f64, angle: f64) -> Self {
        if self.relative.is_nan() || relative <= self.relative { self } else { Self { relative, angle } }
    }

    /// True for a change that leaves the controller what it was.
    pub(crate) fn is_accepted(&self) -> bool {
        self.relative <= LARGEST_CHANGE
    }

    /// Where it is, Hz.
    pub(crate) fn frequency_hz(&self, period_s: f64) -> f64 {
        self.angle / (2.0 * PI * period_s)
    }
}

/// Angles at which responses with these poles and zeros are compared, ascending: even in the logarithm, and across
/// every resonance and corner.
pub(crate) fn compared_angles(roots: &[c64]) -> Vec<f64> {
    let count = POINTS_A_DECADE * -LOWEST_SHARE.log10() as i32;
    let mut angles: Vec<f64> =
        (0..=count).map(|k| PI * 10f64.powf(f64::from(k - count) / f64::from(POINTS_A_DECADE))).collect();
    for root in roots.iter().filter(|r| r.im >= 0.0 && r.norm() > 0.0) {
        // On the circle there is no response to compare.
        let (width, centre) = ((root.norm() - 1.0).abs().max(NARROWEST), root.arg());
        angles.extend([-3.0, -1.0, -0.3, 0.3, 1.0, 3.0].map(|k| centre + k * width));
    }
    angles.retain(|a| *a >= PI * LOWEST_SHARE && *a <= PI);
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    angles
}

/// What a change is at least relative to: a small share of the peak of a response.
pub(crate) fn smallest_reference(angles: &[f64], sizes: &[f64]) -> f64 {
    let upper = angles.iter().zip(sizes).filter(|(angle, _)| **angle >= PI * PEAK_FROM);
    (SMALLEST_SHARE * upper.map(|(_, size)| *size).fold(0.0, f64::max)).max(f64::MIN_POSITIVE)
}

/// Number of poles outside the unit circle or on it.
pub(crate) fn count_growing(poles: &[c64]) -> usize {
    poles.iter().filter(|p| p.norm() >= 1.0 - ON_CIRCLE).count()
}

/// Largest change of an entry of the transfer matrix, relative to the entry, or to a small share of the peak of its
/// row.
pub(crate) fn transfer_change_by_entry(
    exact: &StateSpace<Discrete>,
    held: &StateSpace<Discrete>,
) -> Result<TransferChange, ControllerError> {
    let angles = compared_angles(&exact.poles().map_err(in_step("comparison of the transfer functions"))?);
    let responses = |system: &StateSpace<Discrete>| -> Vec<Mat<c64>> {
        angles.par_iter().map(|angle| system.transfer(c64::from_polar(1.0, *angle))).collect()
    };
    let (exact, held) = (responses(exact), responses(held));
    let Some(first) = exact.first() else {
        return Ok(TransferChange::NONE);
    };
    let (rows, columns) = (first.nrows(), first.ncols());
    let mut change = TransferChange::NONE;
    for i in 0..rows {
        let row = |m: &Mat<c64>| (0..columns).map(|j| m[(i, j)].norm()).fold(0.0, f64::max);
        let floor = smallest_reference(&angles, &exact.iter().map(row).collect::<Vec<_>>());
        for (angle, (exact, held)) in angles.iter().zip(exact.iter().zip(&held)) {
            for j in 0..columns {
                let size = exact[(i, j)].norm().max(floor);
                change = change.or_larger((held[(i, j)] - exact[(i, j)]).norm() / size, *angle);
            }
        }
    }
    Ok(change)
}
