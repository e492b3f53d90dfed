//! Lines that a logger without a filter has folded: which sample rate would bring them near the machine.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::data::measurement::RecordId;
use super::super::decide::candidate::MODEL_ERRORS;
use super::suspect::{Family, Suspect};
use super::trial::Trial;
use crate::identify::plausibility::RecordFault;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Sample rates that are tried, as a multiple of the highest line: from where all lines but the lowest are folded to
/// where hardly one is.
const RATES: (f64, f64) = (1.02, 1.9);
/// Relative step between them: below the width that a coarse model error gives every resonance.
const STEP: f64 = 0.01;
/// Share of χ² that a sample rate may leave to be worth a fit.
const LEAVES: f64 = 0.5;

/// For every sweep the sample rate that brings its lines nearest to the machine as it is, if folding them brings them
/// much nearer.
pub(crate) fn list_folded(trial: &Trial) -> Result<Vec<Suspect>, DiagnoseError> {
    let case = trial.case(&[], &|_| {});
    let mut found = vec![];
    for (s, sweep) in trial.evidence.sweeps.iter().enumerate() {
        let Some(top) = sweep.omega_rad_s.iter().copied().reduce(f64::max) else {
            continue;
        };
        let record = RecordId::Sweep(s);
        let (alone, _) = trial.evidence.apart(record);
        let chi2 = |rate: Option<f64>| {
            let evidence = match rate {
                Some(sample_rate_hz) => alone.correct_record(record, RecordFault::Alias { sample_rate_hz }, None),
                None => alone.clone(),
            };
            let mut own = case.problem(&[], Subset::ALL);
            own.evidence = &evidence;
            own.chi2(&case.origin(), MODEL_ERRORS[0])
        };
        let steps = ((RATES.1 / RATES.0).ln() / STEP) as i32;
        let rates = (0..=steps).map(|k| RATES.0 * (STEP * f64::from(k)).exp() * top / TAU);
        let rates: Vec<f64> = rates.collect();
        let each: Result<Vec<(f64, f64)>, DiagnoseError> =
            rates.par_iter().map(|rate| Ok((chi2(Some(*rate))?, *rate))).collect();
        let least = each?.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((value, rate)) = least
            && value < LEAVES * chi2(None)?
        {
            found.push(Suspect { record, family: Family::Alias, start: rate.ln() });
        }
    }
    Ok(found)
}
