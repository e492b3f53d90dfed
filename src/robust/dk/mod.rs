//! D-K iteration: alternately the H∞ controller for scales D(s) and the scales for that controller.
//!
//! 1. K: H∞ synthesis for D P D⁻¹, γ.   2. μ: largest pointwise bound of the closed loop over all frequencies.
//! 3. D: magnitudes of the pointwise optimum fitted with the lowest order that keeps the peak, then the parameters of
//!    D(s) moved until the peak of its own bound is lowest; a step beyond that optimum is tried as well.
//!
//! The best iterate is returned, not the last. A step that fails leaves a record that says why. The peak of the answer
//! is certified over all frequencies (`mu::certificate`), and the loop is checked for stability by that computation.
//! Real and repeated parameters enter this iteration as full complex blocks; [`posed`] goes on from there with what
//! they are (`mixed`).

pub(crate) mod descent;
pub(crate) mod mixed;
pub mod posed;
pub(crate) mod record;
pub mod scale;

use crate::augment::{Block, GeneralizedPlant};
use crate::lti::connect::lower_lft;
use crate::lti::norm::hinf_norm;
use crate::lti::{Continuous, StateSpace};
use crate::robust::dfit::factors::{Factors, FitRanges};
use crate::robust::dfit::{Magnitudes, fit_quick};
use crate::robust::hinf::{HinfSettings, synthesise};
use crate::robust::mu::dscale;
use crate::robust::mu::system::{MuPoint, MuSystem};
use crate::robust::structure::{MuError, Structure};
use descent::{Course, ScaleDescent};
use rayon::prelude::*;
pub use record::{DkError, DkOutcome, DkSettings, DkStep};
use scale::{DScales, scale_errors};

/// Runs the iteration; `progress` sees every step.
///
/// # Errors
/// [`DkError`] when the blocks do not fit, the first synthesis fails, or the best loop cannot be analysed.
pub fn iterate(
    plant: &GeneralizedPlant,
    settings: &DkSettings,
    progress: &mut dyn FnMut(&DkStep),
) -> Result<DkOutcome, DkError> {
    let mut run = DkRun::new(plant, settings)?;
    let mut log = Log { steps: vec![], progress };
    let first = run.attempt(&DScales::identity(run.blocks.len()), None);
    let mut best = log.enter(&DScales::identity(run.blocks.len()), first)?;
    // Scales of higher order lower γ towards the peak of μ: where that is as high there is nothing to gain.
    if best.mu_peak < best.gamma * (1.0 - settings.least_gap) || settings.least_gap == 0.0 {
        run.alternate(&mut best, &mut log);
        run.descend(&mut best, &mut log);
    }
    let certified = run.certificate(&best)?;
    Ok(DkOutcome {
        controller: best.controller,
        mu_peak: certified.upper,
        mu_lower_peak: certified.lower,
        peak_omega_rad_s: certified.omega_rad_s,
        gamma: best.gamma,
        scales: best.scales,
        best_iteration: best.iteration,
        steps: log.steps,
    })
}

/// The blocks as full complex ones: a plant without blocks has one.
fn full_blocks(plant: &GeneralizedPlant) -> Result<Vec<Block>, DkError> {
    let (disturbances, errors) = (plant.disturbances(), plant.errors());
    if plant.blocks.is_empty() {
        return Ok(vec![Block::ComplexFull { rows: disturbances, cols: errors }]);
    }
    let rows = plant.blocks.iter().map(Block::rows).sum();
    let cols = plant.blocks.iter().map(Block::cols).sum();
    if (rows, cols) != (disturbances, errors) {
        return Err(DkError::Blocks { rows, cols, disturbances, errors });
    }
    let full = plant.blocks.iter().map(|b| Block::ComplexFull { rows: b.rows(), cols: b.cols() });
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

/// Records of the steps, shown as they are made.
struct Log<'a> {
    steps: Vec<DkStep>,
    progress: &'a mut dyn FnMut(&DkStep),
}

impl Log<'_> {
    /// Records an attempt and numbers it.
    fn enter(&mut self, scales: &DScales, attempt: Result<Iterate, DkError>) -> Result<Iterate, DkError> {
        let iteration = self.steps.len();
        let step = record(iteration, scales, &attempt);
        (self.progress)(&step);
        self.steps.push(step);
        attempt.map(|a| Iterate { iteration, ..a })
    }

    /// States the D,G bound in the last record, in place of that of full complex blocks.
    fn correct_last(&mut self, top: &MuPoint) {
        if let Some(step) = self.steps.last_mut() {
            step.mu_peak = top.upper;
            step.peak_omega_rad_s = top.omega_rad_s;
        }
    }
}

