//! μ of the specification on the whole machine: Table 2 and the defaults of what it leaves open, weights at true
//! frequencies, loads and modal uncertainty continuous signals that no hold touches.
//!
//! One whirl direction is one complex loop; its blocks are a complex scalar per uncertain mode and one full block of
//! performance. The D-scaled bound min σ̄(D N D⁻¹) over log D is convex; the ellipsoid method finds it with a gap
//! that it proves itself. With at most two scalars (three blocks in all) the bound is μ itself (Packard and Doyle,
//! Automatica 29, 1993).

use super::controller::Law;
use super::figures::Loop;
use super::files::WeightsFile;
use super::rotor::{BEARINGS, Command, PLACES, Rotor};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Channels of the performance block: loads and sensor noise in, displacements and currents out.
const PERFORMANCE: usize = PLACES + BEARINGS;
/// Defaults that the README documents: crossovers of loads and displacements (tool, front, rear), Hz.
const LOAD_CROSSOVER_HZ: f64 = 40.0;
const DISPLACEMENT_CROSSOVER_HZ: [f64; PLACES] = [40.0, 100.0, 100.0];
/// Control current per unit disturbance, A, with a second-order roll-off from a corner over a ratio of frequencies.
const CURRENT_LIMIT_A: f64 = 2.5;
const ROLLOFF_HZ: f64 = 3000.0;
const ROLLOFF_RATIO: f64 = 10.0;
const SENSOR_NOISE_M: f64 = 2e-7;
/// Relative gap at which the bound counts as found.
const GAP: f64 = 1e-5;

/// Largest bound over frequency.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    pub mu: f64,
    /// Signed: backward whirl is negative.
    pub hz: f64,
}

/// A specification with the modes it calls uncertain.
pub struct Specification {
    pub weights: WeightsFile,
    /// Relative uncertainty of flexible modes 1, 2, …
    pub uncertainty: Vec<f64>,
}

impl Specification {
    /// As the weights file writes it, for the modes that the spindle keeps.
    pub fn as_written(weights: WeightsFile, flexible_modes: usize) -> Self {
        let uncertainty = weights.mode_uncertainty.iter().copied().take(flexible_modes).collect();
        Self { weights, uncertainty }
    }

    /// The weighted loop from (modal channels, loads, noise) to (modal channels, displacements, currents) at a signed
    /// frequency.
    pub fn weighted(&self, rotor: &Rotor, law: &Law, hz: f64, rpm: f64) -> Mat<c64> {
        let modal = self.uncertainty.len();
        let (errors, size) = (modal + PLACES, modal + PERFORMANCE);
        let command = if law.sample_time_s > 0.0 { Command::Held } else { Command::Continuous };
        let p = rotor.response(hz, rpm, modal, command);
        let k = law.at(hz);
        let part = |r: usize, c: usize, h: usize, w: usize| p.submatrix(r, c, h, w).to_owned();
        let difference = Mat::<c64>::identity(BEARINGS, BEARINGS) - part(errors, errors, BEARINGS, BEARINGS) * &k;
        let inverse = difference.partial_piv_lu().solve(Mat::<c64>::identity(BEARINGS, BEARINGS));
        // u = R (y of the loads + noise)
        let r = &k * inverse;
        let through = part(0, errors, errors, BEARINGS) * &r;
        let loaded = part(0, 0, errors, errors) + &through * part(errors, 0, BEARINGS, errors);
        let currents = &r * part(errors, 0, BEARINGS, errors);
        let (into, out) = self.gains(rotor, hz.abs());
        Mat::from_fn(size, size, |i, j| {
            let entry = match (i < errors, j < errors) {
                (true, true) => loaded[(i, j)],
                (true, false) => through[(i, j - errors)],
                (false, true) => currents[(i - errors, j)],
                (false, false) => r[(i - errors, j - errors)],
            };
            entry * (into[j] * out[i])
        })
    }

    /// Magnitudes of the weights at inputs and outputs; their phases change no bound.
    fn gains(&self, rotor: &Rotor, hz: f64) -> (Vec<f64>, Vec<f64>) {
        let w = &self.weights;
        let limits = [w.tool, w.front, w.rear];
        let modal = self.uncertainty.iter().enumerate();
        let modal: Vec<f64> = modal.map(|(k, r)| (2.0 * r).sqrt() * rotor.omega_rad_s[2 + k]).collect();
        let loads = limits.map(|l| level(hz, l.max_dc_load_n, l.max_hf_load_n, LOAD_CROSSOVER_HZ));
        let displacements = [0, 1, 2].map(|k| {
            let (dc, hf) = (limits[k].max_dc_displacement_m, limits[k].max_hf_displacement_m);
            level(hz, 1.0 / dc, 1.0 / hf, DISPLACEMENT_CROSSOVER_HZ[k])
        });
        let stage = level(hz, 1.0, ROLLOFF_RATIO, ROLLOFF_HZ * ROLLOFF_RATIO.sqrt());
        let current = stage * stage / CURRENT_LIMIT_A;
        (
            [&modal[..], &loads, &[SENSOR_NOISE_M; BEARINGS]].concat(),
            [&modal[..], &displacements, &[current; BEARINGS]].concat(),
        )
    }

