//! From data to verdict: `adequate`, `named`, `tie` or `unexplained`, with the corrected machine and the gap before and after.
//!
//! Effects are added while the score falls and something is unexplained; each earlier one is then taken out and the catalogue searched
//! again, so that the order does not matter. A name is given only when the whole then explains the data; else the verdict is
//! `unexplained`. Rivals of equal score are a tie. Held-out data (hammer tests, or the channels between the bearings) are predicted
//! from a fit that has not seen them.

use super::DiagnoseError;
use super::compare::{Channel, Fitted, channels, gaps};
use super::correction::{Correction, correct};
use super::evidence::{Evidence, Gap, Use};
use super::experiment::Measurement;
use super::fit::{FINAL_FLOOR, Point};
use super::hypothesis::{Hypothesis, Scope, catalogue};
use super::localise::{Localisation, localise};
use super::model::Model;
use super::next::proposals;
use super::search::{
    ACCEPT, BLOCK_FAILS, Candidate, MOST_EFFECTS, Misfit, Round, Search, Standing, TIE,
};
use crate::spindle::{Effect, EffectKind, Machine};

/// Model floor at which a named model must explain the data: what an independent simulation or a good test rig leaves, relative.
const JUDGE_FLOOR: f64 = 2e-3;

/// The four verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is missing.
    Adequate,
    /// The effects are named.
    Named,
    /// Several explanations fit alike.
    Tie,
    /// Something is missing that is in no catalogue.
    Unexplained,
}

impl Verdict {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::Named => "named",
            Self::Tie => "tie",
            Self::Unexplained => "unexplained",
        }
    }
}

/// An effect with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedEffect {
    /// The effect.
    pub effect: Effect,
    /// Standard deviations, in the order of the parameters.
    pub standard_deviations: Vec<f64>,
    /// 90 % intervals.
    pub intervals: Vec<(f64, f64)>,
    /// Standard deviation of a fitted position, m.
    pub position_sd_m: Option<f64>,
}

/// A rival explanation.
#[derive(Clone, Debug, PartialEq)]
pub struct Rival {
    /// Its effects.
    pub effects: Vec<NamedEffect>,
    /// Score above the best.
    pub score_above_best: f64,
}

/// The outcome.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// Named effects; of a tie, the best explanation.
    pub effects: Vec<NamedEffect>,
    /// Members of a tie, the best first; empty otherwise.
    pub tie: Vec<Rival>,
    /// Best explanations at the last search, best first: names with score above the best.
    pub ranking: Vec<(Effect, f64)>,
    /// Fall of the score by the best single effect; an effect is named from [`ACCEPT`] on.
    pub strength: f64,
    /// The machine with effects and small parameters.
    pub corrected: Machine,
    /// Gap of the given machine over all records.
    pub gap_before: f64,
    /// Gap of the corrected machine over all records.
    pub gap_after: f64,
    /// Gap of the given machine on the held-out records.
    pub gap_before_held_out: f64,
    /// Gap on the held-out records of the machine corrected without them.
    pub gap_after_held_out: f64,
    /// What was held out.
    pub held_out: String,
    /// The measurement that would separate a tie.
    pub next_measurement: Option<String>,
    /// Worst block that remains.
    pub misfit: Misfit,
    /// Where the given machine disagrees, without a hypothesis.
    pub localisation: Localisation,
    /// Axis gains of the sweeps, which belong to the records and not to the machine.
    pub axis_gains: Vec<[f64; 4]>,
    /// Small parameters of the fit.
    pub small: Vec<f64>,
    /// Measured, model before and model after, channel by channel.
    pub channels: Vec<Channel>,
    /// What stands in for a name when the verdict is unexplained.
    pub correction: Option<Correction>,
}

impl Diagnosis {
    /// Gaps before and after of the records that were held out, or of those that were used, for the machine fitted to the used ones.
    pub fn gaps(&self, held_out: bool) -> (f64, f64) {
        gaps(&self.channels, |c| c.held_out == held_out)
    }
}

