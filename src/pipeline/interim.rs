//! Interim: one synthesis with constant scales.
use crate::augment::GeneralizedPlant;
use crate::lti::{Continuous, StateSpace};
use crate::robust::{HinfSettings, SynthesisError, synthesise};
/// Settings.
#[derive(Clone, Debug, Default)]
pub struct DkSettings {}
/// Step.
#[derive(Clone, Debug)]
pub struct DkStep {
    /// γ.
    pub gamma: f64,
}
/// Outcome.
#[derive(Clone, Debug)]
pub struct DkOutcome {
    /// K.
    pub controller: StateSpace<Continuous>,
    /// γ.
    pub gamma: f64,
    /// Steps.
    pub steps: Vec<DkStep>,
}
/// One synthesis.
///
/// # Errors
/// As synthesis.
pub fn iterate(
    plant: &GeneralizedPlant,
    _: &DkSettings,
    progress: &mut dyn FnMut(&DkStep),
) -> Result<DkOutcome, SynthesisError> {
    let s = synthesise(plant, &HinfSettings { slack: 1e-2, ..HinfSettings::default() })?;
    let step = DkStep { gamma: s.gamma };
    progress(&step);
    Ok(DkOutcome { controller: s.controller, gamma: s.gamma, steps: vec![step] })
}
