//! H∞ synthesis: the smallest γ for which a controller u = K y with ‖F_l(P, K)‖∞ < γ exists, and that controller.
//! Conditions at γ (Glover and Doyle 1988): γ above the feedthrough bound, no axis eigenvalue of either Hamiltonian,
//! X ≥ 0, Y ≥ 0, ρ(XY) < γ². All five are tested; stability of the closed loop alone proves nothing.
//!
//! The controller is delivered slightly above the optimum, where I − YX/γ² is invertible, and is verified by closing
//! the loop and computing its norm.

pub(crate) mod assumptions;
mod channel_units;
pub(crate) mod controller;
mod coupling_root;
pub(crate) mod couplings;
mod feedthrough;
mod level_bracket;
mod limit;
pub(crate) mod matrix_slope;
mod near;
pub(crate) mod normal;
pub mod regularise;
mod riccati_pair;
pub mod sampled;
mod search;
pub(crate) mod settings;
pub(crate) mod side;
pub mod singular;
pub(crate) mod slope;

use crate::augment::GeneralizedPlant;
use crate::linalg::riccati::RiccatiEffort;
use crate::lti::connect::lower_lft;
use crate::lti::norm::{NormError, hinf_norm_and_growth};
use crate::lti::{Continuous, StateSpace, TimeBase};
use crate::robust::error::{Condition, SynthesisError};
use controller::central;
use couplings::BindingLevel;
use feedthrough::blame_feedthrough;
pub use limit::Limit;
use limit::Optimum;
use near::near_level;
use search::{GammaSearch, LEVEL_TOL};
pub use settings::HinfSettings;
use slope::binding_levels;
use std::cell::Cell;

/// Margins and residuals at the level of the delivered controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// The condition that fails just below the optimal level; none where the level was given.
    pub limit: Option<Limit>,
    /// Relative residual of X.
    pub x_residual: f64,
    /// Relative residual of Y.
    pub y_residual: f64,
    /// Smallest eigenvalue of X relative to the largest.
    pub x_min: f64,
    /// Smallest eigenvalue of Y relative to the largest.
    pub y_min: f64,
    /// ρ(XY)/γ², below one.
    pub coupling: f64,
    /// Largest growth rate of the closed loop, 1/s.
    pub growth_rate: f64,
    /// Riccati pairs solved in the search.
    pub pairs: usize,
}

/// Controller with its levels.
#[derive(Clone, Debug)]
pub struct HinfSolution<T: TimeBase = Continuous> {
    /// u = K y.
    pub controller: StateSpace<T>,
    /// Level of the controller: that of its Riccati equations, or the verified norm where rounding put it above.
    pub gamma: f64,
    /// Optimal level (the feasible end of its tolerance); the level given, when one was given.
    pub gamma_opt: f64,
    /// Norm of the closed loop, computed independently.
    pub closed_loop_norm: f64,
    /// Frequency of that norm, rad/s.
    pub closed_loop_peak_rad_s: f64,
    /// Margins and residuals.
    pub certificate: Certificate,
}

/// The optimal level alone, without a controller: for searches over weights and scales.
pub(crate) fn optimal_level(plant: &GeneralizedPlant, settings: &HinfSettings) -> Result<f64, SynthesisError> {
    GammaSearch::new(plant)
        .and_then(|search| Ok(search.optimum(settings, &Cell::new(0))?.gamma))
        .map_err(|error| blame_feedthrough(plant, error))
}

