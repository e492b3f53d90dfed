//! The block of channels and lines that a set of effects explains worst.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::linearise::Record;
use super::super::fit::problem::Point;

/// A block of channels and lines whose χ² per residual exceeds this is not explained by noise: 240 residuals scatter by
/// 0.1, noise that is not quite white has reached 1.6.
pub(crate) const FAILING_BLOCK_CHI2: f64 = 2.2;

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

/// Sums of squared residuals by channel.
#[derive(Clone, Default)]
struct ChannelMisfit {
    sums: [f64; 16],
    count: usize,
}

/// Number of bands of a sweep.
fn bands(lines: usize) -> usize {
    (lines / 60).clamp(1, 8)
}

impl Case<'_> {
    /// Largest χ² per residual over blocks of channels and bands at a model error: 1 where noise explains everything.
    ///
    /// # Errors
    /// As [`Self::fit_down`].
    pub fn misfit(&self, effects: &[Hypothesis], at: &Point, model_error: f64) -> Result<Misfit, DiagnoseError> {
        let problem = self.problem(effects, Subset::ALL);
        let residual = problem.residual(at, model_error)?;
        let mut worst = Misfit::default();
        let blocks: Vec<Vec<ChannelMisfit>> = (self.evidence.sweeps.iter())
            .map(|sweep| vec![ChannelMisfit::default(); bands(sweep.omega_rad_s.len())])
            .collect();
        let mut blocks = blocks;
        for (record, line, first) in problem.rows() {
            let Record::Sweep(s) = record else {
                continue;
            };
            let lines = self.evidence.sweeps[s].omega_rad_s.len();
            let block = &mut blocks[s][line * bands(lines) / lines];
            for (n, pair) in residual[first..first + 32].chunks(2).enumerate() {
                block.sums[n] += pair.iter().map(|r| r * r).sum::<f64>();
            }
            block.count += 2;
        }
        for (sweep, blocks) in self.evidence.sweeps.iter().zip(&blocks) {
            let lines = sweep.omega_rad_s.len();
            let edge = |b: usize| {
                let line = (b * lines / blocks.len()).min(lines - 1);
                sweep.omega_rad_s[line] / std::f64::consts::TAU
            };
            for (band, block) in blocks.iter().enumerate() {
                for (n, sum) in block.sums.iter().enumerate() {
                    let value = sum / block.count.max(1) as f64;
                    if value > worst.value {
                        worst = Misfit { value, output: n / 4, input: n % 4, band_hz: (edge(band), edge(band + 1)) };
                    }
                }
            }
        }
        Ok(worst)
    }
}
