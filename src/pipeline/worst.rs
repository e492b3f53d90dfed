//! Worst cases of a controller over the natural frequencies of the rotor: at each speed over the specification's uncertainty, and
//! at rest over that uncertainty widened by the gyroscopic split of the top speed, which stands for every speed at once.

use super::PipelineError;
use super::comparison::{BAND_HZ, LOW_HZ, closed_loop, discrete};
use crate::augment::split::gyroscopic_split;
use crate::controller::Controller;
use crate::controller::verification::growth_rate;
use crate::lti::FrequencyGrid;
use crate::predict::worst_case::{ModeUncertainty, WorstCase, WorstCurve, worst_case};
use crate::spindle::Machine;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// What an uncertainty stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cover {
    /// The rotor at one speed, gyroscopic moments exact.
    Speed,
    /// The rotor at rest, the uncertainty widened so that it holds the whirl frequencies of every speed.
    EverySpeed,
}

/// A worst case with what it is over.
#[derive(Clone, Debug)]
pub struct WorstPrediction {
    /// Speed of the plant, rpm.
    pub speed_rpm: f64,
    /// What the uncertainty covers.
    pub cover: Cover,
    /// Half width per mode.
    pub uncertainty: ModeUncertainty,
    /// Curves with both bounds.
    pub worst: WorstCase,
    /// Bounds at 10 Hz and at the frequency of the top speed are read from these lines, Hz.
    pub top_speed_hz: f64,
    /// Largest growth rate of the loop over centre and corners of the box, 1/s.
    pub corner_growth_rate_per_s: f64,
}

/// Points of the plain grid.
const GRID_POINTS: usize = 240;
/// Points on each side of a closed-loop pole.
const POINTS_A_SIDE: usize = 3;
/// Points across the range of an uncertain mode: a fifth of a percent of its frequency apart at most.
const ACROSS_MODE: usize = 48;
/// Rounds of bracketing round the highest line of a curve, and points of each.
const ROUNDS: usize = 3;
const POINTS_A_ROUND: usize = 6;

/// The specification's uncertainty of the modes that the spindle's model keeps, and the same with the gyroscopic split.
///
/// # Errors
/// [`PipelineError`] when the rotor breaks a rule.
pub fn uncertainties(
    machine: &Machine,
    mode_uncertainty: &[f64],
) -> Result<[ModeUncertainty; 2], PipelineError> {
    let top = machine.spindle.max_rpm * TAU / 60.0;
    let split = gyroscopic_split(machine, top, machine.spindle.flexible_modes)?;
    let table = |k: usize| mode_uncertainty.get(k).copied().unwrap_or(0.0);
    let relative = |widen: f64| ModeUncertainty {
        relative: split
            .iter()
            .enumerate()
            .map(|(k, s)| table(k) + widen * s.relative())
            .collect(),
    };
    Ok([relative(0.0), relative(1.0)])
}

/// Worst case of a controller on the full plant at a speed.
///
/// # Errors
/// [`PipelineError`] when the plant or the loop cannot be built.
pub fn worst_prediction(
    machine: &Machine,
    controller: &Controller,
    speed_rpm: f64,
    cover: Cover,
    uncertainty: &ModeUncertainty,
) -> Result<WorstPrediction, PipelineError> {
    let (plant, poles, _) = closed_loop(machine, controller, speed_rpm, BAND_HZ)?;
    let law = discrete(controller, machine.spindle.electronics.sample_period_s())?;
    let rates: Result<Vec<f64>, PipelineError> = uncertainty
        .corners()
        .par_iter()
        .map(|factors| {
            let sampled = plant.with_scaled_modes(factors).sampled()?;
            growth_rate(&sampled, &law).map_err(PipelineError::numeric("loop with shifted modes"))
        })
        .collect();
    let top_speed_hz = machine.spindle.max_rpm / 60.0;
    let across = plant
        .flexible_rad_s()
        .iter()
        .zip(&uncertainty.relative)
        .filter(|(_, r)| **r > 0.0)
        .flat_map(|(omega, r)| {
            // Five percent beyond the range: the closed loop moves its resonances by about its damping.
            let half = 1.5 * r + 0.05;
            let part = move |k: usize| half * (2.0 * k as f64 / ACROSS_MODE as f64 - 1.0);
            (0..=ACROSS_MODE).map(move |k| omega * (1.0 + part(k)) / TAU)
        });
    let plain = FrequencyGrid::log_hz(BAND_HZ.0, BAND_HZ.1, GRID_POINTS)
        .refine_round_poles(&poles, POINTS_A_SIDE);
    let grid = FrequencyGrid::from_hz(
        plain
            .hz()
            .into_iter()
            .chain(across)
            .chain([LOW_HZ, top_speed_hz])
            .filter(|f| *f <= BAND_HZ.1),
    );
    let mut worst = worst_case(&plant, controller, uncertainty, &grid);
    for _ in 0..ROUNDS {
        let extra = FrequencyGrid::from_hz(brackets(&worst));
        let more = worst_case(&plant, controller, uncertainty, &extra);
        merge(&mut worst, more);
    }
    Ok(WorstPrediction {
        speed_rpm,
        cover,
        uncertainty: uncertainty.clone(),
        worst,
        top_speed_hz,
        corner_growth_rate_per_s: rates?.into_iter().fold(f64::NEG_INFINITY, f64::max),
    })
}

/// All worst cases of a controller: at each speed, and over every speed.
///
/// # Errors
/// As [`worst_prediction`].
pub fn worst_predictions(
    machine: &Machine,
    controller: &Controller,
    speeds_rpm: &[f64],
    mode_uncertainty: &[f64],
) -> Result<Vec<WorstPrediction>, PipelineError> {
    let [at_speed, every_speed] = uncertainties(machine, mode_uncertainty)?;
    speeds_rpm
        .iter()
        .map(|rpm| (*rpm, Cover::Speed, &at_speed))
        .chain([(0.0, Cover::EverySpeed, &every_speed)])
        .map(|(rpm, cover, uncertainty)| {
            worst_prediction(machine, controller, rpm, cover, uncertainty)
        })
        .collect()
}

/// Frequencies between the neighbours of the highest line of every curve, Hz.
fn brackets(worst: &WorstCase) -> Vec<f64> {
    curves(worst)
        .flat_map(|curve| {
            let lines = &curve.lines;
            let top = (0..lines.len())
                .reduce(|a, b| {
                    if lines[b].upper > lines[a].upper {
                        b
                    } else {
                        a
                    }
                })
                .unwrap_or(0);
            let at = |k: usize| curve.frequency_hz.get(k).copied();
            let (lo, hi) = (at(top.saturating_sub(1)), at(top + 1).or(at(top)));
            let (lo, hi) = (lo.unwrap_or(1.0), hi.unwrap_or(1.0));
            (1..=POINTS_A_ROUND)
                .map(move |k| lo + (hi - lo) * k as f64 / (POINTS_A_ROUND + 1) as f64)
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
