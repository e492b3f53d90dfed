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
    /// μ.
    pub mu_peak: f64,
    /// Order.
    pub controller_order: usize,
    /// D orders.
    pub d_orders: Vec<usize>,
    /// Number.
    pub iteration: usize,
    /// Failure.
    pub failure: Option<String>,
}
/// Outcome.
#[derive(Clone, Debug)]
pub struct DkOutcome {
    /// K.
    pub controller: StateSpace<Continuous>,
    /// γ.
    pub gamma: f64,
    /// Best.
    pub best_iteration: usize,
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
    let step = DkStep { gamma: s.gamma, mu_peak: s.gamma, controller_order: s.controller.order(), d_orders: vec![], iteration: 0, failure: None };
    progress(&step);
    Ok(DkOutcome { controller: s.controller, gamma: s.gamma, best_iteration: 0, steps: vec![step] })
}
