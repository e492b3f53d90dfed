//! Records turned into whitened residuals.
//!
//! Between repeats two things change: white noise of the loop, and the gain of every sensor axis (levitated anew). The
//! gains are estimated repeat by repeat, a_pi = argmin Σ|y_p − (1+a_pi)(Ĝu_p)_i|²/S_i, and leave the noise; their mean
//! error stays as a nuisance parameter with the standard deviation seen. Row i of Ĝ then has the covariance S_i/P ·
//! (ŪŪᴴ)⁻ᵀ. A model error ε²·½(|G_ij|² + local mean) is added: it is lowered step by step in a fit, so that resonances
//! find each other. Residuals are whitened by the Cholesky factor, χ² = 2Σ|w|² with the real and imaginary part counted
//! each.

use super::super::DiagnoseError;
use super::common_error::Known;
use super::covariance::cholesky;
use super::measurement::{ControlAxis, RecordSet};
use crate::identify::frf::AXES;
use crate::identify::repeat_scatter::RepeatScatter;
use crate::identify::{MeasuredFrf, SweepRecord, open_loop};
use crate::linalg::c64;
use crate::linalg::small::eliminate;
use crate::lti::HeldResponse;
use crate::spindle::response::{SIDE, Square, ZERO};
use std::f64::consts::TAU;

/// Floor of the gap: re-levitation and amplitude dependence that repeats do not show.
pub(crate) const GAP_FLOOR: f64 = 0.005;
/// Power of a disturbance that all experiments share, in units of the noise: repeats show how it differs between a few
/// phases, not how large it is, so that what they have in common counts for nothing.
const UNKNOWN_SIZE: f64 = 1e4;
/// Lines on either side over which noise and magnitude are averaged.
const POOL: usize = 10;
/// Least standard deviation of an axis gain's mean: what calibration leaves between the axes of a rig, which no repeat
/// shows.
const AXIS_GAIN_FLOOR: f64 = 2e-3;

/// Whether a channel is held out where no hammer test is: that of the rear sensors from the front currents. The shaft
/// is the same both ways, so that the channels of the front sensors from the rear currents predict it.
pub fn held_out(output: usize, input: usize) -> bool {
    output / 2 == 1 && input / 2 == 0
}

/// Which parts of the evidence a fit sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subset {
    /// Every n-th line.
    pub stride: usize,
    /// Hammer tests.
    pub taps: bool,
    /// The channels that [`held_out`] picks.
    pub off_diagonal: bool,
}

impl Subset {
    /// Everything.
    pub const ALL: Self = Self { stride: 1, taps: true, off_diagonal: true };
}

/// One sweep.
#[derive(Clone, Debug)]
pub struct SweepEvidence {
    /// rad/s.
    pub speed_rad_s: f64,
    /// Lines, rad/s.
    pub omega_rad_s: Vec<f64>,
    /// Ĝ, row-major 4×4.
    pub response: Vec<[c64; 16]>,
    /// (ŪŪᴴ)⁻ᵀ/P, row-major 4×4.
    pub(super) spread: Vec<[c64; 16]>,
    /// The same of one disturbance in all experiments, row-major 4×4, and whether axis i has one.
    pub(super) common: Vec<[c64; 16]>,
    pub(super) shares: [bool; 4],
    /// S_i.
    pub(super) noise: Vec<[f64; 4]>,
    /// ½(|G|² + local mean).
    pub(super) size: Vec<[f64; 16]>,
    /// σ of the gap.
    pub(super) gap_sigma: Vec<[f64; 16]>,
    /// Share of the record that lies before a line.
    pub(super) position: Vec<f64>,
    /// Standard deviation of the mean axis gain.
    pub axis_gain_sd: [f64; 4],
}

/// One hammer test.
#[derive(Clone, Debug)]
pub struct TapEvidence {
    /// rad/s.
    pub speed_rad_s: f64,
    /// Lines, rad/s.
    pub omega_rad_s: Vec<f64>,
    /// Compliance, m/N.
    pub compliance: Vec<c64>,
    pub(super) noise: Vec<f64>,
    pub(super) size: Vec<f64>,
    pub(super) gap_sigma: Vec<f64>,
    /// K, row-major 4×4.
    pub(super) controller: Vec<[c64; 16]>,
    /// 0 for x, 1 for y.
    pub axis: usize,
}

/// All records.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Sweeps.
    pub sweeps: Vec<SweepEvidence>,
    /// Hammer tests.
    pub taps: Vec<TapEvidence>,
    /// Smooth model errors that fits have made from these records, so that each is made once.
    pub(in crate::diagnose) smooth: Known,
}

