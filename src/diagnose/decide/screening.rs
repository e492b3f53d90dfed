//! Which effects are missing: every entry of the catalogue is fitted jointly with the nuisance parameters, and the best
//! is kept.
//!
//! Screening fits thinned lines, then all lines, then what is left at the final model error. The score is χ² + d ln N
//! (BIC). An effect is accepted when the score decreases by [`FURTHER_EFFECT_BIC_GAIN`]: with about 90 hypotheses of up
//! to three numbers the 95 % quantile of the largest gain under the null is 12 for one number and 17.5 for three, close
//! to d ln N; the surplus covers correlated model error. The first effect needs [`FIRST_EFFECT_BIC_GAIN`]: over 124
//! null records of an independent simulator the score decreases in seven, by 4.4 at most, so that a surplus of 5 gives
//! about one false alarm in a hundred.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::estimate::{FINAL_MODEL_ERROR, Fit, Stage};
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::linearise::assembled_with_size;
use super::super::fit::problem::Point;
use super::candidate::{Candidate, MODEL_ERRORS, Standing, failing_chi2, fails, next_model_error};
use crate::spindle::{Effect, EffectKind, Location};
use rayon::prelude::*;

/// Least fall of the score for another effect.
pub(crate) const FURTHER_EFFECT_BIC_GAIN: f64 = 16.0;
/// Least fall for a first one: no large effect is there whose model error a small one could take up.
pub(crate) const FIRST_EFFECT_BIC_GAIN: f64 = 5.0;
/// Scores closer than this cannot be told apart (odds of 1 to 30).
pub(crate) const TIE_BIC: f64 = 7.0;
/// Names that reach the thinned second screening, all lines, and the final model error.
const SHORT_LISTS: [usize; 3] = [24, 8, 5];
/// The same for a second effect.
const PAIR_LISTS: [usize; 3] = [16, 6, 4];
/// Starts, beside those of effects that have one place, that may say the same as a mistake of the rig.
const MIMICS: usize = 8;
/// Hypotheses beyond this multiple of the best χ² after a first fit are dropped, except resonances, whose χ² falls
/// late.
pub(super) const DROPPED_CHI2_RATIO: f64 = 3.0;
/// Starts of one name that are fitted.
const STARTS: usize = 2;
/// Names that reach the final model error where none of them explains the data: those that pairs are begun with; twice
/// as many are fitted to all lines.
const PAIR_SEEDS: usize = 2;

/// Places of one name at which the machine is evaluated, those with the smallest predicted χ².
const PLACES: usize = 12;

/// Lines that rank hypotheses, at least every third.
pub(super) const LINES: usize = 60;
/// Lines to which finalists are fitted at larger model errors, at least; at the final one all lines are fitted.
const FINALIST_LINES: usize = 160;

/// The present effects and one more.
pub(super) fn beside_present(present: &[Hypothesis], h: &Hypothesis) -> Vec<Hypothesis> {
    let mut effects = present.to_vec();
    effects.push(h.clone());
    effects
}

/// A point with a hypothesis at its start besides.
fn beside(origin: &Point, h: &Hypothesis) -> Point {
    let mut from = origin.clone();
    from.theta.push(h.start.clone());
    from
}

/// Model error at which a machine fails that a strong effect may be missing of.
const STRONG_FROM: f64 = 0.01;

#[derive(Clone, Debug)]
pub struct ScreeningRound {
    /// Finalists at the final model error, best score first.
    pub finalists: Vec<Candidate>,
    /// Effects dropped before, with their score above the best at that stage.
    pub others: Vec<(Effect, f64)>,
}

