//! Constant scales of the uncertainty channels before anything else: the step that brings γ from hundreds to about one.
//!
//! With Δᵢ repeated or scalar, N may be scaled to diag(d) N diag(d)⁻¹ without changing μ. Minimises the optimal γ of
//! the scaled problem over ln dᵢ (the last block, performance, keeps 1) by a compass search: γ is quasi-convex in ln d
//! for a fixed loop. Whether a trial is better at all is one pair of Riccati equations.

use crate::augment::GeneralizedPlant;
use crate::linalg::Mat;
use crate::robust::error::SynthesisError;
use crate::robust::frequency_floor::FrequencyFloor;
use crate::robust::hinf::{HinfSettings, is_feasible, optimal_level};

/// Constant scales and the γ they reach.
#[derive(Clone, Debug)]
pub struct ConstantScales {
    /// dᵢ per block; the last is 1.
    pub scale: Vec<f64>,
    /// Optimal γ of the scaled problem.
    pub gamma: f64,
    /// Levels tested and searched.
    pub syntheses: usize,
}

/// Largest number of syntheses: each coordinate settles within a dozen.
const SYNTHESES: usize = 120;

/// First and largest step in ln d of a search from scales that say nothing of the problem, and from those of a
/// neighbouring problem.
const FAR: f64 = 2.0;
const NEAR: f64 = 0.5;

/// Where a search for constant scales starts.
#[derive(Clone, Copy, Debug)]
pub enum ScaleStart<'a> {
    /// Scales of the right order of magnitude at best.
    Guess(&'a [f64]),
    /// The best scales of a problem that differs in a weight.
    Neighbour(&'a [f64]),
}

/// Constant scales for `plant`, searched from `start` (one per block but the last; empty: from 1).
///
/// # Errors
/// [`SynthesisError`] of the first synthesis when the problem has no solution at all.
pub fn constant_scales(plant: &GeneralizedPlant, start: ScaleStart<'_>) -> Result<ConstantScales, SynthesisError> {
    scales_to(plant, start, 0.0)
}

/// As [`constant_scales`], ended as soon as the level `enough` is reached: γ is then that level or a lower one. Zero is
/// never reached.
pub(crate) fn scales_to(
    plant: &GeneralizedPlant,
    start: ScaleStart<'_>,
    enough: f64,
) -> Result<ConstantScales, SynthesisError> {
    let (start, first_step) = match start {
        ScaleStart::Guess(scales) => (scales, FAR),
        ScaleStart::Neighbour(scales) => (scales, NEAR),
    };
    let free = plant.blocks.len().saturating_sub(1);
    // γ to 0.1 % decides between neighbours a tenth apart.
    let settings = HinfSettings { rel_tol: 1e-3, ..HinfSettings::default() };
    let exp = |ln: &[f64]| ln.iter().map(|l| l.exp()).collect::<Vec<f64>>();
    let at = |ln: &[f64]| scale_signals(plant, &exp(ln));
    let floor = FrequencyFloor::new(plant)?;
    // A single frequency shows of most trials that they are worse.
    let reaches = |ln: &[f64], level: f64| {
        let [left, right] = channel_scales(plant, &exp(ln));
        !floor.is_above(level, &left, &right) && matches!(is_feasible(&at(ln), level), Ok(true))
    };
    let mut ln: Vec<f64> = (0..free).map(|k| start.get(k).map_or(0.0, |d| d.ln())).collect();
    let reached = enough > 0.0 && reaches(&ln, enough);
    let mut gamma = if reached { enough } else { optimal_level(&at(&ln), &settings)? };
    let mut syntheses = 1;
    let mut known = Tried { lattice: vec![ln.clone()] };
    let mut step: f64 = first_step;
    // A last step of a tenth in ln d changes γ by well under a percent at the flat bottom.
    while step > 0.1 && syntheses < SYNTHESES && gamma > enough {
        let mut moved = false;
        for k in 0..free {
            if gamma <= enough {
                break;
            }
            let beside = |direction: f64| {
                let mut trial = ln.clone();
                trial[k] += direction;
                trial
            };
            let trials = [step, -step].map(beside);
            let new = [0, 1].map(|side| known.is_new(&trials[side]));
            // Most trials are worse, and one level tells. One that fails is a point not to go to, no more.
            let level = gamma * (1.0 - 1e-3);
            let lower = |side: usize| new[side] && reaches(&trials[side], level);
            let (up, down) = rayon::join(|| lower(0), || lower(1));
            syntheses += new.iter().filter(|new| **new).count();
            for (trial, lower) in trials.into_iter().zip([up, down]) {
                if !lower {
                    known.lattice.push(trial);
                    continue;
                }
                let trial_plant = at(&trial);
                let near = HinfSettings { hint: Some(gamma), ..settings.clone() };
                let found = optimal_level(&trial_plant, &near);
                known.lattice.push(trial.clone());
                let Ok(value) = found else {
                    continue;
                };
                if value < gamma * (1.0 - 1e-3) {
                    (gamma, ln, moved) = (value, trial, true);
                    break;
                }
            }
        }
        // A neighbour whose scales are far off after all is reached by steps that grow again.
        step = match moved {
            true if step >= first_step => (2.0 * step).min(FAR),
            true => step,
            false => 0.5 * step,
        };
    }
    let mut scale: Vec<f64> = ln.iter().map(|l| l.exp()).collect();
    scale.push(1.0);
    Ok(ConstantScales { scale, gamma, syntheses })
}

/// Points of a compass search that were tried. γ only falls on the way, so one that was not below it once never is.
struct Tried {
    lattice: Vec<Vec<f64>>,
}

impl Tried {
    /// Whether a point is none of those tried before.
    fn is_new(&self, point: &[f64]) -> bool {
        // Steps are halved and doubled: a tenth of the smallest tells points of the lattice from rounding.
        let same = |p: &Vec<f64>| p.iter().zip(point).all(|(a, b)| (a - b).abs() < 1e-2);
        !self.lattice.iter().any(same)
    }
}

/// The plant with its uncertainty channels scaled: outputs of block i by dᵢ, inputs by 1/dᵢ. Blocks are kept.
pub fn scale_signals(plant: &GeneralizedPlant, scale: &[f64]) -> GeneralizedPlant {
    let [left, right] = channel_scales(plant, scale);
    let diagonal = |d: &[f64]| Mat::from_fn(d.len(), d.len(), |i, j| if i == j { d[i] } else { 0.0 });
    GeneralizedPlant {
        system: plant.system.scale_outputs(&diagonal(&left)).scale_inputs(&diagonal(&right)),
        ..plant.clone()
    }
}

/// Factors of the outputs and of the inputs of a plant for one scale per block.
fn channel_scales(plant: &GeneralizedPlant, scale: &[f64]) -> [Vec<f64>; 2] {
    let per_channel = |size: fn(&crate::augment::Block) -> usize, total: usize, power: i32| {
        let mut all: Vec<f64> = plant
            .blocks
            .iter()
            .enumerate()
            .flat_map(|(k, b)| {
                let own = scale.get(k).copied().unwrap_or(1.0);
                vec![own.powi(power); size(b)]
            })
            .collect();
        all.resize(total, 1.0);
        all
    };
    [
        per_channel(crate::augment::Block::cols, plant.system.outputs(), 1),
        per_channel(crate::augment::Block::rows, plant.system.inputs(), -1),
    ]
}