    /// Largest bound from 1 Hz to just below the Nyquist frequency, both whirl directions.
    pub fn peak(&self, closed: &Loop) -> Peak {
        let (rotor, law, rpm) = (closed.rotor, closed.law, closed.rpm);
        let nyquist = 0.5 / rotor.period_s;
        let band = (1.0, 0.9985 * nyquist);
        let mut grid = closed.grid_hz(band);
        for (omega, damper) in rotor.omega_rad_s.iter().zip(&rotor.damper_per_s).skip(2) {
            let offsets = (-6..=6).map(|k| (f64::from(k) / 3.0).sinh() * 0.5 * damper);
            grid.extend(offsets.map(|x| (omega + x) / TAU));
        }
        grid.retain(|f| (band.0..=band.1).contains(f));
        if rpm != 0.0 {
            grid.extend(grid.clone().iter().map(|f| -f));
        }
        grid.sort_by(f64::total_cmp);
        grid.dedup();
        let modal = self.uncertainty.len();
        // A bound below the peak found so far need not be brought to its optimum.
        let search = |grid: &[f64], least: f64| -> Option<Peak> {
            let bound =
                |hz: &f64| Peak { mu: scaled_bound(&self.weighted(rotor, law, *hz, rpm), modal, Some(least)), hz: *hz };
            grid.par_iter().map(bound).reduce_with(higher)
        };
        let coarse: Vec<f64> = grid.iter().copied().step_by(8).collect();
        let mut peak = search(&coarse, 0.0).expect("a grid has lines");
        peak = higher(peak, search(&grid, peak.mu).expect("a grid has lines"));
        for _ in 0..3 {
            let below = grid.iter().copied().filter(|f| *f < peak.hz).fold(f64::NEG_INFINITY, f64::max);
            let above = grid.iter().copied().filter(|f| *f > peak.hz).fold(f64::INFINITY, f64::min);
            let (below, above) = (below.max(-band.1), above.min(band.1));
            let between: Vec<f64> = (1..10).map(|k| below + (above - below) * f64::from(k) / 10.0).collect();
            peak = higher(peak, search(&between, peak.mu).expect("a grid has lines"));
            grid.extend(between);
        }
        peak
    }
}

fn higher(a: Peak, b: Peak) -> Peak {
    if b.mu > a.mu { b } else { a }
}

/// |(h s + d p)/(s + p)| at s = j2πf: DC value d, high-frequency value h, geometric mean at the crossover.
fn level(hz: f64, dc: f64, hf: f64, crossover_hz: f64) -> f64 {
    let pole = crossover_hz * (hf / dc).sqrt();
    (hf * hz).hypot(dc * pole) / hz.hypot(pole)
}

/// min σ̄(D M D⁻¹) over diagonal D with one scale for each of the first `scalars` channels and one for all others,
/// within [`GAP`]; stops as soon as a bound below `enough` is found, since the minimum is below it as well.
///
/// With x = ln d, ln σ̄ is convex and has the subgradient |uᵢ|² − |vᵢ|². An ellipsoid holds the minimiser; each step
/// keeps the half of it below the subgradient's plane in the smallest ellipsoid round that half.
pub fn scaled_bound(m: &Mat<c64>, scalars: usize, enough: Option<f64>) -> f64 {
    let enough = enough.unwrap_or(0.0).max(f64::MIN_POSITIVE);
    // One coordinate more than needed where there is one: the formula needs two.
    let n = scalars.max(2);
    let mut x = balanced_start(m, scalars);
    x.resize(n, 0.0);
    // e⁸ to either side of the balanced scales.
    let mut shape = Mat::<f64>::from_fn(n, n, |i, j| if i == j { 64.0 * n as f64 } else { 0.0 });
    let mut best = f64::INFINITY;
    for _ in 0..4000 {
        let (value, slope) = scaled_value(m, &x, scalars);
        best = best.min(value);
        let g = Mat::<f64>::from_fn(n, 1, |i, _| slope.get(i).copied().unwrap_or(0.0));
        let turned = &shape * &g;
        let reach = (g.transpose() * &turned)[(0, 0)].max(0.0).sqrt();
        // Nothing in the ellipsoid is below value·e^(−reach).
        if best < enough || scalars == 0 || value * (-reach).exp() >= best * (1.0 - GAP) {
            break;
        }
        let size = n as f64;
        for i in 0..n {
            x[i] -= turned[(i, 0)] / (reach * (size + 1.0));
        }
        let stretch = size * size / (size * size - 1.0);
        shape = Mat::from_fn(n, n, |i, j| {
            let cut = turned[(i, 0)] * turned[(j, 0)] / (reach * reach);
            stretch * (shape[(i, j)] - 2.0 / (size + 1.0) * cut)
        });
    }
    best
}

/// σ̄(D M D⁻¹) and the subgradient of its logarithm.
fn scaled_value(m: &Mat<c64>, x: &[f64], scalars: usize) -> (f64, Vec<f64>) {
    let d = |i: usize| if i < scalars { x[i] } else { 0.0 };
    let scaled = Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * (d(i) - d(j)).exp());
    let svd = scaled.svd().expect("singular values of a small matrix");
    let (u, v) = (svd.U(), svd.V());
    let slope = (0..scalars).map(|i| u[(i, 0)].norm_sqr() - v[(i, 0)].norm_sqr()).collect();
    (svd.S()[0].re, slope)
}

/// Scales that make the norms of row and column of each scalar channel equal (Osborne), relative to the full block.
fn balanced_start(m: &Mat<c64>, scalars: usize) -> Vec<f64> {
    let mut x = vec![0.0f64; scalars];
    let size = m.nrows();
    for _ in 0..40 {
        for i in 0..scalars {
            let d = |k: usize| if k < scalars { x[k] } else { 0.0 };
            let others = || (0..size).filter(|k| *k != i);
            let row: f64 = others().map(|k| (m[(i, k)].norm() * (d(i) - d(k)).exp()).powi(2)).sum();
            let column: f64 = others().map(|k| (m[(k, i)].norm() * (d(k) - d(i)).exp()).powi(2)).sum();
            if row > 0.0 && column > 0.0 {
                x[i] += 0.25 * (column / row).ln();
            }
        }
    }
    x
}
