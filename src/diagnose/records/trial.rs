//! A machine with a measurement, reduced and whitened: what a case is made of.

use super::super::DiagnoseError;
use super::super::data::evidence::{Evidence, Subset};
use super::super::data::measurement::Measurement;
use super::super::decide::candidate::Standing;
use super::super::decide::selection::complete;
use super::super::fit::case::Case;
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::model::Model;
use crate::spindle::Machine;

/// Share of the prior variance below which the data know a parameter.
const KNOWN: f64 = 0.25;
/// Factors on the priors: moduli of 2 and 4 %, force constants of 4 and 8 %.
const WIDTHS: [f64; 2] = [2.0, 4.0];

/// A machine with a measurement.
pub struct Trial<'a> {
    /// The machine.
    pub machine: Machine,
    /// The records.
    pub measurement: Measurement<'a>,
    /// The records, whitened.
    pub evidence: Evidence,
    /// The machine, reduced.
    pub model: Model,
}

impl<'a> Trial<'a> {
    /// Reduces the machine and whitens the records.
    ///
    /// # Errors
    /// [`DiagnoseError`] for records or machines that cannot be used.
    pub fn new(machine: &Machine, measurement: Measurement<'a>) -> Result<Self, DiagnoseError> {
        let evidence = Evidence::new(&measurement)?;
        Ok(Self {
            model: Model::new(machine, &evidence.axis_gain_sd())?,
            machine: machine.clone(),
            measurement,
            evidence,
        })
    }

    /// The same machine with other records of the same number.
    ///
    /// # Errors
    /// [`DiagnoseError::Record`] for a record that gives no frequency response.
    pub fn with(&self, measurement: Measurement<'a>) -> Result<Self, DiagnoseError> {
        Ok(Self {
            evidence: Evidence::new(&measurement)?,
            model: self.model.clone(),
            machine: self.machine.clone(),
            measurement,
        })
    }

    /// The case with a catalogue.
    pub fn case<'b>(
        &'b self,
        catalogue: &'b [Hypothesis],
        progress: &'b (dyn Fn(&str) + Sync),
    ) -> Case<'b> {
        Case {
            model: &self.model,
            evidence: &self.evidence,
            catalogue,
            progress,
        }
    }

    /// The fit without effects to a subset, and whether nothing significant is left.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the model cannot be assembled.
    pub fn stands(&self, usage: Subset) -> Result<(Standing, bool), DiagnoseError> {
        let case = self.case(&[], &|_| {});
        let standing = case.fit_down(&[], &case.origin(), usage)?;
        let complete = complete(&case, &standing)?;
        Ok((standing, complete))
    }

    /// The machine with all priors wider, and its fit, where that explains the records better than a `score` of named
    /// effects: a machine that was updated less carefully has every number further off, a missing effect only few. The
    /// width costs the logarithm of itself for each number that the data know.
    ///
    /// # Errors
    /// [`DiagnoseError`] when a model cannot be assembled.
    pub fn widened(
        &self,
        null: &Standing,
        score: f64,
    ) -> Result<Option<(Self, Standing)>, DiagnoseError> {
        let covariance = null.candidate.fit.covariance()?;
        let own = self.model.layout.machine.mesh();
        let sd = &self.model.layout.sd;
        let known = (0..own).filter(|k| covariance[(*k, *k)] < KNOWN * sd[*k].powi(2));
        let known = known.count() as f64;
        let mut best: Option<(Self, Standing)> = None;
        let mut lowest = score;
        for width in WIDTHS {
            let mut wide = self.with(self.measurement.clone())?;
            let own_sd = &mut wide.model.layout.sd[..own];
            own_sd.iter_mut().for_each(|sd| *sd *= width);
            let (standing, complete) = wide.stands(Subset::ALL)?;
            let own_score = standing.candidate.score() + 2.0 * known * width.ln();
            if complete && own_score < lowest {
                lowest = own_score;
                best = Some((wide, standing));
            }
        }
        Ok(best)
    }
}