impl Case<'_> {
    /// Adds each hypothesis of the catalogue to a standing. Where nothing explains the data, strong effects may follow
    /// (`add_strong`), and only then is the best finalist moved.
    ///
    /// # Errors
    /// As [`Self::fit_down`].
    pub fn run_round(&self, standing: &Standing) -> Result<ScreeningRound, DiagnoseError> {
        let present = &standing.candidate.effects;
        let w = standing.working_error;
        let lists = if present.is_empty() { SHORT_LISTS } else { PAIR_LISTS };
        let with = |h: &Hypothesis| beside_present(present, h);
        let free = self.free(present, is_settled(standing));
        (self.progress)(&format!("{} hypotheses, beside {} accepted", free.len(), present.len()));
        let fit = |h: &Hypothesis, from: &Point, usage: Subset, stages: &[Stage]| {
            self.problem(&with(h), usage).fit(from, stages)
        };
        let lower = next_model_error(w);
        let mut begun = self.first_fits(standing, free, lists[0])?;
        self.move_tilting(&mut begun, &with, first_stages(standing))?;
        let mut others = vec![];
        let begun = ahead(
            begun,
            ScreeningLimits {
                most: 2 * lists[1],
                first_effects: usize::MAX,
                factor: DROPPED_CHI2_RATIO,
                surplus: None,
            },
            &mut others,
        );
        let second: Vec<(Hypothesis, Fit)> = begun
            .into_par_iter()
            .filter_map(|(h, f)| {
                let further = fit(&h, &f.at, self.thin(), &[(lower, 4)]).ok()?;
                Some((h, further))
            })
            .collect();
        let limits =
            ScreeningLimits { most: lists[1], first_effects: 2 * PAIR_SEEDS, factor: 10.0, surplus: Some(100.0) };
        let second = ahead(second, limits, &mut others);
        (self.progress)("finalists");
        let third: Vec<(Hypothesis, Fit)> = second
            .into_par_iter()
            .filter_map(|(h, f)| {
                let further = fit(&h, &f.at, self.leading(Subset::ALL), &[(lower, 4)]).ok()?;
                Some((h, further))
            })
            .collect();
        let limits = ScreeningLimits { most: lists[2], first_effects: PAIR_SEEDS, factor: 4.0, surplus: Some(50.0) };
        let third = ahead(third, limits, &mut others);
        let mut finalists: Vec<Candidate> = third
            .par_iter()
            .filter_map(|(h, f)| self.finish(&with(h), &f.at, lower, Subset::ALL).ok())
            .filter(matters)
            .collect();
        self.add_like_masses(&mut finalists, lower);
        self.rank(&mut finalists);
        if finalists.first().is_some_and(explains) {
            self.move_finalist(&mut finalists)?;
        }
        Ok(ScreeningRound { finalists, others })
    }

    /// Adds strong effects of every size to the finalists of a round that explains nothing, and moves the best; whether
    /// it did.
    pub(crate) fn add_strong(&self, standing: &Standing, round: &mut ScreeningRound) -> Result<bool, DiagnoseError> {
        let finalists = &mut round.finalists;
        // What passes at 1 % moves no resonance by its width: a linear step has found it.
        let strong = self.seeks_strong && standing.working_error >= STRONG_FROM;
        if !strong || is_settled(standing) || finalists.first().is_some_and(|c| self.within(c)) {
            return Ok(false);
        }
        (self.progress)("strong effects of any size");
        finalists.extend(self.of_any_size(standing)?);
        self.add_like_masses(finalists, standing.working_error);
        self.rank(finalists);
        self.move_finalist(finalists)?;
        Ok(true)
    }

    /// Adds each hypothesis of the catalogue to a standing, and where that explains nothing, strong effects of every
    /// size.
    pub(super) fn full_round(&self, standing: &Standing) -> Result<ScreeningRound, DiagnoseError> {
        let mut round = self.run_round(standing)?;
        self.add_strong(standing, &mut round)?;
        Ok(round)
    }

    /// Whether a candidate explains the data with nuisance parameters that stay within their priors.
    pub(crate) fn within(&self, candidate: &Candidate) -> bool {
        explains(candidate) && !self.model.is_strained(&candidate.fit.at.p)
    }

    /// Best first. Whoever reaches a lower model error is ahead; at one model error, what explains the data within the
    /// priors is ahead; then the score counts. What drives nuisance parameters out of their priors is no explanation,
    /// but may be one of two effects.
    pub(super) fn rank(&self, finalists: &mut [Candidate]) {
        finalists.sort_by(|a, b| {
            (a.model_error.total_cmp(&b.model_error))
                .then(self.within(b).cmp(&self.within(a)))
                .then(a.score().total_cmp(&b.score()))
        });
    }

    /// Least score of one effect that explains thinned lines, if any does: what does not has no part in a tie.
    pub(crate) fn one_effect_thinly(&self, null: &Standing) -> Result<Option<f64>, DiagnoseError> {
        let w = null.working_error;
        let mut begun = self.first_fits(null, self.free(&[], is_settled(null)), MIMICS)?;
        begun.sort_by(|a, b| score(&a.1).total_cmp(&score(&b.1)));
        begun.truncate(MIMICS / 2);
        let down: Vec<Stage> = (MODEL_ERRORS.into_iter().filter(|e| *e <= w)).map(|e| (e, 4)).collect();
        let ends = begun.par_iter().filter_map(|(h, f)| {
            let one = std::slice::from_ref(h);
            self.problem(one, self.thin()).fit(&f.at, &down).ok()
        });
        let explains = |end: &Fit| !fails(end) && !self.model.is_strained(&end.at.p);
        let scores = ends.filter(explains).map(|end| score(&end));
        Ok(scores.collect::<Vec<f64>>().into_iter().reduce(f64::min))
    }

    /// The lines that rank hypotheses.
    pub(crate) fn thin(&self) -> Subset {
        Subset { stride: (self.evidence.lines() / LINES).max(3), ..Subset::ALL }
    }

    /// The lines of `usage` to which finalists are fitted above the final model error.
    pub(super) fn leading(&self, usage: Subset) -> Subset {
        let stride = (self.evidence.lines() / FINALIST_LINES).max(1);
        Subset { stride: stride * usage.stride, ..usage }
    }

    /// Hypotheses of the catalogue that are not among the present ones.
    fn free(&self, present: &[Hypothesis], settled: bool) -> Vec<Hypothesis> {
        let mut free: Vec<Hypothesis> = vec![];
        for h in self.catalogue {
            let taken = |p: &Hypothesis| p.same_name(h) && p.kind != EffectKind::HousingMode;
            let mut h = h.clone();
            // What is missing then is small: of a joint, from the rigid one on. A housing needs a frequency.
            if settled && h.kind != EffectKind::HousingMode {
                h.start = h.nothing();
            }
            if !present.iter().any(taken) && !free.contains(&h) {
                free.push(h);
            }
        }
        free
    }

    /// A linear step for every hypothesis, and a fit on thinned lines of the `most` with the smallest predicted χ².
    fn first_fits(
        &self,
        standing: &Standing,
        free: Vec<Hypothesis>,
        most: usize,
    ) -> Result<Vec<(Hypothesis, Fit)>, DiagnoseError> {
        let (present, w) = (&standing.candidate.effects, standing.working_error);
        let settled = is_settled(standing);
        let with = |h: &Hypothesis| beside_present(present, h);
        let screen = if settled { Subset::ALL } else { self.thin() };
        // Where the nuisance parameters fit the data, the step starts from their fit.
        let origin = if settled { &standing.candidate.fit.at } else { &standing.from };
        let problem = self.problem(present, screen);
        let base = problem.linear(origin, w)?;
        let enough = standing.candidate.fit.chi2 - 0.5 * FURTHER_EFFECT_BIC_GAIN;
        let sized = |h: &Hypothesis| assembled_with_size(h.kind) || h.start != h.nothing();
        let (with_size, without): (Vec<_>, Vec<_>) = free.into_iter().partition(sized);
        // What has no size yet shares one linearisation.
        let steps = if without.is_empty() { vec![] } else { problem.predicted_beside(&base, origin, w, &without)? };
        let both = without.into_iter().zip(steps);
        let mut screened: Vec<Screened> = both.map(|(h, (at, chi2))| (h, at, chi2)).collect();
        let each = with_size.into_par_iter().filter_map(|h| {
            let with = with(&h);
            let problem = self.problem(&with, screen);
            let step = problem.predict_minimum(&base, &beside(origin, &h), w);
            let (at, chi2) = step.ok()?;
            Some((h, at, chi2))
        });
        screened.par_extend(each);
        screened.retain(|s| !settled || s.2 < enough);
        let kept = shortlist(self.best_starts(screened, &with, origin, w), most);
        let stages = first_stages(standing);
        let fits = kept.par_iter().filter_map(|(h, at, _)| {
            let with = with(h);
            let problem = self.problem(&with, self.thin());
            let (start, _) = problem.downhill(&beside(origin, h), at, w).ok()?;
            let found = problem.fit(&start, &stages).ok()?;
            Some((h.clone(), found))
        });
        Ok(fits.collect())
    }

    /// Two starts of every name, where there are more: those with the smallest χ² after the step; and the one with the
    /// smallest predicted χ². A step is linear, and where an effect is large the prediction hardly tells one place from
    /// another; the places themselves do, unless the step goes too far. All starts of a name share its best prediction.
    fn best_starts(
        &self,
        all: Vec<Screened>,
        with: &(impl Fn(&Hypothesis) -> Vec<Hypothesis> + Sync),
        origin: &Point,
        model_error: f64,
    ) -> Vec<Screened> {
        let twins = |h: &Hypothesis| all.iter().filter(|o| o.0.same_name(h)).count();
        let reached: Vec<f64> = all
            .par_iter()
            .map(|(h, at, chi2)| {
                if twins(h) <= STARTS {
                    return 0.0;
                }
                let before = all.iter().filter(|o| o.0.same_name(h) && o.2 < *chi2);
                if before.count() >= PLACES {
                    return f64::INFINITY;
                }
                let with = with(h);
                let problem = self.problem(&with, self.thin());
                let there = problem.downhill(&beside(origin, h), at, model_error);
                there.map_or(f64::INFINITY, |(_, chi2)| chi2)
            })
            .collect();
        let kept = (0..all.len()).filter_map(|i| {
            let (h, at, _) = &all[i];
            let same = || (0..all.len()).filter(|j| all[*j].0.same_name(h));
            let rank = same().filter(|j| (reached[*j], *j) < (reached[i], i)).count();
            let predicted = same().filter(|j| (all[*j].2, *j) < (all[i].2, i)).count();
            let best = same().map(|j| all[j].2).fold(f64::INFINITY, f64::min);
            (rank < STARTS || predicted < 1).then(|| (h.clone(), at.clone(), best))
        });
        kept.collect()
    }
}