struct DkRun<'a> {
    plant: &'a GeneralizedPlant,
    structure: Structure,
    blocks: Vec<Block>,
    settings: &'a DkSettings,
    hint: Option<f64>,
    /// Fitted scales of full order with the lowest γ so far, and that γ.
    full_order: Option<(DScales, f64)>,
}

/// Certified peak of μ of a loop.
struct Certified {
    upper: f64,
    lower: f64,
    omega_rad_s: f64,
}

/// Points of the grid on which scales are fitted: enough for orders up to six.
const FIT_POINTS: usize = 90;

impl<'a> DkRun<'a> {
    fn new(plant: &'a GeneralizedPlant, settings: &'a DkSettings) -> Result<Self, DkError> {
        let blocks = full_blocks(plant)?;
        Ok(Self { plant, structure: Structure::new(&blocks)?, blocks, settings, hint: None, full_order: None })
    }

    /// K and μ for given scales, and for Γ(s) on every error where there is one.
    fn attempt(&mut self, scales: &DScales, share: Option<&Factors>) -> Result<Iterate, DkError> {
        let mut scaled = scales.scaled_plant(self.plant, &self.structure)?;
        if let Some(share) = share {
            scaled = scale_errors(&scaled, share)?;
        }
        let settings = HinfSettings {
            // γ to a tenth of what a step must improve.
            rel_tol: 1e-5,
            slack: 5e-5,
            hint: self.hint,
            ..HinfSettings::default()
        };
        let found = synthesise(&scaled, &settings)?;
        self.hint = Some(found.gamma_opt);
        self.analyse(found.controller, found.gamma, scales.clone())
    }

    /// The loop of a controller with its bounds over frequency.
    fn analyse(&self, controller: StateSpace<Continuous>, gamma: f64, scales: DScales) -> Result<Iterate, DkError> {
        let closed = lower_lft(&self.plant.system, &controller)?;
        let analysis = MuSystem::new(&closed, &self.blocks)?;
        let (top, points) = analysis.search()?;
        Ok(Iterate {
            iteration: 0,
            controller,
            gamma,
            mu_peak: top.upper,
            peak_omega_rad_s: top.omega_rad_s,
            scales,
            analysis,
            points,
        })
    }

    /// The peak of the best loop, certified by the norm of D N D⁻¹ for its own D(s) when that is close to what the
    /// search has attained, else by frozen scalings.
    fn certificate(&self, best: &Iterate) -> Result<Certified, DkError> {
        let attained = best.mu_peak;
        let scaled = best.scales.scaled_plant(self.plant, &self.structure)?;
        let closed = lower_lft(&scaled.system, &best.controller)?;
        let norm = hinf_norm(&closed, 1e-6).map_or(f64::INFINITY, |n| n.upper);
        if norm <= attained * (1.0 + self.settings.certificate_slack) {
            let bounds = best.analysis.bounds(best.peak_omega_rad_s)?;
            return Ok(Certified {
                upper: norm.max(attained),
                lower: bounds.lower,
                omega_rad_s: best.peak_omega_rad_s,
            });
        }
        let peak = match best.analysis.peak(self.settings.certificate_slack) {
            // The norm is a certificate, too, if a wider one.
            Err(MuError::NotCovered { .. }) if norm.is_finite() => {
                let bounds = best.analysis.bounds(best.peak_omega_rad_s)?;
                return Ok(Certified { upper: norm, lower: bounds.lower, omega_rad_s: best.peak_omega_rad_s });
            }
            other => other?,
        };
        Ok(Certified { upper: peak.upper, lower: peak.bounds.lower, omega_rad_s: peak.omega_rad_s })
    }

    fn has_reached(&self, best: &Iterate) -> bool {
        self.settings.target_mu.is_some_and(|t| best.mu_peak < t)
    }

