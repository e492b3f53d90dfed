//! Mixed-μ synthesis: real and repeated parameters enter a D-K iteration as what they are.
//!
//! The synthesis sees Γ(s) D N D⁻¹ with one more stable, minimum-phase function Γ: |Γ(jω)| is the share of the D,G
//! bound of the loop in σ(D N D⁻¹). Where a parameter that is real takes much off the bound, D N D⁻¹ may be as much
//! larger. This is the μ-K iteration of Tøffner-Clausen, Andersen, Stoustrup and Niemann (European Control Conference
//! 1995); it needs no rational G, whose values on the axis are those of an unstable system.
//!
//! Every iterate is judged by the D,G bound of its own loop: a fit that is not close costs steps, not truth.

use super::scale::DScales;
use super::{DkError, DkOutcome, DkRun, DkSettings, Iterate, Log};
use crate::augment::GeneralizedPlant;
use crate::lti::connect::lower_lft;
use crate::robust::dfit::factors::Factors;
use crate::robust::dfit::{Magnitudes, fit_quick};
use crate::robust::mu::system::{MuPoint, MuSystem};
use crate::robust::structure::{MuError, Scaling, Span, Structure};

/// Syntheses of the mixed iteration at most.
const MIXED_STEPS: usize = 12;
/// A step covers half of the way to the new share, because the next loop has another share; it is halved at most this
/// often.
const HALVINGS: i32 = 5;
/// Γ is never below this: a thousandth of a bound needs no more freedom.
const LEAST_SHARE: f64 = 1e-3;

/// Whether the D,G bound of the blocks can be below that of full complex ones.
pub(super) fn is_mixed(plant: &GeneralizedPlant) -> Result<bool, MuError> {
    if plant.blocks.is_empty() {
        return Ok(false);
    }
    Ok(!Structure::new(&plant.blocks)?.spans.iter().all(Span::has_scalar_scaling))
}

/// Lowers the D,G bound of an outcome; its peak is certified for the blocks as they are.
pub(super) fn refine(
    plant: &GeneralizedPlant,
    settings: &DkSettings,
    outcome: &mut DkOutcome,
    progress: &mut dyn FnMut(&super::DkStep),
) -> Result<(), DkError> {
    let mut run = DkRun::new(plant, settings)?;
    let start = run.analyse(outcome.controller.clone(), outcome.gamma, outcome.scales.clone())?;
    let start = Iterate { iteration: outcome.best_iteration, ..start };
    let mut best = MixedIterate::new(plant, start, Factors::constant(0.0))?;
    let mut log = Log { steps: std::mem::take(&mut outcome.steps), progress };
    let mut halvings = 0;
    for _ in 0..MIXED_STEPS {
        if settings.target_mu.is_some_and(|target| best.top.upper < target) || halvings > HALVINGS {
            break;
        }
        let Some(next) = run.next_mixed(&best, 0.5f64.powi(halvings + 1)) else { break };
        let attempt = run.attempt(&next.scales, Some(&next.share));
        let Ok(iterate) = log.enter(&next.scales, attempt) else {
            halvings += 1;
            continue;
        };
        let found = MixedIterate::new(plant, iterate, next.share)?;
        log.correct_last(&found.top);
        if found.top.upper < best.top.upper * (1.0 - settings.min_improvement) {
            best = found;
        } else {
            halvings += 1;
        }
    }
    outcome.steps = log.steps;
    let peak = match best.real.peak(settings.certificate_slack) {
        // The controller of the complex iteration is certified already; its bound holds for these blocks, too.
        Err(MuError::NotCovered { .. }) => return Ok(()),
        found => found?,
    };
    outcome.mu_peak = peak.upper;
    outcome.mu_lower_peak = peak.bounds.lower;
    outcome.peak_omega_rad_s = peak.omega_rad_s;
    outcome.gamma = best.iterate.gamma;
    outcome.best_iteration = best.iterate.iteration;
    outcome.scales = best.iterate.scales;
    outcome.controller = best.iterate.controller;
    Ok(())
}

/// A controller with the analysis of its loop for full complex blocks and for the blocks as they are.
struct MixedIterate {
    iterate: Iterate,
    real: MuSystem,
    top: MuPoint,
    share: Factors,
}

impl MixedIterate {
    fn new(plant: &GeneralizedPlant, iterate: Iterate, share: Factors) -> Result<Self, DkError> {
        let closed = lower_lft(&plant.system, &iterate.controller)?;
        let real = MuSystem::new(&closed, &plant.blocks)?;
        let (top, _) = real.largest()?;
        Ok(Self { iterate, real, top, share })
    }
}

/// What the next synthesis of a mixed iteration is scaled with.
struct MixedScales {
    scales: DScales,
    share: Factors,
}

impl DkRun<'_> {
    /// The D of the best iterate, and Γ moved by `part` of the way to the share of the D,G bound in σ(D N D⁻¹).
    fn next_mixed(&self, best: &MixedIterate, part: f64) -> Option<MixedScales> {
        let iterate = &best.iterate;
        let omega = self.fit_frequencies(iterate);
        let scales = iterate.scales.clone();
        let bounds = best.real.sweep(&omega).ok()?;
        let share: Vec<f64> = bounds
            .iter()
            .map(|bound| {
                let frozen = Scaling::diagonal(&self.structure, &scales.magnitudes(bound.omega_rad_s));
                let level = frozen.bound_at(&iterate.analysis.response(bound.omega_rad_s));
                let own = (bound.upper / level).clamp(LEAST_SHARE, 1.0).ln();
                let before = best.share.ln_magnitude(bound.omega_rad_s);
                (before + part * (own - before)).exp()
            })
            .collect();
        let weight = bounds.iter().map(|b| (b.upper / best.top.upper).max(LEAST_SHARE)).collect();
        let mut data = Magnitudes::new(omega, share, weight).ok()?;
        data.limits = self.limits();
        Some(MixedScales { scales, share: fit_quick(&data, self.settings.max_d_order) })
    }
}