/// Root mean square of |measured − model|/σ over lines and channels, σ with a model error of 0.5 % of the magnitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gap {
    sum: f64,
    count: usize,
}

impl Gap {
    /// The gap; 0 without data.
    pub fn value(&self) -> f64 {
        if self.count == 0 { 0.0 } else { (self.sum / self.count as f64).sqrt() }
    }

    /// Number of complex residuals.
    pub fn count(&self) -> usize {
        self.count
    }

    /// One more residual in σ. An entry that is zero in every repeat has no σ and tells nothing.
    pub fn add(&mut self, ratio: f64) {
        if ratio.is_finite() {
            self.sum += ratio * ratio;
            self.count += 1;
        }
    }

    pub(crate) fn merge(self, other: Self) -> Self {
        Self { sum: self.sum + other.sum, count: self.count + other.count }
    }
}

impl Evidence {
    /// Evidence of a measurement.
    ///
    /// # Errors
    /// [`DiagnoseError::NoSweep`], or [`DiagnoseError::Record`] for a record that gives no frequency response.
    pub fn new(measurement: &RecordSet) -> Result<Self, DiagnoseError> {
        if measurement.sweeps.is_empty() {
            return Err(DiagnoseError::NoSweep);
        }
        Self::of(measurement)
    }

    /// Evidence of records that need not hold a sweep.
    ///
    /// # Errors
    /// [`DiagnoseError::Record`] for a record that gives no frequency response.
    pub fn of(measurement: &RecordSet) -> Result<Self, DiagnoseError> {
        let sweeps: Result<Vec<_>, _> = measurement.sweeps.iter().map(sweep).collect();
        let taps = measurement.taps.iter().map(|tap| {
            let frf = &tap.frf;
            let lines = frf.frequency_hz.len();
            let omega_rad_s: Vec<f64> = frf.frequency_hz.iter().map(|f| TAU * f).collect();
            let power: Vec<f64> = frf.compliance.iter().map(|h| h.norm_sqr()).collect();
            let mean = pool_variances(&power);
            TapEvidence {
                speed_rad_s: frf.speed_rpm * TAU / 60.0,
                noise: frf.sigmas(0.0).iter().map(|sigma| sigma.powi(2)).collect(),
                size: (0..lines).map(|k| 0.5 * (power[k] + mean[k])).collect(),
                gap_sigma: frf.sigmas(GAP_FLOOR),
                controller: held(tap.controller, &omega_rad_s),
                axis: usize::from(tap.axis == ControlAxis::Y),
                compliance: frf.compliance.clone(),
                omega_rad_s,
            }
        });
        Ok(Self { taps: taps.collect(), smooth: Known::default(), sweeps: sweeps? })
    }

    /// Standard deviations of the axis gains, sweep by sweep.
    pub fn axis_gain_sd(&self) -> Vec<[f64; 4]> {
        self.sweeps.iter().map(|s| s.axis_gain_sd).collect()
    }
}

/// K on lines, row-major.
pub(super) fn held(controller: &dyn HeldResponse, omega_rad_s: &[f64]) -> Vec<[c64; 16]> {
    let line = |w: &f64| {
        let k = controller.held_at(*w);
        std::array::from_fn(|i| k[(i / 4, i % 4)])
    };
    omega_rad_s.iter().map(line).collect()
}

