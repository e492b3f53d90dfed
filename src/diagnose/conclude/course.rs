//! The course of a diagnosis: mistakes of the rig first, then effects, then what remains when neither explains the
//! records.
//!
//! A mistake that explains the records is compared with single effects, as far as one of them comes near: another tool
//! looks like a mass at the tip. Where the data do not tell them apart, both stand in a tie.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::data::measurement::{RecordId, RecordSet};
use super::super::decide::candidate::{Candidate, Standing};
use super::super::decide::judgement::Verdict;
use super::super::decide::residuals::Record;
use super::super::decide::screening::{ScreeningRound, TIE_BIC, explains};
use super::super::decide::selection::MOST_EFFECTS;
use super::super::fit::estimate::FINAL_MODEL_ERROR;
use super::super::fit::levitated_line::LEVITATED_FROM;
use super::super::fit::problem::Point;
use super::super::locate::localisation::Localisation;
use super::super::records::finding::{Alternatives, FoundFault};
use super::super::records::gross::without_gross_faults;
use super::super::records::search::{Explained, explain_records, on_all_lines};
use super::super::records::trial::{Trial, Widened};
use super::unsearched::{conclude_located, conclude_single, conclude_small};
use super::verdict::{Diagnosis, Instead, Rival, conclude, conclude_unless, hypotheses};
use crate::identify::frf::AXES;
use crate::identify::open_loop;
use crate::identify::plausibility::RecordFault;
use crate::identify::polluted::{self, PollutedLines};
use crate::spindle::{Effect, Machine};
use std::cell::OnceCell;

/// Diagnoses a machine; `progress` is told what is being done.
///
/// # Errors
/// [`DiagnoseError`] for records or machines that cannot be used.
pub fn diagnose(
    machine: &Machine,
    measurement: &RecordSet,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    diagnose_with(machine, measurement, &Alternatives::default(), progress)
}

/// Diagnoses a machine that may have held another tool, or run under another controller, than the records name.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_with(
    machine: &Machine,
    measurement: &RecordSet,
    alternatives: &Alternatives,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    let (mut polluted_lines, measurement) = without_polluted_lines(measurement)?;
    let mut found = diagnose_quiet_lines(machine, &measurement, alternatives, progress)?;
    let (hum, quiet) = match found.verdict {
        Verdict::Unexplained => without_steady_hum(&measurement, &found),
        _ => (vec![], measurement),
    };
    if !hum.is_empty() {
        progress("without hum of the mains");
        let again = diagnose_quiet_lines(machine, &quiet, alternatives, progress)?;
        if again.verdict != Verdict::Unexplained {
            found = again;
            polluted_lines.extend(hum);
        }
    }
    Ok(Diagnosis { polluted_lines, ..found })
}

/// The hum that leaves the model of a diagnosis, and the measurement without it.
fn without_steady_hum<'a>(measurement: &RecordSet<'a>, found: &Diagnosis) -> (Vec<PollutedLines>, RecordSet<'a>) {
    let (mut hum, mut quiet) = (vec![], measurement.clone());
    let channels: Vec<_> = found.channels.iter().filter(|c| matches!(c.record, Record::Sweep(..))).collect();
    for (sweep, (record, own)) in measurement.sweeps.iter().zip(channels.chunks(AXES * AXES)).enumerate() {
        let residuals: Vec<Vec<f64>> = own.iter().map(|channel| channel.residual().1).collect();
        let lines = own.first().map_or(0, |channel| channel.omega_rad_s.len());
        let mean = |line: usize| residuals.iter().map(|r| r[line].powi(2)).sum::<f64>() / residuals.len() as f64;
        let misfit: Vec<f64> = (0..lines).map(mean).collect();
        if let Some((polluted, without)) = polluted::without_steady_hum(sweep, record, &misfit) {
            hum.push(polluted);
            quiet.sweeps[sweep] = without;
        }
    }
    (hum, quiet)
}

/// The measurement without the lines that something outside the loop disturbs, and these.
fn without_polluted_lines<'a>(
    measurement: &RecordSet<'a>,
) -> Result<(Vec<PollutedLines>, RecordSet<'a>), DiagnoseError> {
    let (mut polluted, mut quiet) = (vec![], measurement.clone());
    for (sweep, record) in measurement.sweeps.iter().enumerate() {
        let (own, without) = polluted::without_polluted_lines(sweep, record, &open_loop(record)?);
        polluted.extend(own);
        quiet.sweeps[sweep] = without;
    }
    Ok((polluted, quiet))
}

