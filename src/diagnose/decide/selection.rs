//! Which set of effects stands: one, and more while each one lowers the score and brings the data nearer.
//!
//! When the best single effect leaves something, pairs are begun with each of the best single effects. Further ones are
//! added one by one. Each member is then taken out and the catalogue searched again in its place, so that the order
//! does not matter: where the set does not explain the records, until one does; where it does, members that are not
//! needed any more go.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::estimate::{FINAL_MODEL_ERROR, Fit};
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::problem::Point;
use super::super::locate::place::Place;
use super::candidate::{Candidate, MODEL_ERRORS, Standing, fails};
use super::judgement::needs_longer;
use super::misfit::FAILING_BLOCK_CHI2;
use super::relatives::{placed_again, relatives};
use super::screening::{FIRST_EFFECT_BIC_GAIN, FURTHER_EFFECT_BIC_GAIN, ScreeningRound};
use crate::spindle::{Effect, EffectKind};
use rayon::prelude::*;

/// Most effects at once: what domain practice separates in one set of sweeps.
pub(crate) const MOST_EFFECTS: usize = 4;
/// First effects that are tried as the beginning of a pair.
const BEAM: usize = 2;

/// Share of the model error at which the machine as it is fails: an effect that holds down to there explains
/// nearly all.
const NEARLY: f64 = 0.11;

pub(crate) struct Chosen {
    pub standing: Standing,
    /// Other sets of the last searches.
    pub rivals: Vec<Candidate>,
    /// Single effects by score above the best: the finalists, then the others by their distance when they were dropped.
    pub ranking: Vec<(Effect, f64)>,
    /// Fall of the score by the best single effect.
    pub strength: f64,
}

/// Chooses at most so many effects beyond the machine as it is, beginning with the round of single effects.
pub(crate) fn choose(
    case: &Case,
    null: &Standing,
    mut round: ScreeningRound,
    sole: Option<&Place>,
    most: usize,
) -> Result<Chosen, DiagnoseError> {
    let within = |c: &Candidate| case.within(c);
    // What is in the electronics alone is no effect of the shaft that nuisance parameters could have taken up.
    let inside = sole.is_none_or(Place::mechanical);
    let again = if inside && !round.finalists.iter().any(within) { as_it_is(case, null) } else { None };
    if let Some(again) = again {
        (case.progress)("from the machine as it is");
        let again = case.full_round(&again)?;
        if again.finalists.first().is_some_and(within) {
            round = again;
        }
    }
    let ranking = rank_effects(&round);
    let finalists = round.finalists;
    let fall = fall(case, null, &finalists)?;
    let chosen = |standing, rivals| Chosen {
        standing,
        rivals,
        ranking,
        // Worse than nothing is no evidence at all.
        strength: fall.max(0.0),
    };
    let Some(first) = better(case, &finalists, fall, FIRST_EFFECT_BIC_GAIN)? else {
        return Ok(chosen(null.clone(), vec![]));
    };
    if !needs_longer(case, &null.candidate, &first.candidate)? {
        return Ok(chosen(null.clone(), vec![]));
    }
    if most <= 1 {
        return Ok(chosen(first, finalists));
    }
    let done = complete(case, &first)?;
    if let (Some(place), false) = (sole, done) {
        let alone = (first.clone(), finalists.clone());
        let (standing, rivals) = at_place(case, null, place, alone)?;
        // A free law takes up some of what happens elsewhere: an effect that explains nearly all is not the end.
        let far = first.working_error > NEARLY * null.working_error;
        if far && !place.absorbs_others() || complete(case, &standing)? {
            return Ok(chosen(standing, rivals));
        }
    }
    // Where the data look explained, nuisance parameters may have absorbed a second effect; where they do not, another
    // effect is there.
    let mut begins = vec![first.clone()];
    if !done {
        for other in finalists.iter().skip(1).take(BEAM - 1) {
            begins.push(settle(case, other)?);
        }
    }
    let (mut standing, mut rivals) = (first, finalists);
    while let Some((next, others)) = extend(case, &begins)? {
        if !needs_longer(case, &standing.candidate, &next.candidate)? {
            break;
        }
        let fruitless = !complete(case, &next)? && !next.nearer_than(&standing);
        (standing, rivals) = (next, others);
        if fruitless || standing.candidate.effects.len() >= most {
            break;
        }
        begins = vec![standing.clone()];
    }
    if standing.candidate.effects.len() > 1 && complete(case, &standing)? {
        standing = swap_effects(case, standing, &mut rivals)?;
        standing = drop_effects(case, standing, &mut rivals)?;
    }
    Ok(chosen(standing, rivals))
}

