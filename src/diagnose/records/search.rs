//! Which mistakes of the rig explain records that the machine alone does not.
//!
//! Where the machine alone fails, every suspect is fitted with the nuisance parameters on thinned lines, at model
//! errors that are lowered until it fails, as effects are. The one that brings the data nearest is kept, and the search
//! goes on without it until the records are explained; only then are its numbers fitted to all lines. Where nothing
//! fails, a score test on all lines tells which suspect is worth a fit.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::data::measurement::RecordId;
use super::super::decide::candidate::{FAILING_CHI2, HOPELESS_CHI2, MODEL_ERRORS, Standing};
use super::super::decide::judgement::{Overall, further, overall};
use super::super::decide::screening::FIRST_EFFECT_BIC_GAIN;
use super::super::fit::estimate::FINAL_MODEL_ERROR;
use super::super::fit::prediction::Linear;
use super::super::fit::problem::Problem;
use super::super::fit::record_number::{Numbered, RecordNumber};
use super::clipped::{beyond, clippings};
use super::finding::{Alternatives, FoundFault};
use super::folded::list_folded;
use super::suspect::{Family, Suspect, suspects};
use super::trial::Trial;
use crate::identify::plausibility::RecordFault;
use crate::identify::plausibility::correction::largest;
use crate::lti::HeldResponse;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Most faults that are named together.
const MOST: usize = 4;
/// Lines of a fit that ranks, at least every third: faults act on all lines alike.
const LINES: usize = 60;
/// Iterations at each model error.
const ITERATIONS: usize = 3;
/// Model errors at which all starts are fitted.
const FIRST: usize = 2;
/// Model errors of the fit to all lines: from where the thinned fit has ended.
const LAST: [f64; 2] = [1e-3, FINAL_MODEL_ERROR];
/// Faults whose records are fitted again without them.
const FINALISTS: usize = 2;

/// A measurement without the faults that were found.
pub(crate) struct Explained<'a> {
    pub faults: Vec<FoundFault>,
    /// What remains.
    pub trial: Trial<'a>,
    /// Its fit without effects.
    pub null: Standing,
    /// Whether nothing significant is left.
    pub complete: bool,
}

/// The faults that bring the records nearest to the machine, one after the other; none where no fault does. Faults that
/// do not explain all are those of thinned lines.
pub(crate) fn explain_records<'a>(
    trial: &Trial<'a>,
    null: &Standing,
    explained_by_nothing: bool,
    alternatives: &Alternatives<'a>,
) -> Result<Option<Explained<'a>>, DiagnoseError> {
    if explained_by_nothing {
        return find_hidden(trial, null);
    }
    let stride = (trial.evidence.lines() / LINES).max(3);
    let thin = trial.observing(trial.evidence.thin_lines(stride));
    let (standing, complete) = thin.stands(Subset::ALL)?;
    let mut here = Explained { faults: vec![], trial: thin, null: standing, complete };
    for _ in 0..MOST {
        let Some(next) = next(&here, alternatives)? else {
            break;
        };
        here = next;
        if here.complete {
            break;
        }
    }
    if here.faults.is_empty() {
        return reconcile_records(trial);
    }
    // What thinned lines refute is worth all of them only where nothing else explains the records.
    Ok(Some(if here.complete { on_all_lines(trial, &here, alternatives)? } else { here }))
}

/// Gap of a machine without effects.
fn gap(trial: &Trial, standing: &Standing) -> Result<Overall, DiagnoseError> {
    overall(&trial.case(&[], &|_| {}), &[], &standing.candidate.fit.at)
}