/// Whether nothing fails: a linear step on all lines tells then what is worth a fit.
fn is_settled(standing: &Standing) -> bool {
    let residuals = standing.candidate.fit.residuals;
    standing.working_error == FINAL_MODEL_ERROR && standing.failure < failing_chi2(residuals)
}

/// Model errors of first fits: from a larger one again, as the nuisance parameters were fitted without the new effect.
fn first_stages(standing: &Standing) -> Vec<Stage> {
    let w = standing.working_error;
    if is_settled(standing) { vec![(w, 4)] } else { vec![(3.0 * w, 3), (w, 2)] }
}

fn score(fit: &Fit) -> f64 {
    let free: usize = fit.at.theta.last().map_or(0, Vec::len);
    fit.chi2 + free as f64 * (fit.residuals.max(2) as f64).ln()
}

/// Whether a candidate leaves no more than noise and the final model error do.
pub(crate) fn explains(candidate: &Candidate) -> bool {
    candidate.model_error == FINAL_MODEL_ERROR && !fails(&candidate.fit)
}

/// Whether the newest effect of a candidate is large enough to be named.
pub(super) fn matters(candidate: &Candidate) -> bool {
    let newest = candidate.effects.last().zip(candidate.fit.at.theta.last());
    newest.is_none_or(|(h, theta)| h.matters(theta))
}

