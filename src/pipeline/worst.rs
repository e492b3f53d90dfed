//! Worst cases of a controller over the natural frequencies of the rotor within the specification's uncertainty: at
//! each speed asked for, and at speeds spread from rest to the top speed, gyroscopic moments exact. There is no worst
//! case where a loop of the set is unstable.

use super::PipelineError;
use super::comparison::{LOW_HZ, LoopAtSpeed, below_nyquist, closed_loop, discrete, lines_beside_band};
use crate::controller::Controller;
use crate::controller::verification::growth_rate_of;
use crate::lti::FrequencyGrid;
use crate::predict::worst_case::{ModeUncertainty, WorstCase, WorstCurve, worst_case};
use crate::spindle::Machine;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A worst case with what it is over.
#[derive(Clone, Debug)]
pub struct WorstPrediction {
    /// Speed of the plant, rpm.
    pub speed_rpm: f64,
    /// True for a speed that was asked for, false for one of the spread.
    pub asked: bool,
    /// Half width per mode.
    pub uncertainty: ModeUncertainty,
    /// Curves with both bounds; empty when a loop of the set is unstable.
    pub worst: WorstCase,
    /// Bounds at 10 Hz and at the frequency of the top speed are read from these lines, Hz.
    pub top_speed_hz: f64,
    /// Largest growth rate of the loop over centre and corners of the box, 1/s.
    pub corner_growth_rate_per_s: f64,
}

impl WorstPrediction {
    /// True when centre and corners of the box are stable.
    pub fn is_stable(&self) -> bool {
        self.corner_growth_rate_per_s < 0.0
    }

    /// Tool stiffness that no rotor within the uncertainty falls below at this speed, over both axes, N/m, and where,
    /// Hz.
    pub(crate) fn least_stiffness(&self) -> Option<(f64, f64)> {
        let peaks = self.worst.compliance.iter().filter_map(|c| c.peak());
        let least = peaks.map(|(hz, e)| (1.0 / e.upper, hz));
        least.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|_| self.is_stable())
    }
}

/// Speeds spread from rest to the top speed, or to where stability is proven: rest, quarters, the end.
pub(crate) const SPREAD: usize = 5;

/// Points of the plain grid.
const GRID_POINTS: usize = 240;
/// Points on each side of a closed-loop pole.
const POINTS_A_SIDE: usize = 3;
/// Points across the range of an uncertain mode: a fifth of a percent of its frequency apart at most.
const ACROSS_MODE: usize = 48;
/// Rounds of bracketing round the highest line of a curve, and points of each.
const ROUNDS: usize = 3;
const POINTS_A_ROUND: usize = 6;

/// The specification's uncertainty of the modes that the spindle's model keeps; modes without one are certain.
pub fn uncertainty(machine: &Machine, mode_uncertainty: &[f64]) -> ModeUncertainty {
    let modes = machine.spindle.flexible_modes;
    let table = |k: usize| mode_uncertainty.get(k).copied().unwrap_or(0.0);
    ModeUncertainty { relative: (0..modes).map(table).collect() }
}