/// [`diagnose_with`] for records without disturbed lines.
fn diagnose_quiet_lines(
    machine: &Machine,
    measurement: &RecordSet,
    alternatives: &Alternatives,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    let (gross, corrected) = without_gross_faults(machine, measurement)?;
    progress("the machine as it is");
    let corrected = Begun::new(machine, corrected)?;
    if gross.is_empty() || corrected.complete {
        return course(corrected, gross, alternatives, progress);
    }
    // What looks like a gross mistake from afar may be a large effect: a soft joint lowers all resonances, as a wrong
    // clock does.
    progress("the records as they are");
    let Ok(recorded) = Begun::new(machine, measurement.clone()) else {
        // With the mistake in them, records need not be usable.
        return course(corrected, gross, alternatives, progress);
    };
    let (first, second) = match recorded.one_effect(progress)? {
        Some(_) => ((recorded, vec![]), (corrected, gross)),
        None => ((corrected, gross), (recorded, vec![])),
    };
    let found = course(first.0, first.1, alternatives, progress)?;
    if found.verdict != Verdict::Unexplained {
        return Ok(found);
    }
    let other = course(second.0, second.1, alternatives, progress)?;
    Ok(match other.verdict {
        Verdict::Unexplained => found,
        _ => other,
    })
}

/// A machine with records, fitted without effects.
struct Begun<'a> {
    trial: Trial<'a>,
    null: Standing,
    /// Whether that leaves nothing significant.
    complete: bool,
}

impl<'a> Begun<'a> {
    fn new(machine: &Machine, measurement: RecordSet<'a>) -> Result<Self, DiagnoseError> {
        let trial = Trial::new(machine, measurement)?;
        let (null, complete) = trial.stands(Subset::ALL)?;
        Ok(Self { trial, null, complete })
    }

    /// The effect that explains the records alone, if one does.
    fn one_effect(&self, progress: &(dyn Fn(&str) + Sync)) -> Result<Option<Effect>, DiagnoseError> {
        let trial = &self.trial;
        let catalogue = hypotheses(&trial.machine, &trial.model, &trial.evidence)?;
        let case = trial.case(&catalogue, progress);
        let finalists = case.run_round(&self.null)?.finalists;
        let best = finalists.first().filter(|best| case.within(best));
        Ok(best.and_then(Candidate::newest))
    }

    /// The newest effect of the first of these sets that explains the records.
    fn first_of(&self, sets: &[Candidate]) -> Result<Option<Effect>, DiagnoseError> {
        let case = self.trial.case(&[], &|_| {});
        for set in sets {
            let from = Point { theta: set.fit.at.theta.clone(), ..case.origin() };
            // What some of the lines refute is not fitted to all of them.
            if !explains(&case.fit_down(&set.effects, &from, case.thin())?.candidate) {
                continue;
            }
            let stands = case.fit_down(&set.effects, &from, Subset::ALL)?;
            if case.within(&stands.candidate) {
                return Ok(stands.candidate.newest());
            }
        }
        Ok(None)
    }
}

/// Whether a diagnosis names effects that leave a gap below 1 on all records and on those held out.
fn explains_all(found: &Diagnosis) -> bool {
    let named = matches!(found.verdict, Verdict::Named | Verdict::Probable);
    named && found.gap_after <= 1.0 && found.gap_after_held_out <= 1.0
}

