//! Disc margins of a loop over frequency: what each channel bears alone, the others as they are, and what all channels
//! bear at once, each with a factor of its own. The latter is the diagonally scaled largest singular value of S + T or
//! of S, a bound of μ for four complex factors: the unscaled one would count a displacement that one bearing shows at
//! the other as a lack of margin.
//!
//! Feedback is positive here: with L = −G K, S = (I + L)⁻¹ and T = S − I, so that S − I/2 = (S + T)/2 is what
//! [`DiscMargin`] takes for skew 0.

use super::closed_loop::{AXES, sensitivity};
use crate::augment::Block;
use crate::linalg::{Mat, c64};
use crate::lti::{FrequencyGrid, HeldResponse, Response};
use crate::robust::disc_margin::DiscMargin;
use crate::robust::mu::upper_bound;
use crate::robust::structure::{MuError, Scaling};
use rayon::prelude::*;

/// The margins of a stable loop on the lines of a grid.
#[derive(Clone, Copy, Debug)]
pub struct DiscMargins {
    /// Of each channel alone, skew 0: gains from (2 − α)/(2 + α) to its inverse.
    pub channels: [DiscMargin; AXES],
    /// Of all channels at once, skew 0 (S + T).
    pub together: DiscMargin,
    /// Of all channels at once, skew 1 (S).
    pub together_by_sensitivity: DiscMargin,
}

impl DiscMargins {
    /// Of a loop that is stable.
    ///
    /// # Errors
    /// [`MuError`] when a decomposition fails.
    pub fn new(plant: &dyn Response, controller: &dyn HeldResponse, grid: &FrequencyGrid) -> Result<Self, MuError> {
        let lines = grid.omega_rad_s();
        let s: Vec<Mat<c64>> = lines.par_iter().map(|w| sensitivity(plant, controller, *w)).collect();
        let alone = |channel: usize| {
            let size = |s: &Mat<c64>| (s[(channel, channel)] - 0.5).norm();
            let peaks = s.iter().map(size).zip(lines);
            let peak = peaks.fold((0.0, 0.0), |best, (size, w)| if size > best.0 { (size, *w) } else { best });
            DiscMargin::on_lines(0.0, peak)
        };
        let (together, by_sensitivity) = rayon::join(|| scaled_peak(&s, lines, 0.0), || scaled_peak(&s, lines, 1.0));
        Ok(Self { channels: std::array::from_fn(alone), together: together?, together_by_sensitivity: by_sensitivity? })
    }

    /// The channel that bears least.
    pub fn worst_channel(&self) -> &DiscMargin {
        let [first, others @ ..] = &self.channels;
        others.iter().fold(first, |worst, own| if own.alpha < worst.alpha { own } else { worst })
    }
}

/// The margin of all channels at once: the largest μ of S + (σ − 1)/2 over the lines.
fn scaled_peak(s: &[Mat<c64>], lines: &[f64], skew: f64) -> Result<DiscMargin, MuError> {
    let blocks = [Block::ComplexScalar { n: 1 }; AXES];
    let mut peak = (0.0, 0.0);
    let mut guide: Option<Scaling> = None;
    for (s, omega) in s.iter().zip(lines) {
        let m = Mat::from_fn(AXES, AXES, |i, j| s[(i, j)] + if i == j { 0.5 * (skew - 1.0) } else { 0.0 });
        // Any scaling gives a bound: where that of the last line is low enough, the best one is, too.
        if guide.as_ref().is_some_and(|scaling| scaling.bound_from(&m, peak.0) <= peak.0) {
            continue;
        }
        let (upper, scaling) = upper_bound(&m, &blocks)?;
        if upper > peak.0 {
            peak = (upper, *omega);
        }
        guide = Some(scaling);
    }
    Ok(DiscMargin::on_lines(skew, peak))
}
