//! A case: the data, the model, and the catalogue of what could be missing.

use super::super::data::evidence::{Evidence, Subset};
use super::hypothesis::Hypothesis;
use super::model::Model;
use super::problem::{Point, Problem};
use crate::diagnose::data::common_error::USUAL;

/// The data, the model and the catalogue.
pub struct Case<'a> {
    /// The reduced machine.
    pub model: &'a Model,
    /// The data.
    pub evidence: &'a Evidence,
    /// All hypotheses.
    pub catalogue: &'a [Hypothesis],
    /// Whether strong effects of any size are looked for where nothing else explains the data.
    pub seeks_strong: bool,
    /// Told what is being done, and how far a round is.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

impl Case<'_> {
    /// A fit of these effects to a subset of the data.
    pub fn problem<'b>(&'b self, effects: &'b [Hypothesis], usage: Subset) -> Problem<'b> {
        Problem { model: self.model, evidence: self.evidence, usage, effects }
    }

    /// The machine as it is.
    pub fn origin(&self) -> Point {
        Point { p: vec![0.0; self.model.layout.len()], theta: vec![], smooth: USUAL }
    }
}