/// A fault that a smooth model error or the nuisance parameters have taken up: what is more likely a mistake of one
/// number than an error of every channel.
fn find_hidden<'a>(trial: &Trial<'a>, null: &Standing) -> Result<Option<Explained<'a>>, DiagnoseError> {
    let free = (null.candidate.fit.residuals.max(2) as f64).ln();
    let needed = free + FIRST_EFFECT_BIC_GAIN;
    let from = |s: &Suspect| Numbered {
        number: s.present(&trial.measurement),
        at: null.candidate.fit.at.clone(),
        chi2: f64::INFINITY,
        failure: f64::INFINITY,
        model_error: FINAL_MODEL_ERROR,
    };
    let mut tried: Vec<Suspect> = vec![];
    for s in suspects(&trial.machine, &trial.evidence, &trial.measurement) {
        let twin = |w: &Suspect| w.record == s.record && w.family == s.family;
        if !tried.iter().any(twin) {
            tried.push(s);
        }
    }
    let records: Vec<RecordId> = trial.measurement.records().collect();
    let alone = records.par_iter().map(|record| {
        let (alone, _) = trial.evidence.apart(*record);
        let problem = Problem { model: &trial.model, evidence: &alone, usage: Subset::ALL, effects: &[] };
        problem.linear(&null.candidate.fit.at, FINAL_MODEL_ERROR)
    });
    let alone: Vec<Linear> = alone.collect::<Result<_, _>>()?;
    let fall = |s: &Suspect| {
        let both = || records.iter().zip(&alone);
        let own = both().find(|(record, _)| **record == s.record);
        let others = both().filter(|(record, _)| **record != s.record);
        let others: Vec<&Linear> = others.map(|(_, linear)| linear).collect();
        let Some((_, own)) = own else {
            return Ok((*s, 0.0));
        };
        let fall = with_number(trial, s, |n| n.predicted_fall(&from(s), FINAL_MODEL_ERROR, (own, &others)))?;
        Ok((*s, fall))
    };
    let worth = tried.par_iter().map(fall);
    let mut worth: Vec<(Suspect, f64)> = worth.collect::<Result<_, DiagnoseError>>()?;
    worth.retain(|w| w.1 > needed);
    worth.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut best: Option<Explained<'a>> = None;
    for (s, _) in worth.iter().take(FINALISTS) {
        let fit = lower_gap(trial, s, &from(s), &[FINAL_MODEL_ERROR])?;
        if !s.matters(fit.number, &trial.measurement) {
            continue;
        }
        let fault = s.to_fault(fit.number);
        let measurement = trial.measurement.clone().correct_record(s.record, fault);
        let found = explanation(trial.with(measurement)?, vec![(s.record, fault, None)])?;
        let score = found.null.candidate.score();
        let lowest = best.as_ref().map(|b| b.null.candidate.score());
        let gaps = (gap(trial, null)?, gap(&found.trial, &found.null)?);
        let enough = score < null.candidate.score() - needed && further(gaps.0, gaps.1, 1);
        if found.complete && enough && lowest.is_none_or(|lowest| score < lowest) {
            best = Some(found);
        }
    }
    Ok(best)
}

/// The same faults with all lines, their numbers fitted again.
pub(crate) fn on_all_lines<'a>(
    trial: &Trial<'a>,
    thin: &Explained<'a>,
    alternatives: &Alternatives<'a>,
) -> Result<Explained<'a>, DiagnoseError> {
    let tool = thin.faults.iter().find(|f| f.fault == RecordFault::Tool);
    let tool = tool.and_then(|f| alternatives.tools.iter().find(|t| Some(&t.0) == f.name.as_ref()));
    let mut full = match tool {
        Some((_, machine)) => Trial::new(machine, trial.measurement.clone())?,
        None => trial.observing(trial.evidence.clone()),
    };
    let mut faults = vec![];
    for found in &thin.faults {
        let mut fault = found.fault;
        let mut measurement = full.measurement.clone();
        if let (RecordFault::Controller, RecordId::Hammer(t)) = (fault, found.record) {
            let mut all = alternatives.controllers.iter();
            if let Some((_, k)) = all.find(|(name, _)| Some(name) == found.name.as_ref()) {
                measurement.taps[t].controller = *k;
            }
        } else if let Some(s) = Suspect::of(found.record, fault) {
            let from = Numbered {
                number: s.start,
                at: thin.null.candidate.fit.at.clone(),
                chi2: f64::INFINITY,
                failure: f64::INFINITY,
                model_error: LAST[0],
            };
            fault = s.to_fault(lower_gap(&full, &s, &from, &LAST)?.number);
            measurement = measurement.correct_record(found.record, fault);
        } else if let RecordFault::Clipping { .. } = fault {
            measurement = measurement.correct_record(found.record, fault);
        }
        full = full.with(measurement)?;
        faults.push((found.record, fault, found.name.clone()));
    }
    let closed = explanation(full, faults.clone())?;
    if closed.complete {
        return Ok(closed);
    }
    // On all lines a machine that is a little off may stay further away with closed loops than with open ones.
    let mut open = closed.trial.observing(closed.trial.evidence.clone());
    open.model.levitation = None;
    let found = explanation(open, faults)?;
    Ok(if found.complete { found } else { closed })
}

/// The fault that brings the records nearest.
fn next<'a>(here: &Explained<'a>, alternatives: &Alternatives<'a>) -> Result<Option<Explained<'a>>, DiagnoseError> {
    let mut all = with_numbers(here)?;
    all.extend(with_names(here, alternatives)?);
    all.extend(with_limits(here)?);
    let rank = |e: &Explained| (e.null.working_error, e.null.failure);
    all.retain(|e| e.complete || e.null.nearer_than(&here.null));
    all.sort_by(|a, b| {
        let ((a, x), (b, y)) = (rank(a), rank(b));
        a.total_cmp(&b).then(x.total_cmp(&y))
    });
    Ok(all.into_iter().next().map(|mut next| {
        next.faults.splice(0..0, here.faults.iter().cloned());
        next
    }))
}

