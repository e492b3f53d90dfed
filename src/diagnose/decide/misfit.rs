//! The block of channels and lines that a set of effects explains worst.

use super::super::DiagnoseError;
use super::super::data::evidence::whiten;
use super::super::fit::case::Case;
use super::super::fit::hypothesis::{self, Hypothesis};
use super::super::fit::problem::Point;
use crate::spindle::response::SIDE;

/// A block of channels and lines whose χ² per residual exceeds this is not explained by noise: 240 residuals scatter by
/// 0.1, noise that is not quite white has reached 1.6.
pub const FAILING_BLOCK_CHI2: f64 = 2.2;

/// The worst block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Misfit {
    /// χ² per residual.
    pub value: f64,
    /// Sensor axis.
    pub output: usize,
    /// Current axis.
    pub input: usize,
    /// From, to, Hz.
    pub band_hz: (f64, f64),
}

impl Case<'_> {
    /// Largest χ² per residual over blocks of channels and bands at a model error: 1 where noise explains everything.
    ///
    /// # Errors
    /// As [`Self::fit_down`].
    pub fn misfit(
        &self,
        effects: &[Hypothesis],
        at: &Point,
        model_error: f64,
    ) -> Result<Misfit, DiagnoseError> {
        let named = hypothesis::effects(effects, &at.theta);
        let mut worst = Misfit::default();
        for (s, sweep) in self.evidence.sweeps.iter().enumerate() {
            let model = self
                .model
                .assemble(&at.p, &named, sweep.speed_rad_s, false)?;
            let lines = sweep.omega_rad_s.len();
            let bands = (lines / 60).clamp(1, 8);
            let mut sums = vec![[0.0; 16]; bands];
            let mut counts = vec![0usize; bands];
            for line in 0..lines {
                let band = line * bands / lines;
                let f = model.line(sweep.omega_rad_s[line], None).response;
                let rows = sweep.whitening(line, model_error, true);
                for i in 0..4 {
                    let gain = 1.0 + at.p[self.model.layout.axis(s, i)];
                    let mut d: [_; 4] = std::array::from_fn(|j| {
                        sweep.response[line][4 * i + j] - f[SIDE * i + j] * gain
                    });
                    whiten(&rows[i], &mut d);
                    for j in 0..4 {
                        sums[band][4 * i + j] += 2.0 * d[j].norm_sqr();
                    }
                }
                counts[band] += 2;
            }
            for band in 0..bands {
                for n in 0..16 {
                    let value = sums[band][n] / counts[band].max(1) as f64;
                    if value > worst.value {
                        let edge = |b: usize| {
                            sweep.omega_rad_s[(b * lines / bands).min(lines - 1)]
                                / std::f64::consts::TAU
                        };
                        worst = Misfit {
                            value,
                            output: n / 4,
                            input: n % 4,
                            band_hz: (edge(band), edge(band + 1)),
                        };
                    }
                }
            }
        }
        Ok(worst)
    }
}
