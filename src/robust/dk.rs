//! D-K iteration: alternately the H∞ controller for scales D(s) and the scales for that controller.
//!
//! 1. K: H∞ synthesis for D P D⁻¹, γ.   2. μ: largest pointwise bound of the closed loop over all frequencies.
//! 3. D: magnitudes of the pointwise optimum fitted with the lowest order that keeps the peak, then the parameters of D(s)
//!    moved until the peak of its own bound is lowest (`dk_flatten`); a step beyond that optimum is tried as well.
//!
//! The best iterate is returned, not the last. A step that fails leaves a record that says why. The peak of the answer is
//! certified over all frequencies (`mu_certificate`), and the loop is checked for stability by that computation.
//! Real and repeated parameters enter the synthesis as full complex blocks: the peak is an upper bound for them.

use super::dfit::{Effort, Magnitudes, fit_with_effort};
use super::dfit_factors::Factors;
use super::dk_flatten::{LoopGrid, flatten, peak};
use super::dk_scale::DScales;
use super::error::SynthesisError;
use super::hinf::{HinfSettings, synthesise};
use super::mu_system::{MuPoint, MuSystem};
use super::structure::{MuError, Structure};
use crate::augment::{Block, GeneralizedPlant};
use crate::linalg::NumericError;
use crate::lti::connect::lower_lft;
use crate::lti::{Continuous, StateSpace};
use thiserror::Error;