/// Faults that have a number.
fn with_numbers<'a>(here: &Explained<'a>) -> Result<Vec<Explained<'a>>, DiagnoseError> {
    let (trial, standing) = (&here.trial, &here.null);
    let known = |s: &&Suspect| {
        let name = s.to_fault(s.start).name();
        let same = |k: &FoundFault| k.record == s.record && k.fault.name() == name;
        !here.faults.iter().any(same)
    };
    let mut all = suspects(&trial.machine, &trial.evidence, &trial.measurement);
    all.extend(list_folded(trial)?);
    let free: Vec<Suspect> = all.iter().filter(known).copied().collect();
    let origin = |s: &Suspect| Numbered {
        number: s.start,
        at: trial.case(&[], &|_| {}).origin(),
        chi2: f64::INFINITY,
        failure: f64::INFINITY,
        model_error: MODEL_ERRORS[0],
    };
    let started: Vec<(Suspect, Numbered)> = free
        .par_iter()
        .filter_map(|s| {
            let fit = lower_gap(trial, s, &origin(s), &MODEL_ERRORS[..FIRST]);
            Some((*s, fit.ok()?))
        })
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
    let mut ahead: Vec<(Suspect, Numbered)> = best
        .par_iter()
        .filter_map(|(s, fit)| Some((*s, lower_gap(trial, s, fit, &MODEL_ERRORS[FIRST - 1..]).ok()?)))
        .filter(|(s, fit)| s.matters(fit.number, &trial.measurement))
        .filter(|(_, fit)| {
            fit.failure < FAILING_CHI2
                || fit.model_error < standing.working_error
                || fit.model_error == standing.working_error && fit.failure < 0.8 * standing.failure
        })
        .collect();
    ahead.sort_by(|a, b| {
        let by_error = a.1.model_error.total_cmp(&b.1.model_error);
        by_error.then(a.1.failure.total_cmp(&b.1.failure))
    });
    let finalists = ahead.iter().take(FINALISTS).map(|(s, fit)| {
        let fault = s.to_fault(fit.number);
        let controller = trial.controller(s.record);
        let evidence = trial.evidence.correct_record(s.record, fault, controller);
        explanation(trial.observing(evidence), vec![(s.record, fault, None)])
    });
    finalists.collect()
}

/// Sweeps without the lines that reach a limit; only where that explains everything.
fn with_limits<'a>(here: &Explained<'a>) -> Result<Vec<Explained<'a>>, DiagnoseError> {
    let trial = &here.trial;
    let mut all = vec![];
    for (s, record) in trial.measurement.sweeps.iter().enumerate() {
        for (signal, limits) in clippings(&trial.measurement, s) {
            // The lowest limit comes first: where that does not help, no higher one does.
            let mut highest = None;
            for limit in limits {
                let kept = |k: usize| largest(record, signal, k) < limit;
                let lines = record.frequency_hz.len();
                let evidence = trial.evidence.with_lines(s, lines, kept);
                let fault = RecordFault::Clipping { limit, signal };
                let named = vec![(RecordId::Sweep(s), fault, None)];
                let found = explanation(trial.observing(evidence), named)?;
                if !found.complete || !beyond(trial, s, signal, limit, &found.null)? {
                    break;
                }
                highest = Some(found);
            }
            if highest.is_some() {
                all.extend(highest);
                break;
            }
        }
    }
    Ok(all)
}

/// Does something with a suspect whose number is free.
fn with_number<T>(trial: &Trial, suspect: &Suspect, of: impl FnOnce(&RecordNumber) -> T) -> T {
    let (alone, rest) = trial.evidence.apart(suspect.record);
    let controller = trial.controller(suspect.record);
    let own = |number: f64| alone.correct_record(suspect.record, suspect.to_fault(number), controller);
    of(&RecordNumber {
        model: &trial.model,
        rest: &rest,
        own: &own,
        usage: Subset::ALL,
        difference: suspect.difference(),
        longest: suspect.longest(),
    })
}