/// Worst case of a controller on the full plant at a speed.
pub(crate) fn worst_prediction(
    machine: &Machine,
    controller: &Controller,
    speed_rpm: f64,
    asked: bool,
    uncertainty: &ModeUncertainty,
) -> Result<WorstPrediction, PipelineError> {
    let band_hz = machine.spindle.stiffness_band_hz;
    let LoopAtSpeed { plant, poles, .. } = closed_loop(machine, controller, speed_rpm, band_hz)?;
    let law = discrete(controller, machine.spindle.electronics.sample_period_s())?;
    let rates: Result<Vec<f64>, PipelineError> = uncertainty
        .corners()
        .par_iter()
        .map(|factors| {
            let shifted = plant.with_scaled_modes(factors);
            growth_rate_of(&shifted, &shifted.sample_plant()?, &law)
                .map_err(PipelineError::numeric("loop with shifted modes"))
        })
        .collect();
    let corner_growth_rate_per_s = rates?.into_iter().fold(poles.growth_rate_per_s, f64::max);
    let stable = corner_growth_rate_per_s < 0.0;
    let top_speed_hz = machine.spindle.max_rpm / 60.0;
    let across =
        plant.flexible_rad_s().iter().zip(&uncertainty.relative).filter(|(_, r)| **r > 0.0).flat_map(|(omega, r)| {
            // Five percent beyond the range: the closed loop moves its resonances by about its damping.
            let half = 1.5 * r + 0.05;
            let part = move |k: usize| half * (2.0 * k as f64 / ACROSS_MODE as f64 - 1.0);
            (0..=ACROSS_MODE).map(move |k| omega * (1.0 + part(k)) / TAU)
        });
    let last = below_nyquist(machine, band_hz.1);
    let plain =
        FrequencyGrid::log_hz(band_hz.0, last, GRID_POINTS).refine_round_poles(&poles.poles_rad_s, POINTS_A_SIDE);
    let beside = lines_beside_band(machine, &poles.poles_rad_s).into_iter().map(|w| w / TAU);
    let grid = FrequencyGrid::from_hz(
        (plain.hz().into_iter().chain(across).chain([LOW_HZ, top_speed_hz]).filter(|f| *f <= last))
            .chain(beside)
            .filter(|_| stable),
    );
    let responder = controller.responder();
    let counts = |hz: f64| (band_hz.0..=last).contains(&hz) || hz == LOW_HZ || hz == top_speed_hz;
    let on = |grid: &FrequencyGrid| {
        let mut found = worst_case(&plant, &*responder, uncertainty, grid);
        found.compliance.iter_mut().for_each(|curve| curve.retain_lines(counts));
        found
    };
    let mut worst = on(&grid);
    for _ in 0..if stable { ROUNDS } else { 0 } {
        let more = on(&FrequencyGrid::from_hz(brackets(&worst)));
        merge(&mut worst, more);
    }
    Ok(WorstPrediction {
        speed_rpm,
        asked,
        uncertainty: uncertainty.clone(),
        worst,
        top_speed_hz,
        corner_growth_rate_per_s,
    })
}

/// All worst cases of a controller, by speed: at each speed asked for, and at [`SPREAD`] speeds from rest to `to_rpm`.
pub(crate) fn worst_predictions(
    machine: &Machine,
    controller: &Controller,
    asked_rpm: &[f64],
    to_rpm: f64,
    mode_uncertainty: &[f64],
) -> Result<Vec<WorstPrediction>, PipelineError> {
    let uncertainty = uncertainty(machine, mode_uncertainty);
    let spread = (0..SPREAD).map(|k| to_rpm * k as f64 / (SPREAD - 1) as f64);
    let mut speeds: Vec<(f64, bool)> =
        asked_rpm.iter().map(|rpm| (*rpm, true)).chain(spread.map(|rpm| (rpm, false))).collect();
    // A speed that is both stays as one that was asked for.
    speeds.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    speeds.dedup_by(|a, b| a.0 == b.0);
    speeds.into_iter().map(|speed| worst_prediction(machine, controller, speed.0, speed.1, &uncertainty)).collect()
}

/// Frequencies between the neighbours of the highest line of every curve, Hz.
fn brackets(worst: &WorstCase) -> Vec<f64> {
    curves(worst)
        .flat_map(|curve| {
            let lines = &curve.lines;
            let top = (0..lines.len()).reduce(|a, b| if lines[b].upper > lines[a].upper { b } else { a }).unwrap_or(0);
            let at = |k: usize| curve.frequency_hz.get(k).copied();
            let (lo, hi) = (at(top.saturating_sub(1)), at(top + 1).or(at(top)));
            let (lo, hi) = (lo.unwrap_or(1.0), hi.unwrap_or(1.0));
            (1..=POINTS_A_ROUND).map(move |k| lo + (hi - lo) * k as f64 / (POINTS_A_ROUND + 1) as f64)
        })
        .collect()
}

fn curves(worst: &WorstCase) -> impl Iterator<Item = &WorstCurve> {
    worst.compliance.iter().chain(&worst.sensitivity)
}

fn merge(worst: &mut WorstCase, more: WorstCase) {
    let olds = worst.compliance.iter_mut().chain(&mut worst.sensitivity);
    let news = more.compliance.into_iter().chain(more.sensitivity);
    for (old, new) in olds.zip(news) {
        let mut all: Vec<_> = std::mem::take(&mut old.frequency_hz)
            .into_iter()
            .zip(std::mem::take(&mut old.lines))
            .chain(new.frequency_hz.into_iter().zip(new.lines))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.dedup_by(|a, b| a.0 == b.0);
        (old.frequency_hz, old.lines) = all.into_iter().unzip();
    }
}