/// Diagnoses a machine; `progress` is told what is being done.
///
/// # Errors
/// [`DiagnoseError`] for records or machines that cannot be used.
pub fn diagnose(
    machine: &Machine,
    measurement: &Measurement,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    let evidence = Evidence::new(measurement)?;
    let model = Model::new(machine, &evidence.axis_gain_sd())?;
    let records = evidence
        .sweeps
        .iter()
        .map(|s| (s.speed_rad_s, s.omega_rad_s.last()));
    let scope = Scope {
        turning: records.clone().any(|(speed, _)| speed != 0.0),
        top_rad_s: records.filter_map(|(_, w)| w.copied()).fold(0.0, f64::max),
    };
    let catalogue = catalogue(machine, model.span_m(), model.flexible_rad_s(), scope)?;
    let search = Search {
        model: &model,
        evidence: &evidence,
        catalogue: &catalogue,
        progress,
    };
    progress("the machine as it is");
    let null = search.stand(&[], &search.origin(), Use::ALL)?;
    let chosen = choose(&search, &null)?;
    progress("where it sits");
    let localisation = localise(&search)?;
    let best = chosen.standing.candidate.clone();
    let misfit = search.misfit(&best.effects, &best.fit.at, JUDGE_FLOOR)?;
    let explained = best.floor == FINAL_FLOOR && misfit.value < BLOCK_FAILS;
    let mut verdict = match (explained, best.effects.is_empty()) {
        (false, _) => Verdict::Unexplained,
        (true, true) => Verdict::Adequate,
        (true, false) => Verdict::Named,
    };
    let mut tie = vec![];
    let mut members: Vec<&Candidate> = vec![&best];
    if verdict == Verdict::Named {
        // χ² differences count less where a floor, not the noise, carries the model error.
        for rival in &chosen.rivals {
            if rival.floor > best.floor {
                continue;
            }
            let distance = rival.score() - best.score();
            let known = members
                .iter()
                .any(|m| same_names(&m.effects, &rival.effects));
            if distance < TIE && !known {
                members.push(rival);
            }
        }
        if members.len() > 1 {
            verdict = Verdict::Tie;
            for member in &members {
                tie.push(Rival {
                    effects: named(member)?,
                    score_above_best: member.score() - best.score(),
                });
            }
        }
    }
    let (effects, final_point) = if verdict == Verdict::Unexplained {
        (vec![], null.from.clone())
    } else {
        (named(&best)?, best.fit.at.clone())
    };
    let hypotheses: &[Hypothesis] = if verdict == Verdict::Unexplained {
        &[]
    } else {
        &best.effects
    };
    progress("held-out records");
    let training = if evidence.taps.is_empty() {
        Use {
            off_diagonal: false,
            ..Use::ALL
        }
    } else {
        Use {
            taps: false,
            ..Use::ALL
        }
    };
    let held_out = if evidence.taps.is_empty() {
        "channels between the bearings"
    } else {
        "hammer at the tool"
    };
    let trained = if verdict == Verdict::Unexplained {
        null.from.clone()
    } else {
        let start = Point {
            p: vec![0.0; model.layout.len()],
            theta: final_point.theta.clone(),
        };
        search.finish(hypotheses, &start, 0.03, training)?.fit.at
    };
    let correction = match (verdict, localisation.named()) {
        (Verdict::Unexplained, Some(port)) => Some(correct(&search, port, training)?),
        _ => None,
    };
    let fitted = Fitted {
        small: trained.p.clone(),
        effects: hypotheses
            .iter()
            .zip(&trained.theta)
            .map(|(h, t)| h.effect(t))
            .collect(),
    };
    let channels = channels(&search, &fitted, correction.as_ref())?;
    let gap = |hypotheses: &[Hypothesis], at: &Point, out: Option<bool>| {
        gap(&search, hypotheses, at, out)
    };
    let origin = search.origin();
    let axis_gains = (0..evidence.sweeps.len())
        .map(|s| std::array::from_fn(|i| final_point.p[model.layout.axis(s, i)]))
        .collect();
    let mut corrected = model.layout.apply(machine, &final_point.p);
    corrected
        .spindle
        .effects
        .extend(effects.iter().map(|e| e.effect.clone()));
    Ok(Diagnosis {
        next_measurement: next_measurement(&search, verdict, &members)?,
        gap_before: gap(&[], &origin, None)?,
        gap_after: gap(hypotheses, &final_point, None)?,
        gap_before_held_out: gap(&[], &origin, Some(true))?,
        gap_after_held_out: gap(hypotheses, &trained, Some(true))?,
        held_out: held_out.into(),
        ranking: chosen.ranking,
        strength: chosen.strength,
        verdict,
        effects,
        tie,
        corrected,
        misfit,
        localisation,
        axis_gains,
        small: final_point.p,
        channels,
        correction,
    })
}