/// The same standing with every nuisance parameter at the value of the machine, where any effect may begin: beside
/// nuisance parameters that have taken up what is missing, and left their priors for that, the right effect has nothing
/// to explain. None where they have not, or where that is what the standing begins with.
fn as_it_is(case: &Case, standing: &Standing) -> Option<Standing> {
    let [working_error, ..] = MODEL_ERRORS;
    let fitted = &standing.candidate.fit.at;
    let begun = standing.working_error == working_error && standing.from.p.iter().all(|p| *p == 0.0);
    (case.model.is_strained(&fitted.p) && !begun).then(|| Standing {
        from: Point { theta: fitted.theta.clone(), ..case.origin() },
        working_error,
        failure: f64::INFINITY,
        ..standing.clone()
    })
}

/// Where all that is missing sits at one place and no single effect explains it: one and two effects that the place can
/// host.
fn at_place(
    case: &Case,
    null: &Standing,
    place: &Place,
    (mut standing, mut rivals): (Standing, Vec<Candidate>),
) -> Result<(Standing, Vec<Candidate>), DiagnoseError> {
    let hosted: Vec<Hypothesis> = case.catalogue.iter().filter(|h| place.hosts(h.kind, &h.place)).cloned().collect();
    let narrow = Case { catalogue: &hosted, ..*case };
    let mut begins = vec![null.clone()];
    for _ in 0..2 {
        let Some((next, others)) = extend(&narrow, &begins)? else {
            break;
        };
        let done = complete(case, &next)?;
        begins = vec![next.clone()];
        if done || next.nearer_than(&standing) {
            (standing, rivals) = (next, others);
        }
        if done {
            break;
        }
    }
    Ok((standing, rivals))
}

/// A set, and all that it was compared with.
type Compared = (Standing, Vec<Candidate>);

/// The best set with one more effect than one of `begins`, and all that were compared. Where nuisance parameters have
/// left their priors beside the first of them, it is also begun as the machine is. Strong effects of every size take
/// longest. They come last: where no other effect explains the records, also with a member of the best set exchanged.
/// What then leaves something may have its tilting stiffness at a place beside its own.
fn extend(case: &Case, begins: &[Standing]) -> Result<Option<Compared>, DiagnoseError> {
    let mut tried = vec![];
    let again = begins.first().and_then(|best| as_it_is(case, best));
    let begins: Vec<Standing> = begins.iter().cloned().chain(again).collect();
    for begin in &begins {
        let round = case.run_round(begin)?;
        let longer = longer(case, begin, &round.finalists)?;
        tried.push((round, longer));
        if is_explained(case, &tried)? {
            return Ok(best_of(tried));
        }
    }
    if let Some(best) = ahead_of_all(&tried)
        && let Some(other) = exchange_effect(case, best)?
    {
        return Ok(Some(other));
    }
    for (k, begin) in begins.iter().enumerate() {
        let (round, found) = &mut tried[k];
        if case.add_strong(begin, round)? {
            *found = longer(case, begin, &round.finalists)?;
            if is_explained(case, &tried)? {
                break;
            }
        }
    }
    let Some((found, rivals)) = best_of(tried) else {
        return Ok(None);
    };
    let placed = settle(case, &placed_again(case, found.candidate.clone())?)?;
    let explains = complete(case, &placed)?;
    Ok(Some((if explains { placed } else { found }, rivals)))
}

/// The best finalist beside a set as the new standing, if it lowers the score enough.
fn longer(case: &Case, begin: &Standing, finalists: &[Candidate]) -> Result<Option<Standing>, DiagnoseError> {
    let least = if begin.candidate.effects.is_empty() { FIRST_EFFECT_BIC_GAIN } else { FURTHER_EFFECT_BIC_GAIN };
    better(case, finalists, fall(case, begin, finalists)?, least)
}

/// Rounds with the sets that they led to.
type Tried = [(ScreeningRound, Option<Standing>)];

/// The best of these sets.
fn ahead_of_all(tried: &Tried) -> Option<&Standing> {
    let rank = |s: &Standing| (s.candidate.model_error, s.candidate.score());
    let found = tried.iter().filter_map(|(_, longer)| longer.as_ref());
    found.reduce(|best, next| if rank(next) < rank(best) { next } else { best })
}