fn pool_variances(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    (0..n)
        .map(|k| {
            let window = &values[k.saturating_sub(POOL)..(k + POOL + 1).min(n)];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

/// Noise of every line and axis of a single repeat: what a line differs by from the mean of its neighbours, in the
/// experiment of the other plane of axes, where there is hardly any response that could differ.
fn scatter_of_neighbours(frf: &MeasuredFrf) -> Vec<[f64; 4]> {
    let lines = frf.frequency_hz.len();
    let y = |k: usize, i: usize, e: usize| frf.signal[(k, i, e)];
    // Of exponentially distributed squares the median is ln 2 times the mean; the difference has 3/2 of the variance.
    let scale = 1.0 / (1.5 * std::f64::consts::LN_2);
    let mut noise = vec![[0.0; 4]; lines];
    for i in 0..4 {
        let of = |e: usize| -> Vec<f64> {
            let own = |k: usize| {
                let k = k.clamp(1, lines.saturating_sub(2).max(1));
                match (k + 1 < lines).then(|| y(k, i, e) - (y(k - 1, i, e) + y(k + 1, i, e)) * 0.5) {
                    Some(difference) => difference.norm_sqr(),
                    None => y(0, i, e).norm_sqr(),
                }
            };
            let all: Vec<f64> = (0..lines).map(own).collect();
            medians(&all).iter().map(|m| m * scale).collect()
        };
        let quiet: Vec<Vec<f64>> = (0..4).filter(|e| e % 2 != i % 2).map(of).collect();
        for (k, noise) in noise.iter_mut().enumerate() {
            let low = quiet.iter().map(|q| q[k]).fold(f64::INFINITY, f64::min);
            let mean = quiet.iter().map(|q| q[k]).sum::<f64>() / quiet.len() as f64;
            // Medians of some twenty lines scatter by a third; what is further apart is a response.
            noise[i] = if mean < 2.0 * low { mean } else { low };
        }
    }
    noise
}

/// Medians over the lines of a pool.
fn medians(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    (0..n)
        .map(|k| {
            let mut window = values[k.saturating_sub(POOL)..(k + POOL + 1).min(n)].to_vec();
            window.sort_by(f64::total_cmp);
            window[window.len() / 2]
        })
        .collect()
}

/// Upper 90 % limit of a variance that was estimated as 1 from so many real numbers: n/χ²₀.₁(n), after Wilson and
/// Hilferty (1931). Run-out leaks into all lines of a repeat in one phase, so that each experiment of each repeat says
/// of it no more than one line does.
fn variance_limit(freedom: usize) -> f64 {
    const LOWER_TENTH: f64 = -1.2816;
    let spread = 2.0 / (9.0 * freedom as f64);
    (1.0 - spread + LOWER_TENTH * spread.sqrt()).powi(-3)
}

fn sweep(record: &SweepRecord) -> Result<SweepEvidence, DiagnoseError> {
    let frf: MeasuredFrf = open_loop(record)?;
    let (lines, _, repeats, _) = record.current.dim();
    let g = |k: usize, i: usize, j: usize| frf.response[(k, i, j)];
    let RepeatScatter { gains, smooth: mut noise, shares, .. } = RepeatScatter::of(record, &frf, &pool_variances);
    let axis_gain_sd = std::array::from_fn(|i| {
        let square: f64 = gains.iter().map(|g| g[i] * g[i]).sum();
        let of_one = square / repeats.saturating_sub(1).max(1) as f64;
        (of_one / repeats as f64).sqrt().max(AXIS_GAIN_FLOOR)
    });
    let (mut spread, mut common) = (Vec::with_capacity(lines), Vec::with_capacity(lines));
    for k in 0..lines {
        let mut u: Vec<c64> = (0..16).map(|n| frf.current[(k, n / 4, n % 4)]).collect();
        let mut inverse: Vec<c64> = (0..16).map(|n| c64::new(f64::from(u8::from(n / 4 == n % 4)), 0.0)).collect();
        eliminate(&mut u, &mut inverse, 4, 4);
        let once: [c64; 4] = std::array::from_fn(|j| (0..4).fold(ZERO, |sum, e| sum + inverse[e * 4 + j]));
        common.push(std::array::from_fn(|n| once[n / 4] * once[n % 4].conj()));
        // inverse is experiment×axis; error of row i is v_i·U⁻¹.
        spread.push(std::array::from_fn(|n| {
            let (j, l) = (n / 4, n % 4);
            (0..4).fold(ZERO, |sum, e| sum + inverse[e * 4 + j] * inverse[e * 4 + l].conj()) / repeats as f64
        }));
    }
    if repeats < 2 {
        noise = scatter_of_neighbours(&frf);
    }
    let inflation = if record.run_out { variance_limit(2 * AXES * repeats.saturating_sub(1).max(1)) } else { 1.0 };
    noise.as_flattened_mut().iter_mut().for_each(|noise| *noise *= inflation);
    let mut size = vec![[0.0; 16]; lines];
    for n in 0..16 {
        let power: Vec<f64> = (0..lines).map(|k| g(k, n / 4, n % 4).norm_sqr()).collect();
        for (k, mean) in pool_variances(&power).into_iter().enumerate() {
            size[k][n] = 0.5 * (power[k] + mean);
        }
    }
    Ok(SweepEvidence {
        speed_rad_s: record.speed_rpm * TAU / 60.0,
        omega_rad_s: record.frequency_hz.iter().map(|f| TAU * f).collect(),
        response: (0..lines).map(|k| std::array::from_fn(|n| g(k, n / 4, n % 4))).collect(),
        gap_sigma: (0..lines)
            .map(|k| {
                std::array::from_fn(|n| match repeats {
                    // The record itself knows nothing of its noise.
                    1 => {
                        let of_noise = noise[k][n / 4] * spread[k][5 * (n % 4)].re;
                        (of_noise + GAP_FLOOR.powi(2) * g(k, n / 4, n % 4).norm_sqr()).sqrt()
                    }
                    _ => inflation.sqrt() * frf.sigma(k, n / 4, n % 4, GAP_FLOOR),
                })
            })
            .collect(),
        spread,
        common,
        shares,
        noise,
        size,
        position: (0..lines).map(|k| k as f64 / (lines.max(2) - 1) as f64).collect(),
        axis_gain_sd,
    })
}

impl SweepEvidence {
    /// Lower Cholesky factors of the four rows' covariances with A model error, row-major.
    pub(crate) fn whitening(&self, line: usize, model_error: f64, off_diagonal: bool) -> [[c64; 16]; 4] {
        std::array::from_fn(|i| {
            let mut c: [c64; 16] = self.spread[line].map(|x| x * self.noise[line][i]);
            if self.shares[i] {
                let unknown = UNKNOWN_SIZE * self.noise[line][i];
                c.iter_mut().zip(&self.common[line]).for_each(|(c, common)| *c += common * unknown);
            }
            for j in 0..4 {
                c[5 * j] += model_error * model_error * self.size[line][4 * i + j];
                if !off_diagonal && held_out(i, j) {
                    // A channel that is held out carries no information.
                    for l in 0..4 {
                        if l != j {
                            c[4 * j + l] = ZERO;
                            c[4 * l + j] = ZERO;
                        }
                    }
                    c[5 * j] = c64::new(self.size[line][4 * i + j].max(f64::MIN_POSITIVE) * 1e12, 0.0);
                }
            }
            cholesky(&mut c);
            c
        })
    }

    /// σ of the gap for a channel at a line.
    pub fn sigma(&self, line: usize, output: usize, input: usize) -> f64 {
        self.gap_sigma[line][4 * output + input]
    }

    /// Residual of a predicted F in σ of the gap, added to `gap` for the channels that `wanted(output, input)` picks.
    pub fn gap(&self, line: usize, f: &Square, wanted: impl Fn(usize, usize) -> bool, gap: &mut Gap) {
        for i in 0..4 {
            for j in 0..4 {
                if wanted(i, j) {
                    let r = self.response[line][4 * i + j] - f[SIDE * i + j];
                    gap.add(r.norm() / self.gap_sigma[line][4 * i + j]);
                }
            }
        }
    }
}

impl TapEvidence {
    /// Standard deviation of a line with A model error.
    pub fn sd(&self, line: usize, model_error: f64) -> f64 {
        (self.noise[line] + model_error * model_error * self.size[line]).sqrt()
    }

    /// σ of the gap at a line.
    pub fn sigma(&self, line: usize) -> f64 {
        self.gap_sigma[line]
    }

    /// Closed-loop compliance of F, and the rows that turn ∂F into its derivative: ∂h = l ∂F r.
    pub fn close(&self, line: usize, f: &Square) -> (c64, [c64; SIDE], [c64; SIDE]) {
        let k = &self.controller[line];
        let tool = 4 + self.axis;
        // r = [K (I − G K)⁻¹ g_t; e_t],  l = [g_tu K (I − G K)⁻¹ , e_t]
        let mut gk = [ZERO; 16];
        for i in 0..4 {
            for j in 0..4 {
                let sum = (0..4).fold(ZERO, |s, m| s + f[SIDE * i + m] * k[4 * m + j]);
                gk[4 * i + j] = c64::new(f64::from(u8::from(i == j)), 0.0) - sum;
            }
        }
        let mut y: [c64; 4] = std::array::from_fn(|i| f[SIDE * i + tool]);
        eliminate(&mut gk.clone(), &mut y, 4, 1);
        let mut transposed: [c64; 16] = std::array::from_fn(|n| gk[4 * (n % 4) + n / 4]);
        let mut t: [c64; 4] = std::array::from_fn(|j| (0..4).fold(ZERO, |s, m| s + f[SIDE * tool + m] * k[4 * m + j]));
        eliminate(&mut transposed, &mut t, 4, 1);
        let (mut l, mut r) = ([ZERO; SIDE], [ZERO; SIDE]);
        l[..4].copy_from_slice(&t);
        for m in 0..4 {
            r[m] = (0..4).fold(ZERO, |s, j| s + k[4 * m + j] * y[j]);
        }
        l[tool] = c64::new(1.0, 0.0);
        r[tool] = c64::new(1.0, 0.0);
        let h = f[SIDE * tool + tool] + (0..4).fold(ZERO, |s, m| s + f[SIDE * tool + m] * r[m]);
        (h, l, r)
    }

    /// Residual in σ of the gap.
    pub fn gap(&self, line: usize, f: &Square, gap: &mut Gap) {
        let (h, ..) = self.close(line, f);
        gap.add((self.compliance[line] - h).norm() / self.gap_sigma[line]);
    }
}