struct Chosen {
    standing: Standing,
    rivals: Vec<Candidate>,
    ranking: Vec<(Effect, f64)>,
    strength: f64,
}

/// First effects that are tried as the beginning of a pair.
const BEAM: usize = 2;

fn choose(search: &Search, null: &Standing) -> Result<Chosen, DiagnoseError> {
    let round = search.round(null)?;
    let ranking = ranked(&round);
    let strength = match round.finalists.first() {
        Some(best) if best.floor == FINAL_FLOOR => final_score(search, null)? - best.score(),
        Some(_) => f64::INFINITY,
        None => 0.0,
    };
    let Some(first) = better(search, null, &round)? else {
        return Ok(Chosen {
            standing: null.clone(),
            rivals: vec![],
            ranking,
            strength,
        });
    };
    if complete(search, &first)? || MOST_EFFECTS < 2 {
        return Ok(Chosen {
            standing: first,
            rivals: round.finalists,
            ranking,
            strength,
        });
    }
    // Something is left: pairs, begun with each of the best first effects.
    let mut begins = vec![first.clone()];
    for other in round.finalists.iter().skip(1).take(BEAM - 1) {
        begins.push(settle(search, other)?);
    }
    let (mut best, mut rivals): (Option<Standing>, Vec<Candidate>) = (None, vec![]);
    for begin in &begins {
        let round = search.round(begin)?;
        if let Some(pair) = better(search, begin, &round)? {
            rivals.extend(round.finalists);
            let rank = |s: &Standing| (s.candidate.floor, s.candidate.score());
            let ahead = best.as_ref().is_none_or(|b| rank(&pair) < rank(b));
            if ahead {
                best = Some(pair);
            }
        }
        if let Some(best) = &best
            && complete(search, best)?
        {
            break;
        }
    }
    let Some(mut standing) = best else {
        return Ok(Chosen {
            standing: first,
            rivals: round.finalists,
            ranking,
            strength,
        });
    };
    if complete(search, &standing)? {
        // Was the first one the right choice, now that the second is known?
        let mut effects = standing.candidate.effects.clone();
        let mut at = standing.candidate.fit.at.clone();
        effects.remove(0);
        at.theta.remove(0);
        at.p.fill(0.0);
        let without = search.stand(&effects, &at, Use::ALL)?;
        let again = search.round(&without)?;
        if let Some(swapped) = again.finalists.first()
            && swapped.score() < standing.candidate.score() - 1.0
        {
            standing = settle(search, swapped)?;
        }
        rivals.extend(again.finalists);
    }
    // A member that is not needed any more goes.
    let mut i = 0;
    while complete(search, &standing)?
        && standing.candidate.effects.len() > 1
        && i < standing.candidate.effects.len()
    {
        let mut effects = standing.candidate.effects.clone();
        let mut at = standing.candidate.fit.at.clone();
        effects.remove(i);
        at.theta.remove(i);
        let without = search.finish(&effects, &at, 0.01, Use::ALL)?;
        if without.score() < standing.candidate.score() + ACCEPT {
            standing = settle(search, &without)?;
            rivals.clear();
            i = 0;
        } else {
            i += 1;
        }
    }
    Ok(Chosen {
        standing,
        rivals,
        ranking,
        strength,
    })
}