/// Whether the best of these sets leaves nothing.
fn is_explained(case: &Case, tried: &Tried) -> Result<bool, DiagnoseError> {
    ahead_of_all(tried).map_or(Ok(false), |best| complete(case, best))
}

/// The best of these sets, and the finalists of all rounds that led to one.
fn best_of(tried: Vec<(ScreeningRound, Option<Standing>)>) -> Option<Compared> {
    let best = ahead_of_all(&tried)?.clone();
    let led = tried.into_iter().filter(|(_, longer)| longer.is_some());
    Some((best, led.flat_map(|(round, _)| round.finalists).collect()))
}

/// The set without a member, and what the catalogue offers in its place.
fn in_place_of(case: &Case, standing: &Standing, member: usize) -> Result<(Standing, ScreeningRound), DiagnoseError> {
    let (effects, mut at) = standing.candidate.without(member);
    at.p.fill(0.0);
    let without = case.fit_down(&effects, &at, Subset::ALL)?;
    case.run_round(&without).map(|round| (without, round))
}

/// The set that explains the records once one member is exchanged, and all that were compared: the first member may
/// have stood for parts of two effects. The last member is left out: it was searched beside all others.
fn exchange_effect(case: &Case, standing: &Standing) -> Result<Option<Compared>, DiagnoseError> {
    for member in 0..standing.candidate.effects.len().saturating_sub(1) {
        let finalists = in_place_of(case, standing, member)?.1.finalists;
        if let Some(best) = finalists.first() {
            let settled = settle(case, best)?;
            if complete(case, &settled)? {
                return Ok(Some((settled, finalists)));
            }
        }
    }
    Ok(None)
}

/// Were the earlier members the right choice, now that the others are known?
fn swap_effects(case: &Case, mut standing: Standing, rivals: &mut Vec<Candidate>) -> Result<Standing, DiagnoseError> {
    for _ in 1..standing.candidate.effects.len() {
        let (without, mut round) = in_place_of(case, &standing, 0)?;
        case.add_strong(&without, &mut round)?;
        let again = round.finalists;
        // One unit of score is a likelihood ratio that means nothing; it keeps equal fits where they are.
        match again.first() {
            Some(other) if other.score() < standing.candidate.score() - 1.0 => {
                standing = settle(case, other)?;
            }
            _ => {
                // The same member again: it goes to the end, so that the next one is first.
                standing.candidate = case.rotate_effects(&standing.candidate, 1)?;
                standing.from.theta.rotate_left(1);
            }
        }
        rivals.extend(again);
    }
    let related = relatives(case, &standing.candidate)?;
    let best = related.iter().min_by(|a, b| a.score().total_cmp(&b.score()));
    if let Some(other) = best.filter(|b| b.score() < standing.candidate.score() - 1.0) {
        standing = settle(case, other)?;
    }
    rivals.extend(related);
    Ok(standing)
}

/// The set without members that are not needed any more.
fn drop_effects(case: &Case, mut standing: Standing, rivals: &mut Vec<Candidate>) -> Result<Standing, DiagnoseError> {
    let mut i = 0;
    while complete(case, &standing)? && standing.candidate.effects.len() > 1 && i < standing.candidate.effects.len() {
        let (effects, at) = standing.candidate.without(i);
        let at = elsewhere(case, &effects, at)?;
        let without = case.finish(&effects, &at, 0.01, Subset::ALL)?;
        if without.score() < standing.candidate.score() + FURTHER_EFFECT_BIC_GAIN {
            standing = settle(case, &without)?;
            rivals.clear();
            i = 0;
        } else {
            i += 1;
        }
    }
    Ok(standing)
}

/// Of all places of the effects that have one, one after the other, the best start: beside an effect that is gone the
/// place may have been another.
fn elsewhere(case: &Case, effects: &[Hypothesis], at: Point) -> Result<Point, DiagnoseError> {
    let problem = case.problem(effects, case.thin());
    let fit = |from: &Point| problem.fit(from, &[(0.01, 3), (0.003, 3)]);
    let mut best = fit(&at)?;
    for (e, effect) in effects.iter().enumerate() {
        let own = |h: &&Hypothesis| h.same_name(effect);
        let placed = effect.place.position_m().is_some();
        let stations: Vec<&Hypothesis> = if placed { case.catalogue.iter().filter(own).collect() } else { vec![] };
        let tried: Vec<Fit> = stations
            .par_iter()
            .filter_map(|h| {
                let from = best.at.with_effect_at(e, h)?;
                fit(&from).ok()
            })
            .collect();
        for other in tried {
            if other.chi2 < best.chi2 {
                best = other;
            }
        }
    }
    Ok(best.at)
}

