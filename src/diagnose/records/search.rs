//! Which mistakes of the rig explain records that the machine alone does not.
//!
//! Every suspect is fitted with the nuisance parameters, at model errors that are lowered until it fails, as effects
//! are. The one that brings the data nearest is kept, and the search goes on without it until the records are explained.

use super::super::DiagnoseError;
use super::super::data::common_error::USUAL;
use super::super::data::evidence::{Evidence, Subset};
use super::super::data::measurement::{Measurement, RecordId};
use super::super::decide::candidate::{FAILING_CHI2, MODEL_ERRORS, Standing};
use super::super::decide::screening::FIRST_EFFECT_BIC_GAIN;
use super::super::fit::estimate::FINAL_MODEL_ERROR;
use super::super::fit::problem::Point;
use super::super::fit::record_number::{Numbered, RecordNumber};
use super::finding::{Alternatives, FoundFault};
use super::suspect::{Suspect, suspects};
use super::trial::Trial;
use crate::identify::plausibility::RecordFault;
use rayon::prelude::*;

/// Most faults that are named together.
const MOST: usize = 4;
/// Lines of a fit that ranks, at least a third of them: faults act on all lines alike.
const LINES: usize = 80;
/// Iterations at each model error.
const ITERATIONS: usize = 3;
/// Model errors at which all starts are fitted.
const FIRST: usize = 2;
/// Faults that are fitted to all lines.
const FINALISTS: usize = 2;

/// A measurement without the faults that were found.
pub struct Explained<'a> {
    /// The faults.
    pub faults: Vec<FoundFault>,
    /// What remains.
    pub trial: Trial<'a>,
    /// Its fit without effects.
    pub null: Standing,
    /// Whether nothing significant is left.
    pub complete: bool,
}

/// The lines of a fit that ranks.
fn thin(trial: &Trial) -> Subset {
    let lines = trial.evidence.sweeps.iter().map(|s| s.omega_rad_s.len());
    Subset {
        stride: (lines.max().unwrap_or_default() / LINES).max(3),
        ..Subset::ALL
    }
}

/// The faults that bring the records nearest to the machine, one after the other; none where no fault does.
///
/// # Errors
/// [`DiagnoseError`] for records or machines that cannot be used.
pub fn explained<'a>(
    trial: &Trial<'a>,
    null: &Standing,
    alternatives: &Alternatives<'a>,
) -> Result<Option<Explained<'a>>, DiagnoseError> {
    let mut found: Option<Explained<'a>> = None;
    for _ in 0..MOST {
        let (here, standing) = match &found {
            Some(found) => (&found.trial, &found.null),
            None => (trial, null),
        };
        let known = found.as_ref().map_or(&[][..], |f| &f.faults);
        let Some(mut next) = next(here, standing, known, alternatives)? else {
            break;
        };
        if let Some(found) = found {
            next.faults.splice(0..0, found.faults);
        }
        let complete = next.complete;
        found = Some(next);
        if complete {
            break;
        }
    }
    Ok(found)
}

/// The fault that brings the records nearest.
fn next<'a>(
    trial: &Trial<'a>,
    standing: &Standing,
    known: &[FoundFault],
    alternatives: &Alternatives<'a>,
) -> Result<Option<Explained<'a>>, DiagnoseError> {
    let mut all = with_numbers(trial, standing, known)?;
    all.extend(with_names(trial, standing, known, alternatives)?);
    let rank = |e: &Explained| (e.null.working_error, e.null.failure);
    // What explains the records is enough: a smooth model error may have taken up much of a fault before.
    let free = (standing.candidate.fit.residuals.max(2) as f64).ln();
    let needed = standing.candidate.score() - free - FIRST_EFFECT_BIC_GAIN;
    all.retain(|e| match standing.working_error == FINAL_MODEL_ERROR {
        true => e.complete && e.null.candidate.score() < needed,
        false => e.complete || e.null.nearer_than(standing),
    });
    all.sort_by(|a, b| {
        let ((a, x), (b, y)) = (rank(a), rank(b));
        a.total_cmp(&b).then(x.total_cmp(&y))
    });
    Ok(all.into_iter().next())
}

/// Faults that have a number.
fn with_numbers<'a>(
    trial: &Trial<'a>,
    standing: &Standing,
    known: &[FoundFault],
) -> Result<Vec<Explained<'a>>, DiagnoseError> {
    let free: Vec<Suspect> = suspects(&trial.machine, &trial.evidence, &trial.measurement)
        .into_iter()
        .filter(|s| {
            let name = s.fault(s.start).name();
            !known
                .iter()
                .any(|k| k.record == s.record && k.fault.name() == name)
        })
        .collect();
    let started: Vec<(Suspect, Numbered)> = free
        .par_iter()
        .filter_map(|s| Some((*s, fitted(trial, s, None, thin(trial)).ok()?)))
        .collect();
    // The best start of every fault.
    let mut best: Vec<(Suspect, Numbered)> = vec![];
    for (s, fit) in started {
        let same = |b: &&mut (Suspect, Numbered)| b.0.record == s.record && b.0.family == s.family;
        match best.iter_mut().find(same) {
            Some(b) if fit.chi2 < b.1.chi2 => *b = (s, fit),
            Some(_) => {}
            None => best.push((s, fit)),
        }
    }
    let mut lowered: Vec<(Suspect, Numbered)> = best
        .par_iter()
        .filter_map(|(s, fit)| Some((*s, fitted(trial, s, Some(fit), thin(trial)).ok()?)))
        .filter(|(s, fit)| s.matters(fit.number, &trial.measurement))
        .filter(|(_, fit)| {
            fit.failure < FAILING_CHI2
                || fit.model_error < standing.working_error
                || fit.model_error == standing.working_error && fit.failure < 0.8 * standing.failure
        })
        .collect();
    lowered.sort_by(|a, b| {
        let by_error = a.1.model_error.total_cmp(&b.1.model_error);
        by_error.then(a.1.failure.total_cmp(&b.1.failure))
    });
    let finalists = lowered.iter().take(FINALISTS).map(|(s, fit)| {
        let fit = fitted(trial, s, Some(fit), Subset::ALL)?;
        let fault = s.fault(fit.number);
        let measurement = trial.measurement.clone().corrected(s.record, fault);
        explanation(trial.with(measurement)?, vec![(s.record, fault, None)])
    });
    finalists.collect()
}