/// ln of the optimal level, and the levels that bind there with their derivatives. From a level of a similar problem
/// (`settings.hint`) the search is a few steps of Newton's method.
pub(crate) fn optimal_level_with_slopes(
    plant: &GeneralizedPlant,
    settings: &HinfSettings,
) -> Result<(f64, Vec<BindingLevel>), SynthesisError> {
    if let Some(hint) = settings.hint
        && let Ok(Some(found)) = near_level(plant, hint, settings.rel_tol)
    {
        return Ok(found);
    }
    let found = || {
        let (search, pairs) = (GammaSearch::new(plant)?, Cell::new(0));
        let optimum = match settings.hint {
            // What leads nowhere from the hint leads nowhere from below it.
            Some(_) => search.above_bounds(settings, &pairs)?,
            None => search.optimum(settings, &pairs)?,
        };
        let ln = optimum.gamma.ln();
        let levels = binding_levels(&search, optimum.gamma)?;
        // The optimum is the feasible end of its tolerance; the level that binds is what the slopes belong to.
        let top = levels.iter().map(|level| level.ln_level).max_by(f64::total_cmp);
        let same = top.filter(|top| (top - ln).abs() <= 2.0 * settings.rel_tol);
        Ok((same.unwrap_or(ln), levels))
    };
    found().map_err(|error| blame_feedthrough(plant, error))
}

/// Whether a controller with ‖F_l(P, K)‖∞ < γ exists: the conditions at this level alone, one pair of Riccati equations
/// where a search needs a dozen and the peaks of both sides. A level at which no solver finds a solution counts as
/// infeasible, so within rounding of the optimum the answer may be no.
///
/// # Errors
/// [`SynthesisError`] when the problem has no normal form or a decomposition fails.
pub fn is_feasible(plant: &GeneralizedPlant, gamma: f64) -> Result<bool, SynthesisError> {
    GammaSearch::feasible(plant, gamma).map_err(|error| blame_feedthrough(plant, error))
}

/// Synthesis for a generalized plant.
///
/// # Errors
/// [`SynthesisError`] names the assumption, the condition or the check that fails.
pub fn synthesise(plant: &GeneralizedPlant, settings: &HinfSettings) -> Result<HinfSolution, SynthesisError> {
    attempt(plant, settings).map_err(|error| blame_feedthrough(plant, error))
}

fn attempt(plant: &GeneralizedPlant, settings: &HinfSettings) -> Result<HinfSolution, SynthesisError> {
    let search = GammaSearch::new(plant)?;
    let pairs = Cell::new(0);
    if let Some(gamma) = settings.gamma {
        let found = search.deliver(plant, None, gamma, &pairs)?;
        return if found.closed_loop_norm > gamma * (1.0 + 2.0 * LEVEL_TOL) {
            Err(refute_gamma(gamma, &found))
        } else {
            Ok(found)
        };
    }
    let optimum = search.optimum(settings, &pairs)?;
    match search.deliver_near(plant, optimum, settings, &pairs) {
        // Near the end of what f64 can hold the coupling may have a root below the level of a side.
        Err(SynthesisError::Infeasible { .. }) if optimum.limit == Limit::Coupling => {
            let optimum = search.above_bounds(settings, &pairs)?;
            search.deliver_near(plant, optimum, settings, &pairs)
        }
        found => found,
    }
}

/// Distances from the optimum at which a controller is formed; a larger one is taken only when the smaller ones fail
/// their check, which happens on plants near the end of what f64 can hold.
const LADDER: [f64; 5] = [1e-3, 3e-3, 9e-3, 5e-2, 2e-1];

/// The same where the infimum is zero: the controller cancels the plant, and the norm of the loop is rounding.
const DECADES_ABOVE: [f64; 6] = [9.0, 1e2, 1e3, 1e4, 1e5, 1e6];

/// Distance from the optimum within which a verified norm is as good as the level aimed at.
const CLOSE: f64 = 9.9e-3;

fn refute_gamma(gamma: f64, found: &HinfSolution) -> SynthesisError {
    SynthesisError::Refuted { gamma, norm: found.closed_loop_norm, growth_rate: found.certificate.growth_rate }
}