/// Score of a standing at the final model error.
fn final_score(case: &Case, standing: &Standing) -> Result<f64, DiagnoseError> {
    if standing.candidate.model_error == FINAL_MODEL_ERROR {
        return Ok(standing.candidate.score());
    }
    let Candidate { effects, .. } = &standing.candidate;
    let (from, top) = (&standing.from, standing.working_error);
    Ok(case.finish(effects, from, top, Subset::ALL)?.score())
}

/// Whether nothing significant is left, and no nuisance parameter had to leave its prior for that.
pub(crate) fn complete(case: &Case, standing: &Standing) -> Result<bool, DiagnoseError> {
    let Candidate { effects, fit, model_error } = &standing.candidate;
    Ok(*model_error == FINAL_MODEL_ERROR
        && !case.model.is_strained(&fit.at.p)
        && case.misfit(effects, &fit.at, FINAL_MODEL_ERROR)?.value < FAILING_BLOCK_CHI2)
}

/// Fall of the score by the best finalist, or what it is at least; without limit where it does not reach the final
/// model error: it explains too little, but may be one of two.
fn fall(case: &Case, standing: &Standing, finalists: &[Candidate]) -> Result<f64, DiagnoseError> {
    Ok(match finalists.first() {
        Some(best) if best.model_error == FINAL_MODEL_ERROR => {
            // A lower model error makes every χ² larger.
            let least = standing.candidate.score() - best.score();
            if least > FURTHER_EFFECT_BIC_GAIN { least } else { final_score(case, standing)? - best.score() }
        }
        Some(_) => f64::INFINITY,
        None => 0.0,
    })
}

/// The best finalist as the new standing, if the score falls by `least`, more than by chance.
fn better(case: &Case, finalists: &[Candidate], fall: f64, least: f64) -> Result<Option<Standing>, DiagnoseError> {
    let Some(best) = finalists.first() else {
        return Ok(None);
    };
    if fall < least {
        return Ok(None);
    }
    if best.model_error > FINAL_MODEL_ERROR {
        return Ok(Some(settle(case, best)?));
    }
    let settled = settle(case, best)?;
    // The number must also differ from nothing by itself.
    let (Some(h), Some(theta)) = (best.effects.last(), settled.candidate.fit.at.theta.last()) else {
        return Ok(None);
    };
    let covariance = settled.candidate.fit.covariance()?;
    let column = covariance.ncols() - theta.len();
    let significant = h.size(theta).abs() > 2.0 * covariance[(column, column)].max(0.0).sqrt();
    let joint = h.kind == EffectKind::ToolJoint;
    Ok((significant || joint).then_some(settled))
}

pub(crate) fn settle(case: &Case, best: &Candidate) -> Result<Standing, DiagnoseError> {
    if !fails(&best.fit) {
        return Ok(Standing {
            candidate: best.clone(),
            from: best.fit.at.clone(),
            working_error: FINAL_MODEL_ERROR,
            failure: best.fit.data_chi2 / best.fit.residuals.max(1) as f64,
        });
    }
    // Where it begins to fail is where the next effect is looked for.
    let start =
        Point { p: vec![0.0; best.fit.at.p.len()], theta: best.fit.at.theta.clone(), smooth: best.fit.at.smooth };
    let stood = case.fit_down(&best.effects, &start, Subset::ALL)?;
    Ok(Standing {
        candidate: if stood.working_error == FINAL_MODEL_ERROR { stood.candidate } else { best.clone() },
        from: stood.from,
        working_error: stood.working_error,
        failure: stood.failure,
    })
}

fn rank_effects(round: &ScreeningRound) -> Vec<(Effect, f64)> {
    let Some(best) = round.finalists.first().map(Candidate::score) else {
        return vec![];
    };
    let mut ranking: Vec<(Effect, f64)> =
        round.finalists.iter().filter_map(|c| Some((c.newest()?, c.score() - best))).collect();
    let mut others = round.others.clone();
    others.sort_by(|a, b| a.1.total_cmp(&b.1));
    for (effect, above) in others {
        let known = |r: &(Effect, f64)| r.0.kind == effect.kind && r.0.location == effect.location;
        if !ranking.iter().any(known) {
            ranking.push((effect, above));
        }
    }
    ranking
}