    /// D-K steps until the settings or the patience end them.
    fn alternate(&mut self, best: &mut Iterate, log: &mut Log) {
        let mut idle = 0;
        let mut next = self.next_scales(best);
        while let Some(scales) = next.take() {
            if self.has_reached(best)
                || idle >= self.settings.patience
                || log.steps.len() >= self.settings.max_iterations
            {
                return;
            }
            match log.enter(&scales, self.attempt(&scales, None)) {
                Ok(current) => {
                    let limit = best.mu_peak * (1.0 - self.settings.min_improvement);
                    idle = if current.mu_peak < limit { 0 } else { idle + 1 };
                    next = self.next_scales(&current);
                    if current.mu_peak < best.mu_peak {
                        *best = current;
                    }
                }
                Err(_) => {
                    // Once more from the best, with half the change of scale.
                    idle += 1;
                    next = best.scales.towards(&scales, 0.5, &self.limits());
                }
            }
        }
    }

    /// Descent on γ from the best scales, in stages that each end in a controller.
    fn descend(&mut self, best: &mut Iterate, log: &mut Log) {
        let structure = self.structure.clone();
        let descent = ScaleDescent { plant: self.plant, structure: &structure, limits: self.limits() };
        let mut steps = self.settings.descent_steps;
        if steps == 0 || self.has_reached(best) {
            return;
        }
        // γ has several valleys, and which is the deepest shows late.
        let enough = self.settings.target_mu.unwrap_or(0.0);
        let starts = self.descent_starts(&descent, best);
        let begun = starts.into_par_iter().filter_map(|start| descent.begin(start));
        let mut courses: Vec<Course> = begun.collect();
        let mut entered = f64::INFINITY;
        while steps > 0 {
            let stage = steps.min(DESCENT_STAGE);
            steps -= stage;
            courses.par_iter_mut().for_each(|course| {
                let before = course.ln_level;
                descent.run(course, stage, enough);
                course.ended |= before - course.ln_level < WORTH_A_STAGE;
            });
            let levels = courses.iter().map(|c| c.ln_level);
            let deepest = levels.fold(f64::INFINITY, f64::min);
            courses.retain(|course| course.ln_level <= deepest + BEHIND);
            if let Some(course) = courses.iter().find(|c| c.ln_level == deepest)
                && deepest < entered
                && let Ok(current) = log.enter(&course.scales, self.attempt(&course.scales, None))
                && current.mu_peak < best.mu_peak
            {
                *best = current;
            }
            entered = deepest;
            if self.has_reached(best) || courses.iter().all(|course| course.ended) {
                return;
            }
        }
    }

    /// The best scales so far, raised to the full order by cancelling poles and zeros spread over the range; or such
    /// poles and zeros alone; and the best fit of full order. The two with the lowest γ.
    fn descent_starts(&self, descent: &ScaleDescent, best: &Iterate) -> Vec<DScales> {
        let order = self.settings.max_d_order;
        let (lo, hi) = self.range();
        let raised = |start: &Factors| {
            let mut factors = start.clone();
            let missing = order.saturating_sub(start.order());
            for k in 0..missing {
                let share = (k as f64 + 0.5) / missing as f64;
                let place = lo.ln() + share * (hi / lo).ln();
                factors = factors.extend_factors(place, place);
            }
            factors
        };
        let last = best.scales.factors.len() - 1;
        let (mut own, mut plain) = (best.scales.clone(), best.scales.clone());
        for (own, plain) in own.factors[..last].iter_mut().zip(&mut plain.factors[..last]) {
            let gain = own.ln_magnitude(best.peak_omega_rad_s.min(hi));
            *own = raised(own);
            *plain = raised(&Factors::constant(gain));
        }
        let mut starts = vec![own, plain];
        starts.extend(self.full_order.iter().map(|f| f.0.clone()));
        let mut leveled: Vec<(DScales, f64)> = starts
            .into_iter()
            .map(|s| {
                let level = descent.ln_level(&s, self.hint).exp();
                (s, level)
            })
            .filter(|(_, level)| level.is_finite())
            .collect();
        leveled.sort_by(|a, b| a.1.total_cmp(&b.1));
        // The same scales by two ways have one level, to its accuracy.
        leveled.dedup_by(|b, a| (b.1 - a.1).abs() < 1e-5 * a.1);
        // A second valley is worth a stage only when its rim is about as deep.
        let deepest = leveled.first().map_or(0.0, |s| s.1);
        leveled.retain(|s| s.1 <= 1.02 * deepest);
        leveled.truncate(2);
        leveled.into_iter().map(|(s, _)| s).collect()
    }