/// Fits a suspect: all starts at the first model errors, then down to where it fails.
fn fitted(
    trial: &Trial,
    suspect: &Suspect,
    from: Option<&Numbered>,
    usage: Subset,
) -> Result<Numbered, DiagnoseError> {
    let measurement = &trial.measurement;
    let rest = Evidence::of(&measurement.without(suspect.record))?;
    let alone = measurement.only(suspect.record);
    let own = |number: f64| {
        let alone = alone.clone();
        let only = match suspect.record {
            RecordId::Sweep(_) => RecordId::Sweep(0),
            RecordId::Hammer(_) => RecordId::Hammer(0),
        };
        Evidence::of(&alone.corrected(only, suspect.fault(number)))
    };
    let numbered = RecordNumber {
        model: &trial.model,
        rest: &rest,
        own: &own,
        usage,
        difference: suspect.difference(),
        longest: suspect.longest(),
    };
    let origin = Numbered {
        number: suspect.start,
        at: Point {
            p: vec![0.0; trial.model.layout.len()],
            theta: vec![],
            smooth: USUAL,
        },
        chi2: f64::INFINITY,
        failure: f64::INFINITY,
        model_error: MODEL_ERRORS[0],
    };
    let first = from.is_none();
    let mut fit = from.cloned().unwrap_or(origin);
    let errors = MODEL_ERRORS.into_iter().filter(|e| match first {
        true => *e >= MODEL_ERRORS[FIRST - 1],
        false => *e <= fit.model_error,
    });
    for error in errors.collect::<Vec<_>>() {
        let iterations = if error == FINAL_MODEL_ERROR {
            2 * ITERATIONS
        } else {
            ITERATIONS
        };
        fit = numbered.fit(&fit, error, iterations)?;
        if !first && fit.failure > FAILING_CHI2 {
            break;
        }
    }
    Ok(fit)
}

/// Other tools and other controllers.
fn with_names<'a>(
    trial: &Trial<'a>,
    standing: &Standing,
    known: &[FoundFault],
    alternatives: &Alternatives<'a>,
) -> Result<Vec<Explained<'a>>, DiagnoseError> {
    let mut all = vec![];
    let tried = |fault: RecordFault, record: RecordId| {
        known.iter().any(|k| k.fault == fault && k.record == record)
    };
    let records: Vec<RecordId> = trial.measurement.records().collect();
    let tools = alternatives.tools.par_iter().filter_map(|(name, machine)| {
        let other = Trial::new(machine, trial.measurement.clone()).ok()?;
        let (thin, _) = other.stands(thin(trial)).ok()?;
        thin.nearer_than(standing).then_some((name, other, thin))
    });
    if !records.iter().any(|r| tried(RecordFault::Tool, *r)) {
        let mut nearer: Vec<(&String, Trial, Standing)> = tools.collect();
        nearer.sort_by(|a, b| {
            let by_error = a.2.working_error.total_cmp(&b.2.working_error);
            by_error.then(a.2.failure.total_cmp(&b.2.failure))
        });
        if let Some((name, other, _)) = nearer.into_iter().next() {
            let each = records
                .iter()
                .map(|r| (*r, RecordFault::Tool, Some(name.clone())));
            all.push(explanation(other, each.collect())?);
        }
    }
    for (t, _) in trial.measurement.taps.iter().enumerate() {
        let record = RecordId::Hammer(t);
        if tried(RecordFault::Controller, record) {
            continue;
        }
        for (name, controller) in &alternatives.controllers {
            let mut measurement: Measurement<'a> = trial.measurement.clone();
            measurement.taps[t].controller = *controller;
            let other = trial.with(measurement)?;
            if other.stands(thin(trial))?.0.nearer_than(standing) {
                let fault = (record, RecordFault::Controller, Some(name.clone()));
                all.push(explanation(other, vec![fault])?);
            }
        }
    }
    Ok(all)
}

type Named = (RecordId, RecordFault, Option<String>);

fn explanation<'a>(trial: Trial<'a>, faults: Vec<Named>) -> Result<Explained<'a>, DiagnoseError> {
    let (null, complete) = trial.stands(Subset::ALL)?;
    let faults = faults.into_iter().map(|(record, fault, name)| FoundFault {
        record,
        fault,
        name,
    });
    Ok(Explained {
        faults: faults.collect(),
        trial,
        null,
        complete,
    })
}