/// Which hypotheses a stage keeps beside its best.
struct ScreeningLimits {
    most: usize,
    /// Most where the best one fails: the first effects of pairs.
    first_effects: usize,
    /// Largest multiple of the best χ² while the best one fails too.
    factor: f64,
    /// Largest χ² above the best where that does not fail: a smaller model error makes every distance larger. None
    /// after first fits, where the factor counts either way and resonances, whose χ² falls late, are kept.
    surplus: Option<f64>,
}

/// Best start of every name, best score first, within the limits; the others are added to `others`.
fn ahead(
    mut all: Vec<(Hypothesis, Fit)>,
    limits: ScreeningLimits,
    others: &mut Vec<(Effect, f64)>,
) -> Vec<(Hypothesis, Fit)> {
    all.sort_by(|a, b| score(&a.1).total_cmp(&score(&b.1)));
    let Some((best, limit, most)) = all.first().map(|(_, best)| {
        let fails = fails(best);
        let limit = match limits.surplus {
            Some(surplus) if !fails => best.chi2 + surplus,
            _ => limits.factor * best.chi2 + 100.0,
        };
        let most = limits.most.min(if fails { limits.first_effects } else { usize::MAX });
        (score(best), limit, most)
    }) else {
        return all;
    };
    let mut kept: Vec<(Hypothesis, Fit)> = vec![];
    for (h, fit) in all {
        if kept.iter().any(|k| k.0.same_name(&h)) {
            continue;
        }
        let resonance = h.sole() || h.kind == EffectKind::HousingMode;
        let late = limits.surplus.is_none() && resonance;
        if kept.len() < most && (fit.chi2 <= limit || late) {
            kept.push((h, fit));
        } else if let Some(theta) = fit.at.theta.last() {
            others.push((h.effect(theta), score(&fit) - best));
        }
    }
    kept
}

type Screened = (Hypothesis, Point, f64);

/// Whether a hypothesis is the same kind at another axis than a better one. A gain of x that is up and one of y that is
/// down differ by the gain of their bearing alone, which is a nuisance parameter: they are rivals.
fn is_of_lesser_axis(h: &Hypothesis, better: &Hypothesis) -> bool {
    let (Location::Axis(a), Location::Axis(b)) = (&h.place, &better.place) else { return false };
    let gain = matches!(h.kind, EffectKind::SensorGain | EffectKind::ForceConstant);
    h.kind == better.kind && !(gain && a ^ 1 == *b)
}

/// Hypotheses by predicted χ²: the best `most`, of those of one axis the best of each kind, and one start of each
/// effect that has one place only (a sharp resonance that moves far is not predicted by a linear step).
fn shortlist(mut all: Vec<Screened>, most: usize) -> Vec<Screened> {
    all.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut kept: Vec<Screened> = vec![];
    for entry in all {
        let first = !kept.iter().any(|k| k.0.same_name(&entry.0));
        if first && kept.iter().any(|k| is_of_lesser_axis(&entry.0, &k.0)) {
            continue;
        }
        if first && entry.0.sole() || kept.len() < most {
            kept.push(entry)
        }
    }
    kept
}