impl GammaSearch {
    /// The controller as near above an optimum as one passes its check.
    fn deliver_near(
        &self,
        plant: &GeneralizedPlant,
        optimum: Optimum,
        settings: &HinfSettings,
        pairs: &Cell<usize>,
    ) -> Result<HinfSolution, SynthesisError> {
        let gamma_opt = optimum.gamma;
        let mut failure = SynthesisError::NoLevel { gamma: gamma_opt, condition: Condition::Unsolved };
        let further: &[f64] = match optimum.limit {
            Limit::Rounding => &DECADES_ABOVE,
            _ => &LADDER,
        };
        let further = further.iter().copied().filter(|s| *s > settings.slack);
        for slack in std::iter::once(settings.slack).chain(further) {
            let gamma = gamma_opt * (1.0 + slack);
            match self.deliver(plant, Some(optimum), gamma, pairs) {
                // Rounding in a nearly singular problem can leave the loop above its level: the level is then the norm.
                Ok(found) if found.gamma <= gamma_opt * (1.0 + slack.max(CLOSE)) => {
                    return Ok(found);
                }
                Ok(found) => failure = refute_gamma(gamma, &found),
                Err(error) => failure = error,
            }
        }
        Err(failure)
    }

    fn deliver(
        &self,
        plant: &GeneralizedPlant,
        optimum: Option<Optimum>,
        gamma: f64,
        pairs: &Cell<usize>,
    ) -> Result<HinfSolution, SynthesisError> {
        if !(gamma.is_finite() && gamma > 0.0) {
            return Err(SynthesisError::Partition(format!("gamma must be a positive number, found {gamma}")));
        }
        // X and Y exact to the last bit are needed for few plants, and cost more than all the rest.
        let fast = self.deliver_with(plant, optimum, gamma, RiccatiEffort::Fast, pairs);
        if fast.as_ref().is_ok_and(|f| f.gamma <= gamma) {
            return fast;
        }
        if let Some(condition) = self.below_level(gamma)? {
            return Err(SynthesisError::Infeasible { gamma, condition });
        }
        match (fast, self.deliver_with(plant, optimum, gamma, RiccatiEffort::Full, pairs)) {
            (Ok(f), Ok(g)) => Ok(if f.gamma < g.gamma { f } else { g }),
            (Ok(found), Err(_)) | (_, Ok(found)) => Ok(found),
            (_, Err(error)) => Err(error),
        }
    }

    fn deliver_with(
        &self,
        plant: &GeneralizedPlant,
        optimum: Option<Optimum>,
        gamma: f64,
        effort: RiccatiEffort,
        pairs: &Cell<usize>,
    ) -> Result<HinfSolution, SynthesisError> {
        pairs.set(pairs.get() + 1);
        let pair = self.pair(gamma, effort)?;
        if let Some(condition) = pair.failed {
            return Err(SynthesisError::Infeasible { gamma, condition });
        }
        let k = central(&self.normal, &self.control, &self.filter, gamma, &pair.x, &pair.y)?;
        let controller = self.normal.original_controller(&k)?;
        let closed = lower_lft(&plant.system, &controller)?;
        let (norm, growth_rate) = match hinf_norm_and_growth(&closed, LEVEL_TOL) {
            Ok(found) => found,
            Err(NormError::Unstable { growth_rate }) => {
                return Err(SynthesisError::Refuted { gamma, norm: f64::INFINITY, growth_rate });
            }
            Err(other) => return Err(other.into()),
        };
        // The two bounds of the norm lie 2·LEVEL_TOL apart.
        let above = norm.norm > gamma * (1.0 + 2.0 * LEVEL_TOL);
        Ok(HinfSolution {
            controller,
            gamma: if above { norm.upper } else { gamma },
            gamma_opt: optimum.map_or(gamma, |o| o.gamma),
            closed_loop_norm: norm.norm,
            closed_loop_peak_rad_s: norm.peak_omega_rad_s,
            certificate: Certificate {
                limit: optimum.map(|o| o.limit),
                x_residual: pair.x_residual,
                y_residual: pair.y_residual,
                x_min: pair.x_min,
                y_min: pair.y_min,
                coupling: pair.coupling,
                growth_rate,
                pairs: pairs.get(),
            },
        })
    }
}