/// One effect on a machine that is further off than usual, of those that a free law reads off and, with `searches`, of
/// the catalogue, where it leaves a gap below 1 on all records and on those held out; with its score. The one with the
/// lowest.
fn one_effect_on_wide(
    widths: &[Widened],
    localisation: &Localisation,
    searches: bool,
    gross: &[FoundFault],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Option<(f64, Diagnosis)>, DiagnoseError> {
    progress("one effect on a machine that is further off than usual");
    let mut best: Option<(f64, Diagnosis)> = None;
    for wide in widths {
        let Widened { trial, null, cost, .. } = wide;
        let catalogue = hypotheses(&trial.machine, &trial.model, &trial.evidence)?;
        let case = trial.case(&catalogue, progress);
        let mut round =
            if searches { case.run_round(null)? } else { ScreeningRound { finalists: vec![], others: vec![] } };
        case.add_located(localisation, &mut round);
        let found = conclude_single(trial, &case, null, localisation, round, gross.to_vec())?;
        if let Some(found) = found.filter(explains_all) {
            let score = found.score + cost;
            if best.as_ref().is_none_or(|(lowest, _)| score < *lowest) {
                best = Some((score, found));
            }
        }
    }
    Ok(best)
}

/// The course of a diagnosis of records of which these gross mistakes are corrected.
fn course(
    begun: Begun,
    gross: Vec<FoundFault>,
    alternatives: &Alternatives,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    let Begun { trial, null, complete: explained_by_nothing } = begun;
    if !explained_by_nothing && let Some(small) = conclude_small(&trial, &null, &gross, progress)? {
        return Ok(small);
    }
    progress("mistakes of the rig");
    let mut faulty = explain_records(&trial, &null, explained_by_nothing, alternatives)?;
    if let Some(found) = faulty.take_if(|f| f.complete) {
        let faults = gross.iter().cloned().chain(found.faults.clone()).collect();
        let without = conclude(&found.trial, &found.null, (faults, MOST_EFFECTS), progress)?;
        if without.verdict != Verdict::Unexplained {
            return or_one_effect((&trial, &null), &found, (gross, without), progress);
        }
    }
    let widths = if explained_by_nothing { vec![] } else { trial.widen_tolerances(&null)? };
    let by_score = |a: &&Widened, b: &&Widened| a.score().total_cmp(&b.score());
    let wide = widths.iter().filter(|wide| wide.complete).min_by(by_score);
    // A machine that is off everywhere has one explanation; three effects and more would not be a simpler one.
    let most = if wide.is_some() { 2 } else { MOST_EFFECTS };
    let mut located = OnceCell::new();
    let elsewhere = |best: &[Candidate], localisation: &Localisation| {
        if explained_by_nothing || best.is_empty() {
            return Ok(Instead::Nothing);
        }
        if wide.is_none()
            && let Some(found) = one_effect_on_wide(&widths, localisation, false, &gross, progress)?
        {
            // A closure that is called once.
            located.set(found).ok();
            return Ok(Instead::Rival);
        }
        let both = effect_and_fault(&trial, &gross, alternatives, Some(best), progress)?;
        Ok(both.map_or(Instead::Nothing, |found| Instead::Found(Box::new(found))))
    };
    let plain = conclude_unless(&trial, &null, (gross.clone(), most), &elsewhere, progress)?;
    // One effect is simpler than a machine that is off everywhere.
    let many = plain.verdict == Verdict::Unexplained || plain.effects.len() > 1;
    if let Some(wide) = wide.filter(|w| many && w.score() < plain.score) {
        progress("a machine that is further off than usual");
        return conclude(&wide.trial, &wide.null, (gross, MOST_EFFECTS), progress);
    }
    // So is one effect on such a machine.
    if many && wide.is_none() {
        let probable = match located.take() {
            Some(found) => Some(found),
            None => one_effect_on_wide(&widths, &plain.localisation, true, &gross, progress)?,
        };
        if let Some((_, found)) = probable.filter(|(score, _)| *score < plain.score) {
            return Ok(found);
        }
    }
    if plain.verdict == Verdict::Unexplained
        && let Some(both) = effect_and_fault(&trial, &gross, alternatives, None, progress)?
    {
        return Ok(both);
    }
    // A free law at one place of the electronics explains what the catalogue does not: what is there is outside of it.
    let sole = plain.localisation.sole();
    let outside = sole.is_some_and(|place| !place.mechanical());
    if plain.verdict != Verdict::Unexplained || outside {
        return Ok(plain);
    }
    // From far away either comparison may miss what the other one finds; from nearby both are the same.
    if null.working_error >= LEVITATED_FROM && !plain.slope_read {
        let mut open = trial.observing(trial.evidence.clone());
        open.model.levitation = None;
        let (start, _) = open.stands(Subset::ALL)?;
        // Larger sets are left to the comparison of closed loops: this one repeats the whole search.
        let found = conclude(&open, &start, (gross.clone(), most.min(2)), progress)?;
        if found.verdict != Verdict::Unexplained {
            return Ok(found);
        }
    }
    if let Some(found) = faulty {
        let found = on_all_lines(&trial, &found, alternatives)?;
        if found.complete || found.null.nearer_than(&null) {
            let faults = gross.iter().cloned().chain(found.faults).collect();
            let both = conclude(&found.trial, &found.null, (faults, MOST_EFFECTS), progress)?;
            if both.verdict != Verdict::Unexplained {
                return Ok(both);
            }
        }
    }
    let rest = without_one_record(&trial, &plain, &gross, progress)?;
    Ok(rest.unwrap_or(plain))
}

/// The diagnosis of all records but one that contradicts them, where they agree with the machine, or with an effect
/// that a free law reads off.
fn without_one_record(
    trial: &Trial,
    plain: &Diagnosis,
    gross: &[FoundFault],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Option<Diagnosis>, DiagnoseError> {
    for record in trial.measurement.records() {
        let rest = trial.measurement.without(record);
        if rest.sweeps.is_empty() {
            continue;
        }
        let rest = Begun::new(&trial.machine, rest)?;
        let alone = FoundFault { record, fault: RecordFault::Disagrees, name: None };
        let faults = gross.iter().cloned().chain([alone]).collect();
        if rest.complete {
            return conclude(&rest.trial, &rest.null, (faults, MOST_EFFECTS), progress).map(Some);
        }
        if matches!(record, RecordId::Hammer(_))
            && let Some(found) = conclude_located(&rest.trial, &rest.null, &plain.localisation, faults, progress)?
        {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

/// An effect beside mistakes of the rig, where neither alone explains the records: one effect explains all records but
/// one, and with it a mistake of the rig explains them all. The effects tried are the newest ones of `best`, or
/// those of the catalogue.
fn effect_and_fault(
    trial: &Trial,
    gross: &[FoundFault],
    alternatives: &Alternatives,
    best: Option<&[Candidate]>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Option<Diagnosis>, DiagnoseError> {
    for record in trial.measurement.records() {
        let rest = trial.measurement.without(record);
        if rest.sweeps.is_empty() {
            continue;
        }
        progress("one effect in all records but one");
        let rest = Begun::new(&trial.machine, rest)?;
        let effect = match best {
            Some(best) => rest.first_of(best)?,
            None => rest.one_effect(progress)?,
        };
        let Some(effect) = effect else {
            continue;
        };
        progress("mistakes of the rig beside it");
        let with = trial.of_machine(&trial.machine.with_effect(effect))?;
        let (null, complete) = with.stands(Subset::ALL)?;
        let found = explain_records(&with, &null, complete, alternatives)?;
        let Some(found) = found.filter(|found| found.complete) else {
            continue;
        };
        // The machine of another tool is another machine.
        if found.faults.iter().any(|f| f.fault == RecordFault::Tool) {
            continue;
        }
        let right = trial.with(found.trial.measurement)?;
        let (null, _) = right.stands(Subset::ALL)?;
        let faults = gross.iter().cloned().chain(found.faults).collect();
        let both = conclude(&right, &null, (faults, MOST_EFFECTS), progress)?;
        if both.verdict != Verdict::Unexplained {
            return Ok(Some(both));
        }
    }
    Ok(None)
}

/// A diagnosis that names mistakes of the rig, or what one effect says in their place: the effect where it explains the
/// records better, both where the data do not tell.
fn or_one_effect(
    (trial, null): (&Trial, &Standing),
    found: &Explained,
    (gross, without): (Vec<FoundFault>, Diagnosis),
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    let residuals = |s: &Standing| s.candidate.fit.residuals;
    // A wrong speed says the same as a gyroscopic factor, which every rotor has at 1. Explanations of other data do not
    // compare.
    let speed = |f: &FoundFault| matches!(f.fault, RecordFault::SpeedLabel { .. });
    if found.faults.iter().any(speed) || residuals(null) != residuals(&found.null) {
        return Ok(without);
    }
    let Trial { machine, model, evidence, .. } = trial;
    progress("one effect in place of the mistake");
    let catalogue = hypotheses(machine, model, evidence)?;
    // A mistake is one number, or one choice, like an effect of one number.
    let mut names: Vec<&str> = found.faults.iter().map(|f| f.fault.name()).collect();
    names.dedup();
    let price = |residuals: usize| names.len() as f64 * (residuals.max(2) as f64).ln();
    let case = trial.case(&catalogue, progress);
    let Some(thinly) = case.one_effect_thinly(null)? else {
        return Ok(without);
    };
    let corrected = found.trial.case(&[], progress);
    let thin = corrected.problem(&[], corrected.thin());
    let thin = thin.fit(&found.null.candidate.fit.at, &[(FINAL_MODEL_ERROR, 4)])?;
    // All lines say more than some of them.
    if thinly > thin.chi2 + price(thin.residuals) + TIE_BIC {
        return Ok(without);
    }
    let one = conclude(trial, null, (gross, 1), progress)?;
    if one.effects.is_empty() {
        return Ok(without);
    }
    let above = one.score - without.score - price(residuals(null));
    Ok(if above.abs() < TIE_BIC {
        either(without, one, above)
    } else if above < 0.0 {
        one
    } else {
        without
    })
}

/// A tie of mistakes and effects; `above` is the score of the effects above that of the mistakes.
fn either(mistakes: Diagnosis, effects: Diagnosis, above: f64) -> Diagnosis {
    let remedies = mistakes.record_faults.iter().map(|f| f.fault.remedy());
    let mut remedies: Vec<String> = remedies.collect();
    remedies.dedup();
    let members = |d: &Diagnosis, above: f64| -> Vec<Rival> {
        let alone = Rival { effects: d.effects.clone(), record_faults: d.record_faults.clone(), score_above_best: 0.0 };
        let mut all = d.tie.clone();
        if all.is_empty() {
            all.push(alone);
        }
        all.iter_mut().for_each(|r| r.score_above_best += above);
        all
    };
    let (best, other) = if above < 0.0 { (effects, mistakes) } else { (mistakes, effects) };
    let mut tie = members(&best, 0.0);
    tie.extend(members(&other, above.abs()));
    Diagnosis {
        verdict: Verdict::Tie,
        tie,
        next_measurement: Some(format!("the same record once more, after a look at the rig ({})", remedies.join("; "))),
        ..best
    }
}
