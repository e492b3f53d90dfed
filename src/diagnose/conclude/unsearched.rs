//! Diagnoses with effects for which nothing was searched: those too small for a name, and one that a free law or a
//! round of single effects gives.

use super::super::DiagnoseError;
use super::super::decide::candidate::Standing;
use super::super::decide::judgement::Verdict;
use super::super::decide::screening::ScreeningRound;
use super::super::decide::selection::{Chosen, settle};
use super::super::fit::case::Case;
use super::super::locate::localisation::{Localisation, localise};
use super::super::records::finding::FoundFault;
use super::super::records::trial::Trial;
use super::verdict::{Diagnosis, conclude_diagnosis, hypotheses};

/// The diagnosis of a machine with effects that are too small for a name, where these explain the records and no single
/// effect of the catalogue explains them better.
pub(super) fn conclude_small(
    trial: &Trial,
    null: &Standing,
    faults: &[FoundFault],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Option<Diagnosis>, DiagnoseError> {
    let catalogue = hypotheses(&trial.machine, &trial.model, &trial.evidence)?;
    let case = trial.case(&catalogue, progress);
    progress("effects too small for a name");
    let Some(standing) = case.explain_by_small()? else {
        return Ok(None);
    };
    let single = case.run_round(null)?.finalists;
    let score = standing.candidate.score();
    if single.iter().any(|c| case.within(c) && c.score() < score) {
        return Ok(None);
    }
    let chosen = Chosen { standing, rivals: vec![], ranking: vec![], strength: 0.0 };
    let found = conclude_diagnosis(trial, &case, null, localise(&case)?, chosen, faults.to_vec())?;
    Ok((found.verdict != Verdict::Unexplained).then_some(found))
}

/// The diagnosis with one effect that a free law reads off, where it explains the records.
pub(super) fn conclude_located(
    trial: &Trial,
    null: &Standing,
    localisation: &Localisation,
    faults: Vec<FoundFault>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Option<Diagnosis>, DiagnoseError> {
    let catalogue = hypotheses(&trial.machine, &trial.model, &trial.evidence)?;
    let case = trial.case(&catalogue, progress);
    let mut round = ScreeningRound { finalists: vec![], others: vec![] };
    case.add_located(localisation, &mut round);
    conclude_single(trial, &case, null, localisation, round, faults)
}

/// The diagnosis with the best effect of a round, where it explains the records.
pub(super) fn conclude_single(
    trial: &Trial,
    case: &Case,
    null: &Standing,
    localisation: &Localisation,
    round: ScreeningRound,
    faults: Vec<FoundFault>,
) -> Result<Option<Diagnosis>, DiagnoseError> {
    let Some(best) = round.finalists.first().filter(|c| case.within(c)) else {
        return Ok(None);
    };
    let standing = settle(case, best)?;
    let chosen = Chosen { standing, rivals: round.finalists, ranking: vec![], strength: 0.0 };
    let found = conclude_diagnosis(trial, case, null, localisation.clone(), chosen, faults)?;
    Ok((found.verdict != Verdict::Unexplained).then_some(found))
}