/// Fits a suspect at decreasing model errors until it fails at one beyond the first few, or by far at the last of
/// those.
fn lower_gap(trial: &Trial, suspect: &Suspect, from: &Numbered, errors: &[f64]) -> Result<Numbered, DiagnoseError> {
    with_number(trial, suspect, |numbered| {
        let mut fit = from.clone();
        for error in errors {
            let iterations = if *error == FINAL_MODEL_ERROR { 2 * ITERATIONS } else { ITERATIONS };
            fit = numbered.fit(&fit, *error, iterations)?;
            let limit = match error.total_cmp(&MODEL_ERRORS[FIRST - 1]) {
                Ordering::Less => FAILING_CHI2,
                Ordering::Equal => HOPELESS_CHI2,
                Ordering::Greater => f64::INFINITY,
            };
            if fit.failure > limit {
                break;
            }
        }
        Ok(fit)
    })
}

/// A record that disagrees with all others, which the machine explains: with one number of its own, fitted from where
/// the others stand. Of two records either clock may be the wrong one.
fn reconcile_records<'a>(trial: &Trial<'a>) -> Result<Option<Explained<'a>>, DiagnoseError> {
    let all: Vec<RecordId> = trial.measurement.records().collect();
    let mut best: Option<Explained<'a>> = None;
    for record in all.iter().copied() {
        let (_, rest) = trial.evidence.apart(record);
        if rest.sweeps.iter().all(|s| s.omega_rad_s.is_empty()) {
            continue;
        }
        let (others, complete) = trial.observing(rest).stands(Subset::ALL)?;
        if !complete {
            continue;
        }
        let own = suspects(&trial.machine, &trial.evidence, &trial.measurement).into_iter();
        for s in own.filter(|s| s.record == record) {
            let from = Numbered {
                number: s.start,
                at: others.candidate.fit.at.clone(),
                chi2: f64::INFINITY,
                failure: f64::INFINITY,
                model_error: MODEL_ERRORS[0],
            };
            let number = lower_gap(trial, &s, &from, &MODEL_ERRORS)?.number;
            if !s.matters(number, &trial.measurement) {
                continue;
            }
            let mut tried = vec![(record, s.to_fault(number))];
            if s.family == Family::Clock && all.len() == 2 {
                let other = all.iter().filter(|r| **r != record);
                tried.extend(other.map(|r| (*r, s.to_fault(-number))));
            }
            for (record, fault) in tried {
                let measurement = trial.measurement.clone().correct_record(record, fault);
                let found = explanation(trial.with(measurement)?, vec![(record, fault, None)])?;
                let score = |e: &Explained| e.null.candidate.score();
                let lowest = best.as_ref().map(score);
                if found.complete && lowest.is_none_or(|lowest| score(&found) < lowest) {
                    best = Some(found);
                }
            }
        }
    }
    Ok(best)
}

/// Other tools and other controllers.
fn with_names<'a>(here: &Explained<'a>, alternatives: &Alternatives<'a>) -> Result<Vec<Explained<'a>>, DiagnoseError> {
    let (trial, standing) = (&here.trial, &here.null);
    let mut all = vec![];
    let tried = |fault: RecordFault, record: RecordId| {
        let same = |k: &FoundFault| k.fault == fault && k.record == record;
        here.faults.iter().any(same)
    };
    let records: Vec<RecordId> = trial.measurement.records().collect();
    let tools = alternatives.tools.par_iter().filter_map(|(name, machine)| {
        let other = trial.of_machine(machine).ok()?;
        let reached = other.reaches(standing.working_error).ok()?;
        reached.nearer_than(standing).then_some((name, other, reached))
    });
    if !records.iter().any(|r| tried(RecordFault::Tool, *r)) {
        let mut nearer: Vec<(&String, Trial, Standing)> = tools.collect();
        nearer.sort_by(|a, b| {
            let by_error = a.2.working_error.total_cmp(&b.2.working_error);
            by_error.then(a.2.failure.total_cmp(&b.2.failure))
        });
        if let Some((name, other, _)) = nearer.into_iter().next() {
            let each = records.iter().map(|r| (*r, RecordFault::Tool, Some(name.clone())));
            all.push(explanation(other, each.collect())?);
        }
    }
    for (t, _) in trial.measurement.taps.iter().enumerate() {
        let record = RecordId::Hammer(t);
        if tried(RecordFault::Controller, record) {
            continue;
        }
        for (name, controller) in &alternatives.controllers {
            let mut other = trial.under(t, *controller);
            let own: Option<&dyn HeldResponse> = Some(*controller);
            other.evidence = other.evidence.correct_record(record, RecordFault::Controller, own);
            if other.reaches(standing.working_error)?.nearer_than(standing) {
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
    let faults = faults.into_iter().map(|(record, fault, name)| FoundFault { record, fault, name });
    Ok(Explained { faults: faults.collect(), trial, null, complete })
}