    /// Scales for the next synthesis: of fits of order 0 and of full order the one with the lowest γ.
    fn next_scales(&mut self, current: &Iterate) -> Option<DScales> {
        let points = current.analysis.sweep(&self.fit_frequencies(current)).ok()?;
        let structure = self.structure.clone();
        let descent = ScaleDescent { plant: self.plant, structure: &structure, limits: self.limits() };
        let highest = self.settings.max_d_order;
        let mut candidates = vec![(0, SMOOTH_SLACKS[0])];
        if highest > 0 {
            candidates.extend(SMOOTH_SLACKS.map(|slack| (highest, slack)));
        }
        let levels: Vec<(DScales, f64)> = candidates
            .into_par_iter()
            .filter_map(|(order, slack)| {
                let scales = self.fit_scales(current, &points, order, slack)?;
                let level = descent.ln_level(&scales, self.hint).exp();
                level.is_finite().then_some((scales, level))
            })
            .collect();
        for (scales, level) in &levels {
            let full = scales.orders().iter().all(|o| *o == highest);
            if full && self.full_order.as_ref().is_none_or(|f| *level < f.1) {
                self.full_order = Some((scales.clone(), *level));
            }
        }
        levels.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(scales, _)| scales)
    }

    /// Decades round the poles of the plant.
    fn range(&self) -> (f64, f64) {
        if let Some(range) = self.settings.fit_range_rad_s {
            return range;
        }
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
        let inside: Vec<&MuPoint> =
            current.points.iter().filter(|p| p.omega_rad_s >= lo && p.omega_rad_s <= hi).collect();
        let least = (hi / lo).ln() / FIT_POINTS as f64;
        let mut list: Vec<f64> = vec![];
        for (k, p) in inside.iter().enumerate() {
            let here = p.upper;
            let top = k > 0 && k + 1 < inside.len() && here >= inside[k - 1].upper && here > inside[k + 1].upper;
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

    /// Scales of one order fitted to the pointwise optimum, weighted by μ.
    fn fit_scales(&self, current: &Iterate, points: &[MuPoint], order: usize, slack: f64) -> Option<DScales> {
        let last = self.structure.spans.len() - 1;
        let weight: Vec<f64> = points.iter().map(|p| (p.upper / current.mu_peak).max(1e-3)).collect();
        let scales: Vec<Vec<f64>> = points
            .par_iter()
            .map(|p| {
                let response = current.analysis.response(p.omega_rad_s);
                dscale::smooth(&response, &self.structure, slack)
            })
            .collect();
        let fits: Option<Vec<Factors>> = (0..last)
            .into_par_iter()
            .map(|block| {
                // Irreducible parts of a loop may be scaled apart without limit; twelve decades are enough.
                let magnitude = scales.iter().map(|d| d[block].clamp(1e-12, 1e12));
                let omega = points.iter().map(|p| p.omega_rad_s);
                let data = Magnitudes::new(omega.collect(), magnitude.collect(), weight.clone());
                let mut data = data.ok()?;
                data.limits = self.limits();
                Some(fit_quick(&data, order))
            })
            .collect();
        let mut factors = fits?;
        factors.push(Factors::constant(0.0));
        Some(DScales { factors })
    }

    fn limits(&self) -> FitRanges {
        let (lo, hi) = self.range();
        FitRanges { ln_omega: (lo.ln() - 2.3, hi.ln() + 2.3), ln_damping: LN_DAMPING }
    }
}

/// Relative fall of γ in a stage below which the descent ends.
const WORTH_A_STAGE: f64 = 1e-4;
/// Relative distance in γ from the deepest valley at which another one is left.
const BEHIND: f64 = 0.01;
/// D may be off its pointwise optimum by this, if it is smoother there; the better of the two is used.
const SMOOTH_SLACKS: [f64; 2] = [1e-3, 3e-2];
/// Steps between two controllers of the descent.
const DESCENT_STAGE: usize = 30;
/// Sharper corners of D than ζ = 0.05 follow the grid, not the loop; ζ = 30 separates two real corners by 3.5 decades.
const LN_DAMPING: (f64, f64) = (-3.0, 3.4);

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
        Err(error) => DkStep { failure: Some(error.to_string()), ..blank },
    }
}