/// Why a D-K iteration has nothing to return.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DkError {
    /// The blocks do not fit the plant.
    #[error(
        "the blocks have {rows} inputs and {cols} outputs, the plant has {disturbances} disturbances and {errors} errors"
    )]
    Blocks {
        /// Σ rows of the blocks.
        rows: usize,
        /// Σ cols of the blocks.
        cols: usize,
        /// dim w.
        disturbances: usize,
        /// dim z.
        errors: usize,
    },
    /// The first synthesis failed: there is no controller to start from.
    #[error("the first synthesis of the D-K iteration failed: {0}")]
    Synthesis(#[from] SynthesisError),
    /// The μ of the first loop could not be computed.
    #[error("the loop of the D-K iteration could not be analysed: {0}")]
    Mu(#[from] MuError),
    /// A connection failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// What to iterate for.
#[derive(Clone, Debug)]
pub struct DkSettings {
    /// Syntheses at most.
    pub max_iterations: usize,
    /// Largest order of a scale; the controller has the order of the plant plus Σ orders·(rows + cols).
    pub max_d_order: usize,
    /// Stop as soon as the peak of μ is below this.
    pub target_mu: Option<f64>,
    /// Stop when this many steps in a row improve the best peak by less than `min_improvement`.
    pub patience: usize,
    /// Relative improvement that counts.
    pub min_improvement: f64,
    /// Slack of the certificate of the answer.
    pub certificate_slack: f64,
}

impl Default for DkSettings {
    fn default() -> Self {
        Self {
            max_iterations: 25,
            max_d_order: 4,
            target_mu: None,
            patience: 4,
            min_improvement: 3e-4,
            // A fifth of the 1e-3 that a claimed μ may be off by.
            certificate_slack: 2e-4,
        }
    }
}

/// Record of one step.
#[derive(Clone, Debug)]
pub struct DkStep {
    /// Number of the step, from 0.
    pub iteration: usize,
    /// γ of the synthesis; NaN when it failed.
    pub gamma: f64,
    /// Largest pointwise μ bound of the loop; NaN when the step failed.
    pub mu_peak: f64,
    /// Its frequency, rad/s.
    pub peak_omega_rad_s: f64,
    /// Order of the controller; 0 when the step failed.
    pub controller_order: usize,
    /// Orders of the scales that the synthesis used, without the performance block.
    pub d_orders: Vec<usize>,
    /// What went wrong in this step; the earlier best is kept.
    pub failure: Option<String>,
}

/// The best controller met, with its certificate.
#[derive(Clone, Debug)]
pub struct DkOutcome {
    /// u = K y.
    pub controller: StateSpace<Continuous>,
    /// No frequency has a larger μ bound (certified).
    pub mu_peak: f64,
    /// Lower bound of μ at the peak.
    pub mu_lower_peak: f64,
    /// Frequency of the peak, rad/s.
    pub peak_omega_rad_s: f64,
    /// γ of the synthesis that gave the controller.
    pub gamma: f64,
    /// Scales of that synthesis.
    pub scales: DScales,
    /// Number of that step.
    pub best_iteration: usize,
    /// Records of all steps.
    pub steps: Vec<DkStep>,
}

/// Runs the iteration; `progress` sees every step.
///
/// # Errors
/// [`DkError`] when the blocks do not fit, the first synthesis fails, or the best loop cannot be analysed.
pub fn iterate(
    plant: &GeneralizedPlant,
    settings: &DkSettings,
    progress: &mut dyn FnMut(&DkStep),
) -> Result<DkOutcome, DkError> {
    let blocks = full_blocks(plant)?;
    let mut run = Run {
        plant,
        structure: Structure::new(&blocks)?,
        blocks,
        settings,
        hint: None,
    };
    let mut scales = DScales::identity(run.blocks.len());
    let mut steps: Vec<DkStep> = vec![];
    let mut best: Option<Iterate> = None;
    let mut idle = 0;
    for iteration in 0..settings.max_iterations.max(1) {
        let attempt = run.attempt(&scales);
        let step = record(iteration, &scales, &attempt);
        progress(&step);
        steps.push(step);
        let current = match attempt {
            Ok(current) => current,
            Err(error) => {
                let Some(kept) = &best else { return Err(error) };
                // Once more from the best, with half the change of scale.
                idle += 2;
                if idle >= settings.patience {
                    break;
                }
                let Some(half) = blend(&kept.scales, &scales, 0.5) else {
                    break;
                };
                scales = half;
                continue;
            }
        };
        let before = best.as_ref().map_or(f64::INFINITY, |b| b.mu_peak);
        idle = if current.mu_peak < before * (1.0 - settings.min_improvement) {
            0
        } else {
            idle + 1
        };
        let next = run.next_scales(&current, best.as_ref());
        if current.mu_peak < before {
            best = Some(Iterate {
                iteration,
                ..current
            });
        }
        let reached = settings
            .target_mu
            .is_some_and(|t| best.as_ref().is_some_and(|b| b.mu_peak < t));
        if reached || idle >= settings.patience {
            break;
        }
        scales = next;
    }
    let Some(best) = best else {
        return Err(DkError::Mu(MuError::EmptyBlock { block: 0 }));
    };
    let closed = lower_lft(&plant.system, &best.controller)?;
    let certified = MuSystem::new(&closed, &run.blocks)?.peak(settings.certificate_slack)?;
    Ok(DkOutcome {
        controller: best.controller,
        mu_peak: certified.upper,
        mu_lower_peak: certified.bounds.lower,
        peak_omega_rad_s: certified.omega_rad_s,
        gamma: best.gamma,
        scales: best.scales,
        best_iteration: best.iteration,
        steps,
    })
}

/// The blocks as full complex ones: a plant without blocks has one.
fn full_blocks(plant: &GeneralizedPlant) -> Result<Vec<Block>, DkError> {
    let (disturbances, errors) = (plant.disturbances(), plant.errors());
    if plant.blocks.is_empty() {
        return Ok(vec![Block::ComplexFull {
            rows: disturbances,
            cols: errors,
        }]);
    }
    let rows = plant.blocks.iter().map(Block::rows).sum();
    let cols = plant.blocks.iter().map(Block::cols).sum();
    if (rows, cols) != (disturbances, errors) {
        return Err(DkError::Blocks {
            rows,
            cols,
            disturbances,
            errors,
        });
    }
    let full = plant.blocks.iter().map(|b| Block::ComplexFull {
        rows: b.rows(),
        cols: b.cols(),
    });
    Ok(full.collect())
}

struct Iterate {
    iteration: usize,
    controller: StateSpace<Continuous>,
    gamma: f64,
    mu_peak: f64,
    peak_omega_rad_s: f64,
    scales: DScales,
    analysis: MuSystem,
    points: Vec<MuPoint>,
}

struct Run<'a> {
    plant: &'a GeneralizedPlant,
    structure: Structure,
    blocks: Vec<Block>,
    settings: &'a DkSettings,
    hint: Option<f64>,
}

/// Points of the grid on which scales are fitted: enough for orders up to six.
const FIT_POINTS: usize = 90;

impl Run<'_> {
    /// K and μ for given scales.
    fn attempt(&mut self, scales: &DScales) -> Result<Iterate, DkError> {
        let scaled = scales.scaled_plant(self.plant, &self.structure)?;
        let settings = HinfSettings {
            // γ to a tenth of what a step must improve.
            rel_tol: 1e-5,
            slack: 3e-4,
            hint: self.hint,
            ..HinfSettings::default()
        };
        let found = synthesise(&scaled, &settings)?;
        self.hint = Some(found.gamma_opt);
        let closed = lower_lft(&self.plant.system, &found.controller)?;
        let analysis = MuSystem::new(&closed, &self.blocks)?;
        let (top, points) = analysis.search()?;
        Ok(Iterate {
            iteration: 0,
            controller: found.controller,
            gamma: found.gamma,
            mu_peak: top.upper,
            peak_omega_rad_s: top.omega_rad_s,
            scales: scales.clone(),
            analysis,
            points,
        })
    }

    /// Scales for the next synthesis.
    fn next_scales(&self, current: &Iterate, best: Option<&Iterate>) -> DScales {
        let grid = self.grid(current);
        let (own, own_peak) = flatten(&grid, &self.structure, current.scales.clone(), 12);
        let mut next = own;
        let fresh = current.scales.orders().iter().all(|o| *o < self.settings.max_d_order);
        let stalled = own_peak > 0.9995 * peak(&grid, &self.structure, &current.scales);
        if (fresh || stalled)
            && let Some(fitted) = self.fitted(current, &grid)
        {
            let (fitted, fitted_peak) = flatten(&grid, &self.structure, fitted, 12);
            if fitted_peak < own_peak {
                next = fitted;
            }
        }
        // Alternation zigzags: go on in the direction of the last change when it paid.
        match best {
            Some(best) if current.mu_peak < best.mu_peak => {
                blend(&current.scales, &next, EXTRAPOLATION).unwrap_or(next)
            }
            _ => next,
        }
    }

    fn grid(&self, current: &Iterate) -> LoopGrid {
        let omega = self.fit_frequencies(current);
        let (lo, hi) = self.range();
        LoopGrid {
            response: omega.iter().map(|w| current.analysis.response(*w)).collect(),
            omega_rad_s: omega,
            corner_limits: (lo.ln() - 2.3, hi.ln() + 2.3),
            least_ln_damping: LEAST_LN_DAMPING,
        }
    }

    /// Decades round the poles of the plant.
    fn range(&self) -> (f64, f64) {
        let poles = self.plant.system.poles().unwrap_or_default();
        let sizes = poles.iter().map(|p| p.norm()).filter(|w| *w > 0.0);
        let (lo, hi) = sizes.fold((f64::INFINITY, 0.0f64), |(l, h), w| (l.min(w), h.max(w)));
        if hi == 0.0 {
            return (1e-3, 1e3);
        }
        // Integrators made slightly stable would stretch the range without need.
        (lo.max(1e-7 * hi) / 10.0, hi * 100.0)
    }

    /// Frequencies of the analysis within the range, thinned evenly; local maxima stay.
    fn fit_frequencies(&self, current: &Iterate) -> Vec<f64> {
        let (lo, hi) = self.range();
        let inside: Vec<&MuPoint> = current
            .points
            .iter()
            .filter(|p| p.omega_rad_s >= lo && p.omega_rad_s <= hi)
            .collect();
        let least = (hi / lo).ln() / FIT_POINTS as f64;
        let mut list: Vec<f64> = vec![];
        for (k, p) in inside.iter().enumerate() {
            let here = p.upper;
            let top = k > 0
                && k + 1 < inside.len()
                && here >= inside[k - 1].upper
                && here > inside[k + 1].upper;
            let far = list.last().is_none_or(|l| (p.omega_rad_s / l).ln() > least);
            if far || top {
                list.push(p.omega_rad_s);
            }
        }
        if current.peak_omega_rad_s > 0.0 && current.peak_omega_rad_s.is_finite() {
            list.push(current.peak_omega_rad_s);
        }
        list.sort_by(f64::total_cmp);
        list.dedup();
        list
    }

    /// Scales fitted to the pointwise optimum: the lowest order that keeps the peak.
    fn fitted(&self, current: &Iterate, grid: &LoopGrid) -> Option<DScales> {
        let highest = self.settings.max_d_order;
        let points = current.analysis.sweep(&grid.omega_rad_s).ok()?;
        let last = self.structure.spans.len() - 1;
        let reference = self.structure.spans[last].w.start;
        let mut fits: Vec<Vec<Factors>> = vec![];
        for span in &self.structure.spans[..last] {
            let magnitude = points.iter().map(|p| {
                let d = |k: usize| p.scaling.right[(k, k)].norm();
                // Irreducible parts of a loop may be scaled apart without limit; twelve decades are enough.
                (d(span.w.start) / d(reference)).clamp(1e-12, 1e12)
            });
            let weight = points.iter().map(|p| (p.upper / current.mu_peak).max(1e-3));
            let mut data = Magnitudes::new(
                grid.omega_rad_s.clone(),
                magnitude.collect(),
                weight.collect(),
            )
            .ok()?;
            data.least_ln_damping = LEAST_LN_DAMPING;
            let all = fit_with_effort(&data, highest, Effort::Quick).ok()?;
            fits.push(all.into_iter().map(|f| f.factors).collect());
        }
        let candidates: Vec<(DScales, f64)> = (0..=highest)
            .map(|order| {
                let mut factors: Vec<Factors> = fits.iter().map(|f| f[order].clone()).collect();
                factors.push(Factors::constant(0.0));
                let scales = DScales { factors };
                let peak = peak(grid, &self.structure, &scales);
                (scales, peak)
            })
            .collect();
        let lowest = candidates.iter().map(|c| c.1).fold(f64::INFINITY, f64::min);
        // Half a percent of peak is not worth two states a channel.
        candidates
            .into_iter()
            .find(|c| c.1 <= 1.005 * lowest)
            .map(|c| c.0)
    }
}

