//! Frequency grids and anything that has a frequency response: state space, measured data, plants with exact delay.

use super::state_space::{StateSpace, TimeBase};
use crate::linalg::{Mat, c64};

/// Anything that answers with a complex matrix at an angular frequency.
pub trait Response: Sync {
    /// Response at `omega_rad_s`, outputs × inputs.
    fn at(&self, omega_rad_s: f64) -> Mat<c64>;
}

impl<T: TimeBase> Response for StateSpace<T> {
    fn at(&self, omega_rad_s: f64) -> Mat<c64> {
        self.transfer(self.time.point(omega_rad_s))
    }
}

/// Lines round poles that are closer than this share of their frequency are one: far above the rounding of an
/// eigenvalue, far below the width of a peak.
const SAME_LINE: f64 = 1e-7;

/// Sorted, positive, finite angular frequencies without duplicates.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyGrid {
    omega_rad_s: Vec<f64>,
}

/// Numbers spaced evenly in the logarithm, ends included and exact; one number is the first.
pub(crate) fn even_in_logarithm(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    let last = count.saturating_sub(1).max(1);
    (0..count).map(move |k| match k {
        0 => from,
        _ if k == last => to,
        _ => from * (to / from).powf(k as f64 / last as f64),
    })
}

impl FrequencyGrid {
    /// A grid from any list of frequencies in Hz; sorts, drops what is not positive and finite, removes duplicates.
    pub fn from_hz(frequencies_hz: impl IntoIterator<Item = f64>) -> Self {
        Self::from_rad_s(frequencies_hz.into_iter().map(|f| f * std::f64::consts::TAU))
    }

    /// A grid from any list of angular frequencies in rad/s, cleaned like [`Self::from_hz`].
    pub(crate) fn from_rad_s(omega_rad_s: impl IntoIterator<Item = f64>) -> Self {
        let mut grid: Vec<f64> = omega_rad_s.into_iter().filter(|w| w.is_finite() && *w > 0.0).collect();
        grid.sort_by(f64::total_cmp);
        grid.dedup();
        Self { omega_rad_s: grid }
    }

    /// `points` frequencies spaced evenly in the logarithm from `from_hz` to `to_hz`, ends included.
    pub fn log_hz(from_hz: f64, to_hz: f64, points: usize) -> Self {
        Self::from_hz(even_in_logarithm(from_hz, to_hz, points))
    }

    /// This grid with, for every lightly damped pole (rad/s) within it, points packed round its resonance:
    /// `per_side` points a side, spaced geometrically from a tenth of the half-power width out to 10 widths.
    pub(crate) fn refine_round_poles(&self, poles_rad_s: &[c64], per_side: usize) -> Self {
        let (Some(lo), Some(hi)) = (self.omega_rad_s.first(), self.omega_rad_s.last()) else {
            return self.clone();
        };
        let mut all = self.omega_rad_s.clone();
        for pole in poles_rad_s {
            let (centre, width) = (pole.im.abs(), pole.re.abs().max(1e-9 * pole.norm()));
            // Above a third of critical damping the plain grid is dense enough: no peak stands out.
            if centre < *lo || centre > *hi || width > 0.33 * pole.norm() {
                continue;
            }
            all.push(centre);
            for k in 0..per_side {
                // Ratio 100 from a tenth to ten half-power widths covers the peak and both its skirts.
                let step = 0.1 * width * 100f64.powf(k as f64 / per_side.max(2) as f64);
                all.extend([centre - step, centre + step].into_iter().filter(|w| w >= lo && w <= hi));
            }
        }
        // Equal planes have the same poles: without this a line next to its double would be a local maximum.
        all.sort_by(f64::total_cmp);
        all.dedup_by(|b, a| *b < *a * (1.0 + SAME_LINE));
        Self::from_rad_s(all)
    }

    /// Angular frequencies, rad/s, ascending.
    pub fn omega_rad_s(&self) -> &[f64] {
        &self.omega_rad_s
    }

    /// Frequencies, Hz, ascending.
    pub fn hz(&self) -> Vec<f64> {
        self.omega_rad_s.iter().map(|w| w / std::f64::consts::TAU).collect()
    }

    /// Number of lines.
    pub fn len(&self) -> usize {
        self.omega_rad_s.len()
    }

    /// True for a grid without lines.
    pub fn is_empty(&self) -> bool {
        self.omega_rad_s.is_empty()
    }
}