/// Score of a standing at the final floor.
fn final_score(search: &Search, standing: &Standing) -> Result<f64, DiagnoseError> {
    if standing.candidate.floor == FINAL_FLOOR {
        return Ok(standing.candidate.score());
    }
    let Candidate { effects, .. } = &standing.candidate;
    let (from, top) = (&standing.from, standing.working_floor);
    Ok(search.finish(effects, from, top, Use::ALL)?.score())
}

/// Whether nothing significant is left.
fn complete(search: &Search, standing: &Standing) -> Result<bool, DiagnoseError> {
    let Candidate {
        effects,
        fit,
        floor,
    } = &standing.candidate;
    Ok(*floor == FINAL_FLOOR && search.misfit(effects, &fit.at, FINAL_FLOOR)?.value < BLOCK_FAILS)
}

/// The best finalist as the new standing, if it explains so much more that chance cannot.
fn better(
    search: &Search,
    standing: &Standing,
    round: &Round,
) -> Result<Option<Standing>, DiagnoseError> {
    let Some(best) = round.finalists.first() else {
        return Ok(None);
    };
    if best.floor > FINAL_FLOOR {
        // It explains too little, but may be one of two.
        return Ok(Some(settle(search, best)?));
    }
    if best.score() > final_score(search, standing)? - ACCEPT {
        return Ok(None);
    }
    let settled = settle(search, best)?;
    // The number must also differ from nothing by itself.
    let (Some(h), Some(theta)) = (best.effects.last(), settled.candidate.fit.at.theta.last())
    else {
        return Ok(None);
    };
    let covariance = settled.candidate.fit.covariance()?;
    let column = covariance.ncols() - theta.len();
    let significant = h.size(theta).abs() > 2.0 * covariance[(column, column)].max(0.0).sqrt();
    Ok((significant || h.kind == EffectKind::ToolJoint).then_some(settled))
}

fn settle(search: &Search, best: &Candidate) -> Result<Standing, DiagnoseError> {
    let fails = best.fit.data_chi2 > best.fit.residuals as f64;
    if !fails {
        return Ok(Standing {
            candidate: best.clone(),
            from: best.fit.at.clone(),
            working_floor: FINAL_FLOOR,
        });
    }
    // Where it begins to fail is where the next effect is looked for.
    let start = Point {
        p: vec![0.0; best.fit.at.p.len()],
        theta: best.fit.at.theta.clone(),
    };
    let stood = search.stand(&best.effects, &start, Use::ALL)?;
    Ok(Standing {
        candidate: if stood.working_floor == FINAL_FLOOR {
            stood.candidate
        } else {
            best.clone()
        },
        from: stood.from,
        working_floor: stood.working_floor,
    })
}

fn same_names(a: &[Hypothesis], b: &[Hypothesis]) -> bool {
    a.len() == b.len() && a.iter().all(|x| b.iter().any(|y| x.same_name(y)))
}

fn ranked(round: &Round) -> Vec<(Effect, f64)> {
    let Some(best) = round.finalists.first().map(Candidate::score) else {
        return vec![];
    };
    round
        .finalists
        .iter()
        .filter_map(|c| {
            let (h, theta) = (c.effects.last()?, c.fit.at.theta.last()?);
            Some((h.effect(theta), c.score() - best))
        })
        .collect()
}

