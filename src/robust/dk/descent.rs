//! Descent on γ itself: the optimal H∞ level of D P D⁻¹ as a function of the poles, zeros and gains of D(s).
//!
//! D-K alternation creeps along a valley and its fits lose part of each step. γ_opt(D) bounds μ of the next loop and is
//! the largest of a few levels, one for each eigenvalue of XY and each side ([`crate::robust::hinf::couplings`]), which
//! are smooth in the logarithms of the parameters. A prox-linear step on all of them follows the edge where two of them
//! meet, where a method that sees only the largest one stops. A step to scales whose synthesis fails is refused.

use super::scale::DScales;
use crate::augment::GeneralizedPlant;
use crate::linalg::Mat;
use crate::linalg::dense::dot;
use crate::robust::dfit::factors::FitRanges;
use crate::robust::dfit::metric::metric;
use crate::robust::hinf::{HinfSettings, optimal_level_with_slopes};
use crate::robust::minimax::curvature::Curvature;
use crate::robust::minimax::proximal::{HEAVIEST, after_refusal, after_step, is_accepted};
use crate::robust::minimax::step::{LinearValue, MinimaxStep, StepRule, curved_step};
use crate::robust::structure::Structure;
use rayon::prelude::*;

/// The problem and the ranges that the scales must keep.
pub(crate) struct ScaleDescent<'a> {
    /// Generalized plant without scales.
    pub plant: &'a GeneralizedPlant,
    /// Its blocks.
    pub structure: &'a Structure,
    /// Ranges of corner frequencies and damping ratios.
    pub limits: FitRanges,
}

/// Where a descent is, and the curvature and weight that its steps left.
pub(crate) struct Course {
    pub scales: DScales,
    /// Their ln γ_opt.
    pub ln_level: f64,
    levels: Vec<LinearValue>,
    /// What the levels were at steps refused since the last one accepted, as seen from where it ended.
    cuts: Vec<LinearValue>,
    curvature: Curvature,
    /// Proximal weight.
    weight: f64,
    /// ln γ_opt after each accepted step.
    history: Vec<f64>,
    /// Whether the curvature was forgotten without a gain since.
    fresh: bool,
    /// Another step gains nothing.
    pub ended: bool,
}

/// Step of the central differences of the matrices of the plant, which are smooth in the parameters: the error is that
/// of the third derivative, 1e-10.
const DIFFERENCE: f64 = 1e-5;
/// γ is found to this: a hundredth of what a step gains at the end.
const TOLERANCE: f64 = 1e-7;
/// A step that promises less ends a descent: it is not told from rounding.
const PROMISE: f64 = 2.0 * TOLERANCE;
/// A descent ends when so many accepted steps together lower ln γ by less than this.
const PATIENCE: (usize, f64) = (6, 5e-5);
/// Frequencies of the metric.
const POINTS: usize = 60;

