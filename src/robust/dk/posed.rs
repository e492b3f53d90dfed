//! D-K iteration for plants as they are posed: singular ones are enlarged by small channels, as for H∞ synthesis, and
//! sampled ones solved in the w plane. The peak of μ of the answer is certified on the loop of the plant as given.

use super::mixed::{is_mixed, refine};
use super::{DkError, DkOutcome, DkSettings, DkStep, full_blocks, iterate};
use crate::augment::{Block, GeneralizedPlant};
use crate::lti::connect::lower_lft;
use crate::lti::sample::inverse_tustin;
use crate::lti::{Continuous, Discrete, StateSpace};
use crate::robust::hinf::HinfSettings;
use crate::robust::hinf::regularise::enlarge;
use crate::robust::hinf::sampled::SampledPlant;
use crate::robust::hinf::singular::{Perturbation, is_singular, synthesise_perturbed};
use crate::robust::mu::system::MuSystem;
use crate::robust::structure::MuError;

/// [`iterate`] for any plant. With real or repeated parameters the mixed iteration follows, and the peak is that of the
/// D,G bound. A singular one is enlarged by the channels with which its level without scales settles;
/// the perturbation states them, with the peak of μ of the enlarged loop as its norm.
///
/// # Errors
/// As [`iterate`].
pub fn iterate_perturbed(
    plant: &GeneralizedPlant,
    settings: &DkSettings,
    progress: &mut dyn FnMut(&DkStep),
) -> Result<(DkOutcome, Option<Perturbation>), DkError> {
    match iterate_mixed(plant, settings, progress) {
        Err(DkError::Synthesis(reason)) if is_singular(&reason) => {}
        other => return Ok((other?, None)),
    }
    let (_, perturbation) = synthesise_perturbed(plant, &HinfSettings::default())?;
    let enlarged = perturbation.as_ref().map_or_else(|| plant.clone(), |p| enlarge(plant, &p.added));
    let mut found = iterate_mixed(&enlarged, settings, progress)?;
    let enlarged_norm = found.mu_peak;
    let loop_as_given = lower_lft(&plant.system, &found.controller)?;
    certify(&mut found, &loop_as_given, plant, settings)?;
    Ok((found, perturbation.map(|p| Perturbation { enlarged_norm, ..p })))
}

/// [`iterate`], and from its answer on the mixed iteration where a parameter is real or repeated.
///
/// # Errors
/// As [`iterate`].
pub fn iterate_mixed(
    plant: &GeneralizedPlant,
    settings: &DkSettings,
    progress: &mut dyn FnMut(&DkStep),
) -> Result<DkOutcome, DkError> {
    let mut outcome = iterate(plant, settings, progress)?;
    if is_mixed(plant)? {
        refine(plant, settings, &mut outcome, progress)?;
    }
    Ok(outcome)
}

/// [`iterate_perturbed`] in sampled time; frequencies are true ones, and the peak is that of the sampled loop.
///
/// # Errors
/// As [`iterate`].
pub fn iterate_sampled(
    plant: &SampledPlant,
    settings: &DkSettings,
    progress: &mut dyn FnMut(&DkStep),
) -> Result<(DkOutcome<Discrete>, Option<Perturbation>), DkError> {
    let time = plant.time();
    let limits = settings.fit_range_rad_s.map(|(lo, hi)| (time.w_frequency(lo), time.w_frequency(hi)));
    let mapped = DkSettings { fit_range_rad_s: limits, ..settings.clone() };
    let (mut found, perturbation) = iterate_perturbed(&plant.image, &mapped, progress)?;
    let controller = plant.sample_controller(&found.controller)?;
    let closed = inverse_tustin(&plant.close(&controller)?)?;
    certify(&mut found, &closed, &plant.image, settings)?;
    let outcome = DkOutcome {
        controller,
        mu_peak: found.mu_peak,
        mu_lower_peak: found.mu_lower_peak,
        peak_omega_rad_s: time.true_frequency(found.peak_omega_rad_s),
        gamma: found.gamma,
        scales: found.scales,
        best_iteration: found.best_iteration,
        steps: found.steps,
    };
    Ok((outcome, perturbation))
}

/// Takes the certified peak of μ of a loop into the outcome.
fn certify(
    outcome: &mut DkOutcome,
    closed: &StateSpace<Continuous>,
    plant: &GeneralizedPlant,
    settings: &DkSettings,
) -> Result<(), DkError> {
    let peak = match MuSystem::new(closed, &declared_blocks(plant)?)?.peak(settings.certificate_slack) {
        // The bound of the loop that this one is a part, or the image, of holds for it.
        Err(MuError::NotCovered { .. }) => return Ok(()),
        found => found?,
    };
    outcome.mu_peak = peak.upper;
    outcome.mu_lower_peak = peak.bounds.lower;
    outcome.peak_omega_rad_s = peak.omega_rad_s;
    Ok(())
}

/// The blocks as they are; one full block where none is declared.
fn declared_blocks(plant: &GeneralizedPlant) -> Result<Vec<Block>, DkError> {
    if plant.blocks.is_empty() { full_blocks(plant) } else { Ok(plant.blocks.clone()) }
}