/// Effects of a candidate with standard deviations and 90 % intervals from the curvature.
fn named(candidate: &Candidate) -> Result<Vec<NamedEffect>, DiagnoseError> {
    let covariance = candidate.fit.covariance()?;
    // Model error beyond noise and floor widens everything.
    let excess = (candidate.fit.data_chi2 / candidate.fit.residuals.max(1) as f64)
        .max(1.0)
        .sqrt();
    let free: usize = candidate.fit.at.theta.iter().map(Vec::len).sum();
    let mut column = covariance.ncols() - free;
    let mut all = vec![];
    for (h, theta) in candidate.effects.iter().zip(&candidate.fit.at.theta) {
        let effect = h.effect(theta);
        let (mut deviations, mut intervals) = (vec![], vec![]);
        let sd = |i: usize| covariance[(column + i, column + i)].max(0.0).sqrt() * excess;
        for (i, value) in effect.values.iter().enumerate() {
            let at = |shift: f64| {
                let mut moved = theta.clone();
                moved[i] += shift;
                h.clamp(&mut moved);
                h.effect(&moved).values.get(i).copied().unwrap_or(*value)
            };
            let step = 1e-3 * sd(i).min(1.0);
            let slope = if step > 0.0 {
                (at(step) - at(-step)) / (2.0 * step)
            } else {
                0.0
            };
            deviations.push((slope * sd(i)).abs());
            // 1.645 σ on either side hold 90 % of a normal distribution in fit coordinates.
            let (a, b) = (at(-1.645 * sd(i)), at(1.645 * sd(i)));
            intervals.push((a.min(b), a.max(b)));
        }
        let position_sd_m = matches!(effect.location, crate::spindle::Location::Position(_))
            .then(|| 0.05 * sd(theta.len() - 1));
        column += theta.len();
        all.push(NamedEffect {
            effect,
            standard_deviations: deviations,
            intervals,
            position_sd_m,
        });
    }
    Ok(all)
}

/// Gap of a hypothesis; `out`: only the held-out records, or all.
fn gap(
    search: &Search,
    hypotheses: &[Hypothesis],
    at: &Point,
    out: Option<bool>,
) -> Result<f64, DiagnoseError> {
    let effects: Vec<Effect> = hypotheses
        .iter()
        .zip(&at.theta)
        .map(|(h, t)| h.effect(t))
        .collect();
    let mut total = Gap::default();
    let evidence = search.evidence;
    let held_taps = !evidence.taps.is_empty();
    for sweep in &evidence.sweeps {
        if out.is_some() && held_taps {
            break;
        }
        let model = search
            .model
            .assemble(&at.p, &effects, sweep.speed_rad_s, false)?;
        for (line, omega) in sweep.omega_rad_s.iter().enumerate() {
            let f = model.line(*omega, None).response;
            sweep.gap(line, &f, |i, j| out.is_none() || i / 2 != j / 2, &mut total);
        }
    }
    for tap in &evidence.taps {
        let model = search
            .model
            .assemble(&at.p, &effects, tap.speed_rad_s, false)?;
        for (line, omega) in tap.omega_rad_s.iter().enumerate() {
            tap.gap(line, &model.line(*omega, None).response, &mut total);
        }
    }
    Ok(total.value())
}

/// The measurement that separates what ties most, with the expected separation.
fn next_measurement(
    search: &Search,
    verdict: Verdict,
    members: &[&Candidate],
) -> Result<Option<String>, DiagnoseError> {
    match (verdict, members) {
        (Verdict::Unexplained, _) => Ok(Some(
            "repeat the sweep at half the amplitude, and with a second sensor at the place the localisation names: \
             that tells a nonlinear or a sensor effect from a mechanical one"
                .into(),
        )),
        (Verdict::Tie, [a, b, ..]) => Ok(proposals(search, a, b)?
            .first()
            .map(|p| format!("{} (expected separation χ² ≈ {:.0} between the two best)", p.text, p.separation))),
        _ => Ok(None),
    }
}