/// Length of the step of the scales relative to the optimum of the D step.
const EXTRAPOLATION: f64 = 1.8;
/// Sharper corners of D than ζ = 0.05 follow the grid, not the loop.
const LEAST_LN_DAMPING: f64 = -3.0;

/// (1 − t)·a + t·b in the parameters; `None` when the factors are of different kinds.
fn blend(a: &DScales, b: &DScales, t: f64) -> Option<DScales> {
    let mut mixed = b.clone();
    for ((target, x), y) in mixed.factors.iter_mut().zip(&a.factors).zip(&b.factors) {
        let (px, py) = (x.parameters(), y.parameters());
        if x.orders_match(y) {
            let values: Vec<f64> = px.iter().zip(&py).map(|(x, y)| x + t * (y - x)).collect();
            *target = y.with_parameters(
                &values,
                (f64::NEG_INFINITY, f64::INFINITY),
                LEAST_LN_DAMPING,
            );
        } else {
            return None;
        }
    }
    Some(mixed)
}

fn record(iteration: usize, scales: &DScales, attempt: &Result<Iterate, DkError>) -> DkStep {
    let blank = DkStep {
        iteration,
        gamma: f64::NAN,
        mu_peak: f64::NAN,
        peak_omega_rad_s: f64::NAN,
        controller_order: 0,
        d_orders: scales.orders(),
        failure: None,
    };
    match attempt {
        Ok(i) => DkStep {
            gamma: i.gamma,
            mu_peak: i.mu_peak,
            peak_omega_rad_s: i.peak_omega_rad_s,
            controller_order: i.controller.order(),
            ..blank
        },
        Err(error) => DkStep {
            failure: Some(error.to_string()),
            ..blank
        },
    }
}
