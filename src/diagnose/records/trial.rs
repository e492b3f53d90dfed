//! A machine with a measurement, reduced and whitened: what a case is made of.

use super::super::DiagnoseError;
use super::super::data::evidence::{Evidence, Subset};
use super::super::data::measurement::{RecordId, RecordSet};
use super::super::decide::candidate::Standing;
use super::super::decide::selection::complete;
use super::super::fit::case::Case;
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::model::Model;
use crate::lti::HeldResponse;
use crate::spindle::Machine;

/// Share of the prior variance below which the data know a parameter.
const KNOWN: f64 = 0.25;
/// Factors on the priors: moduli of 2 and 4 %, force constants of 4 and 8 %.
const WIDTHS: [f64; 2] = [2.0, 4.0];

/// A machine with a measurement.
pub(crate) struct Trial<'a> {
    pub machine: Machine,
    pub measurement: RecordSet<'a>,
    pub evidence: Evidence,
    pub model: Model,
}

/// A machine with wider priors.
pub(crate) struct Widened<'a> {
    pub trial: Trial<'a>,
    /// Its fit without effects.
    pub null: Standing,
    /// Whether that leaves nothing significant.
    pub complete: bool,
    /// What the width adds to a score: the logarithm of itself for each number that the data know.
    pub cost: f64,
}

impl Widened<'_> {
    /// The score of the fit without effects, with what the width costs.
    pub(crate) fn score(&self) -> f64 {
        self.null.candidate.score() + self.cost
    }
}

impl<'a> Trial<'a> {
    /// Reduces the machine and whitens the records.
    pub(crate) fn new(machine: &Machine, measurement: RecordSet<'a>) -> Result<Self, DiagnoseError> {
        let evidence = Evidence::new(&measurement)?;
        Ok(Self {
            model: Model::new(machine, &evidence.axis_gain_sd())?,
            machine: machine.clone(),
            measurement,
            evidence,
        })
    }

    /// The same machine with other records of the same number.
    pub(crate) fn with(&self, measurement: RecordSet<'a>) -> Result<Self, DiagnoseError> {
        Ok(Self {
            evidence: Evidence::new(&measurement)?,
            model: self.model.clone(),
            machine: self.machine.clone(),
            measurement,
        })
    }

    /// The same machine and records as other evidence shows them.
    pub(crate) fn observing(&self, evidence: Evidence) -> Self {
        Self {
            evidence,
            model: self.model.clone(),
            machine: self.machine.clone(),
            measurement: self.measurement.clone(),
        }
    }

    /// The same evidence with another machine.
    pub(crate) fn of_machine(&self, machine: &Machine) -> Result<Self, DiagnoseError> {
        Ok(Self {
            evidence: self.evidence.clone(),
            model: Model::new(machine, &self.evidence.axis_gain_sd())?,
            machine: machine.clone(),
            measurement: self.measurement.clone(),
        })
    }

    /// The same with a controller in one hammer test; the evidence stays.
    pub(crate) fn under(&self, tap: usize, controller: &'a dyn HeldResponse) -> Self {
        let mut other = self.observing(self.evidence.clone());
        if let Some(tap) = other.measurement.taps.get_mut(tap) {
            tap.controller = controller;
        }
        other
    }

    /// The controller of a hammer test.
    pub(crate) fn controller(&self, record: RecordId) -> Option<&'a dyn HeldResponse> {
        match record {
            RecordId::Hammer(t) => self.measurement.taps.get(t).map(|tap| tap.controller),
            RecordId::Sweep(_) => None,
        }
    }

    /// The fit without effects down to a model error.
    pub(crate) fn reaches(&self, model_error: f64) -> Result<Standing, DiagnoseError> {
        let case = self.case(&[], &|_| {});
        case.fit_until(&[], &case.origin(), Subset::ALL, model_error)
    }

    pub(crate) fn case<'b>(&'b self, catalogue: &'b [Hypothesis], progress: &'b (dyn Fn(&str) + Sync)) -> Case<'b> {
        Case { model: &self.model, evidence: &self.evidence, catalogue, seeks_strong: true, progress }
    }

    /// The fit without effects to a subset, and whether nothing significant is left.
    pub(crate) fn stands(&self, usage: Subset) -> Result<(Standing, bool), DiagnoseError> {
        let case = self.case(&[], &|_| {});
        let standing = case.fit_down(&[], &case.origin(), usage)?;
        let complete = complete(&case, &standing)?;
        Ok((standing, complete))
    }

    /// The machine with all priors wider, once for each width: a machine that was updated less carefully has every
    /// number further off, a missing effect only few.
    pub(crate) fn widen_tolerances(&self, null: &Standing) -> Result<Vec<Widened<'a>>, DiagnoseError> {
        let covariance = null.candidate.fit.covariance()?;
        let own = self.model.layout.machine.mesh();
        let sd = &self.model.layout.sd;
        let known = (0..own).filter(|k| covariance[(*k, *k)] < KNOWN * sd[*k].powi(2));
        let known = known.count() as f64;
        let widen = |width: f64| {
            let mut trial = self.observing(self.evidence.clone());
            trial.model.layout.widen_priors(width);
            let (null, complete) = trial.stands(Subset::ALL)?;
            Ok(Widened { trial, null, complete, cost: 2.0 * known * width.ln() })
        };
        WIDTHS.into_iter().map(widen).collect()
    }
}