impl ScaleDescent<'_> {
    /// ln γ_opt, near enough to tell scales apart; infinite when the synthesis fails.
    pub(crate) fn ln_level(&self, scales: &DScales, hint: Option<f64>) -> f64 {
        let settings = HinfSettings { rel_tol: 1e-5, hint, ..HinfSettings::default() };
        let scaled = scales.scaled_plant(self.plant, self.structure);
        let found = scaled.map(|plant| optimal_level_with_slopes(&plant, &settings));
        match found {
            Ok(Ok((ln_level, _))) if ln_level.is_finite() => ln_level,
            _ => f64::INFINITY,
        }
    }

    /// A descent from these scales; `None` when the synthesis fails there.
    pub(crate) fn begin(&self, scales: DScales) -> Option<Course> {
        let (ln_level, levels) = self.levels(&scales, &scales.parameters(), None)?;
        Some(Course {
            scales,
            ln_level,
            levels,
            cuts: vec![],
            curvature: Curvature::default(),
            weight: 1.0,
            history: vec![ln_level],
            fresh: true,
            ended: false,
        })
    }

    /// Goes down by `steps` at most, or until γ is below `enough`.
    pub(crate) fn run(&self, course: &mut Course, steps: usize, enough: f64) {
        for _ in 0..steps {
            if course.ended || course.ln_level.exp() < enough {
                return;
            }
            if self.step(course) {
                continue;
            }
            // Curvature learnt on the way can hold steps short: once more without it.
            course.ended = course.fresh;
            course.fresh = true;
            course.curvature = Curvature::default();
            course.weight = 1.0;
            course.history = vec![course.ln_level];
        }
    }

    /// Tries a step; false when no further one pays.
    fn step(&self, course: &mut Course) -> bool {
        let before = course.scales.parameters();
        if before.is_empty() {
            return false;
        }
        let metric = self.metric(&course.scales);
        let rule = StepRule { limits: 0, penalty: 0.0, proximal: course.weight };
        let seen: Vec<LinearValue> = [course.levels.as_slice(), &course.cuts].concat();
        let found = curved_step(&seen, &[], (&metric, &course.curvature), &rule);
        let trial = found.and_then(|step| {
            let pairs = before.iter().zip(&step.step);
            let x: Vec<f64> = pairs.map(|(x, s)| x + s).collect();
            let levels = self.levels(&course.scales, &x, Some(step.predicted.exp()))?;
            Some((step, x, levels))
        });
        let Some((step, x, (ln_level, levels))) = trial else {
            course.weight = after_refusal(course.weight, false);
            return course.weight < HEAVIEST;
        };
        let promised = course.ln_level - step.predicted - course.curvature.half_along(&step.step);
        let kept = course.ln_level - ln_level;
        let change = slope_change(&step, &seen, &levels);
        course.curvature.learn(&step.step, &change, || metric);
        if promised <= PROMISE {
            return false;
        }
        if !is_accepted(kept, promised) {
            course.weight = after_refusal(course.weight, kept > -promised);
            let top = course.ln_level;
            let cuts = levels.into_iter().map(|level| back(level, &step.step, top));
            course.cuts.extend(cuts);
            return course.weight < HEAVIEST;
        }
        course.weight = after_step(course.weight, kept, promised);
        course.cuts.clear();
        course.scales = course.scales.with_parameters(&x, &self.limits);
        (course.ln_level, course.levels) = (ln_level, levels);
        course.history.push(ln_level);
        let past = course.history.len().checked_sub(1 + PATIENCE.0);
        let gains = past.map(|k| course.history[k] - ln_level >= PATIENCE.1);
        if gains == Some(true) {
            course.fresh = false;
        }
        gains.unwrap_or(true)
    }

    /// ln γ_opt of scales of the same kinds with parameters `x`, and the levels that bind there with their derivatives.
    fn levels(&self, scales: &DScales, x: &[f64], hint: Option<f64>) -> Option<(f64, Vec<LinearValue>)> {
        let settings = HinfSettings { rel_tol: TOLERANCE, hint, ..HinfSettings::default() };
        let plant = |x: &[f64]| {
            let scales = scales.with_parameters(x, &self.limits);
            scales.scaled_plant(self.plant, self.structure).ok()
        };
        let (ln_level, binding) = optimal_level_with_slopes(&plant(x)?, &settings).ok()?;
        let along = |k: usize| {
            let moved = |by: f64| {
                let mut moved = x.to_vec();
                moved[k] += by;
                plant(&moved).map(|p| p.system)
            };
            let (up, down) = (moved(DIFFERENCE)?, moved(-DIFFERENCE)?);
            let change = |up: &Mat<f64>, down: &Mat<f64>| (up - down) * (0.5 / DIFFERENCE);
            let changes =
                [change(&up.a, &down.a), change(&up.b, &down.b), change(&up.c, &down.c), change(&up.d, &down.d)];
            Some(binding.iter().map(|b| b.slope.along(&changes)).collect())
        };
        let slopes: Option<Vec<Vec<f64>>> = (0..x.len()).into_par_iter().map(along).collect();
        let slopes = slopes?;
        let values = binding.iter().enumerate().map(|(i, b)| LinearValue {
            limit: None,
            value: b.ln_level,
            gradient: slopes.iter().map(|of| of[i]).collect(),
        });
        Some((ln_level, values.collect()))
    }

    /// Metric of the parameters over the range.
    fn metric(&self, scales: &DScales) -> Mat<f64> {
        let (lo, hi) = self.limits.ln_omega;
        let at = |k: usize| (lo + (hi - lo) * (k as f64 + 0.5) / POINTS as f64).exp();
        let omega_rad_s: Vec<f64> = (0..POINTS).map(at).collect();
        metric(scales.free(), &omega_rad_s)
    }
}

/// A level found after a step as a linear function from before it, which is at most `top` there: a level that bends
/// downwards would forbid the place where it was not found.
fn back(level: LinearValue, step: &[f64], top: f64) -> LinearValue {
    LinearValue { value: (level.value - dot(&level.gradient, step)).min(top), ..level }
}

/// Slope of the Lagrangian after a step less that before it. Levels have no names: each goes on as that of the nearest
/// slope.
fn slope_change(step: &MinimaxStep, before: &[LinearValue], after: &[LinearValue]) -> Vec<f64> {
    let mut change = vec![0.0; step.step.len()];
    for (k, weight) in &step.binding {
        let slope = &before[*k].gradient;
        let far = |v: &&LinearValue| -> f64 {
            let pairs = v.gradient.iter().zip(slope);
            pairs.map(|(a, b)| (a - b).powi(2)).sum()
        };
        let nearest = after.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        let Some(nearest) = nearest else { continue };
        for (c, (a, b)) in change.iter_mut().zip(nearest.gradient.iter().zip(slope)) {
            *c += weight * (a - b);
        }
    }
    change
}
