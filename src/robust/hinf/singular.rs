//! Singular H∞ problems: D12 or D21 without full rank, or a zero of P12 or P21 on the imaginary axis, where the
//! infimum is in general not attained and the Riccati equations do not exist. The plant is enlarged by small
//! channels: errors ε u, disturbances ε at the measurements, and, against zeros on the axis, errors δ x and
//! disturbances δ on the states. The loop of the given plant is a part of the enlarged one, so the level of the
//! enlarged one bounds its norm. The share ε falls by decades until the level settles; the norm is computed on the
//! plant as given.

use super::channel_units::ChannelUnits;
use super::regularise::{Needs, Regularisation, enlarged_by};
use super::{HinfSettings, HinfSolution, synthesise};
use crate::augment::GeneralizedPlant;
use crate::lti::connect::lower_lft;
use crate::lti::norm::hinf_norm_and_growth;
use crate::robust::error::SynthesisError;

/// Shares of the gains of the plant that are added, one after the other; below the last one X and Y span more digits
/// than a double has.
const SHARES: [f64; 7] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
/// The level has settled when ten times less changes it by no more than this share: that of the distance at which
/// controllers are delivered.
const SETTLED: f64 = 1e-3;
/// Relative tolerance of the norm of the given plant.
pub(super) const NORM_TOL: f64 = 1e-9;

/// What was added to a singular problem, and what it changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Perturbation {
    /// The assumption that the plant as given violates.
    pub reason: SynthesisError,
    /// Share of the gains that was added.
    pub share: f64,
    /// The sizes of the channels that were added.
    pub added: Regularisation,
    /// Relative change of the optimal level from ten times the share; NaN when there is none to compare with.
    pub level_change: f64,
    /// Whether that change is small.
    pub is_settled: bool,
    /// Norm of the enlarged loop.
    pub enlarged_norm: f64,
}

/// Synthesis for any plant: the regular problem as [`synthesise`] solves it, else the nearest regular one. The levels
/// are then those of the enlarged plant, upper bounds for the given one; the norm and its frequency are those of the
/// given one. The perturbation is none for a regular problem.
///
/// # Errors
/// As [`synthesise`]; for a singular problem that of the last enlarged one when none has a solution.
pub fn synthesise_perturbed(
    plant: &GeneralizedPlant,
    settings: &HinfSettings,
) -> Result<(HinfSolution, Option<Perturbation>), SynthesisError> {
    let reason = match synthesise(plant, settings) {
        Ok(found) => return Ok((found, None)),
        Err(error) if is_singular(&error) => error,
        Err(error) => return Err(error),
    };
    let Some(units) = ChannelUnits::new(plant) else {
        return Err(reason);
    };
    let mut trial = SingularTrial { plant, settings, units, needs: Needs::default() };
    let (mut best, mut failure): (Option<(HinfSolution, Perturbation)>, _) = (None, reason.clone());
    for share in SHARES {
        let (found, added, enlarged_norm) = match trial.solve(share) {
            Ok(found) => found,
            // What fails with more added fails with less by rounding, once there has been a level.
            Err(error) => {
                failure = error;
                continue;
            }
        };
        let before = best.as_ref().map(|(solution, _)| solution.gamma_opt);
        let level_change = before.map_or(f64::NAN, |before| (found.gamma_opt / before - 1.0).abs());
        let is_settled = level_change <= SETTLED;
        let reason = reason.clone();
        best = Some((found, Perturbation { reason, share, added, level_change, is_settled, enlarged_norm }));
        // A level that is asked for needs no limit.
        if is_settled || settings.gamma.is_some() {
            break;
        }
    }
    best.map(|(solution, perturbation)| (solution, Some(perturbation))).ok_or(failure)
}

/// Whether a small channel can help.
pub(in crate::robust) fn is_singular(error: &SynthesisError) -> bool {
    use SynthesisError as E;
    matches!(
        error,
        E::ControlCost { .. }
            | E::MeasurementNoise { .. }
            | E::WeakFeedthrough { .. }
            | E::AxisZero { .. }
            | E::Regulator { .. }
    )
}

struct SingularTrial<'a> {
    plant: &'a GeneralizedPlant,
    settings: &'a HinfSettings,
    units: ChannelUnits,
    /// Channels of states that the trials so far have asked for.
    needs: Needs,
}

impl SingularTrial<'_> {
    /// Solution at a share, with the norm of the given plant in place of that of the enlarged one, which comes beside.
    fn solve(&mut self, share: f64) -> Result<(HinfSolution, Regularisation, f64), SynthesisError> {
        loop {
            let (posed, added) = enlarged_by(self.plant, &self.units, share, self.needs);
            let error = match synthesise(&posed, self.settings) {
                Ok(mut found) => {
                    let own = lower_lft(&self.plant.system, &found.controller)?;
                    let (norm, growth_rate) = hinf_norm_and_growth(&own, NORM_TOL)?;
                    let enlarged_norm = found.closed_loop_norm;
                    found.closed_loop_norm = norm.norm;
                    found.closed_loop_peak_rad_s = norm.peak_omega_rad_s;
                    found.certificate.growth_rate = growth_rate;
                    return Ok((found, added, enlarged_norm));
                }
                Err(error) => error,
            };
            let more = needs_of(&error, self.needs);
            if more == self.needs {
                return Err(error);
            }
            self.needs = more;
        }
    }
}

/// The channels of states that a failure asks for, besides those there are.
fn needs_of(error: &SynthesisError, needs: Needs) -> Needs {
    use SynthesisError as E;
    match error {
        E::WeakFeedthrough { source, .. } => needs_of(source, needs),
        E::AxisZero { which, .. } if which.starts_with("P12") => Needs { state_errors: true, ..needs },
        E::AxisZero { .. } => Needs { state_disturbances: true, ..needs },
        E::NotStabilisable { .. } | E::NotDetectable { .. } | E::Partition(_) => needs,
        _ => Needs { state_errors: true, state_disturbances: true },
    }
}
