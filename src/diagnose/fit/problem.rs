//! What is fitted to what: effects of a hypothesis, and a point in their coordinates and the nuisance parameters.

use super::super::data::evidence::{Evidence, Subset};
use super::hypothesis::Hypothesis;
use super::model::Model;

/// Parameters of a hypothesis, fitted or not.
#[derive(Clone, Debug)]
pub struct Point {
    /// Nuisance parameters.
    pub p: Vec<f64>,
    /// Fit coordinates of each effect.
    pub theta: Vec<Vec<f64>>,
    /// Amplitude of the smooth model error, relative.
    pub smooth: f64,
}

impl Point {
    /// The same with effect `e` at the position where a hypothesis starts.
    pub(crate) fn with_effect_at(&self, e: usize, h: &Hypothesis) -> Option<Self> {
        let mut moved = self.clone();
        *moved.theta.get_mut(e)?.last_mut()? = *h.start.last()?;
        Some(moved)
    }

    /// The same with the newest effect at the position where a hypothesis starts.
    pub(crate) fn with_newest_at(&self, h: &Hypothesis) -> Option<Self> {
        self.with_effect_at(self.theta.len().checked_sub(1)?, h)
    }
}

/// Something that can be fitted.
pub struct Problem<'a> {
    /// The reduced machine.
    pub model: &'a Model,
    /// The data.
    pub evidence: &'a Evidence,
    /// Which of them.
    pub usage: Subset,
    /// The effects.
    pub effects: &'a [Hypothesis],
}
