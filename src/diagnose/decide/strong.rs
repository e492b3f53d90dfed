//! Effects that the shaft feels strongly: masses, the tool joint, and tilting stiffnesses.
//!
//! A linear step does not predict an effect that moves a sharp resonance by many times its width. Where nothing else
//! explains the data, every place is tried with such effects of every size. The row that a moment acts on goes up and
//! down along the shaft besides, from the rotation of the section at the ends of a part of an element to the slope with
//! the shear in its middle, so that a fit of its position ends between two nodes; it is begun again elsewhere.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::estimate::{FINAL_MODEL_ERROR, Fit, Stage};
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::model::Model;
use super::super::fit::problem::{Point, Problem};
use super::candidate::{Candidate, MODEL_ERRORS, Standing, fails, next_model_error};
use super::screening::{DROPPED_CHI2_RATIO, LINES, beside_present, explains, matters};
use crate::spindle::{Effect, EffectKind};
use rayon::prelude::*;

/// Further places of an effect from which a fit that failed is begun again.
const RELOCATED: usize = 8;
/// Effects that are tried with every size.
const STRONG: [EffectKind; 4] =
    [EffectKind::TiltingStiffness, EffectKind::ToolMass, EffectKind::AddedMass, EffectKind::ToolJoint];
/// Places of the whole shaft that are fitted, at the next model error as well, and down to the final one.
const PLACES: [usize; 3] = [16, 8, 2];
/// Part of the distance between the magnets within which a mass stands for a disc, and model errors at which its places
/// are compared, and places that are followed beyond the first of these.
const DISC_REACH_M_PER_M: f64 = 0.2;
const DISC_STAGES: usize = 3;
const DISC_PLACES: usize = 4;
/// Fits of a finalist at other places: thinned lines first.
const FINAL_STAGES: [Stage; 3] = [(0.01, 2), (0.003, 3), (FINAL_MODEL_ERROR, 3)];

impl Case<'_> {
    /// Begins tilting stiffnesses that fail from other places, unless another effect explains thinned lines down to
    /// the final model error. Each start is tried, as the place at which a fit ends depends on it, the best one first:
    /// where that stays among what is dropped, the others do too.
    pub(super) fn move_tilting(
        &self,
        fits: &mut [(Hypothesis, Fit)],
        with: &(impl Fn(&Hypothesis) -> Vec<Hypothesis> + Sync),
        stages: Vec<Stage>,
    ) -> Result<(), DiagnoseError> {
        let order = |i: &usize, j: &usize| fits[*i].1.chi2.total_cmp(&fits[*j].1.chi2);
        let failing = |i: &usize| {
            let (h, fit) = &fits[*i];
            h.kind == EffectKind::TiltingStiffness && fails(fit)
        };
        let mut moved: Vec<usize> = (0..fits.len()).filter(failing).collect();
        moved.sort_by(order);
        let Some((best, (w, _))) = (0..fits.len()).min_by(order).zip(stages.last()) else {
            return Ok(());
        };
        let (h, fit) = &fits[best];
        if !moved.is_empty() && !fails(fit) {
            let with = with(h);
            let down = MODEL_ERRORS.into_iter().filter(|e| e < w);
            let down: Vec<Stage> = down.map(|e| (e, 4)).collect();
            let end = self.problem(&with, self.thin()).fit(&fit.at, &down)?;
            if !fails(&end) && !self.model.is_strained(&end.at.p) {
                return Ok(());
            }
        }
        let limit = DROPPED_CHI2_RATIO * fit.chi2 + 100.0;
        for i in moved {
            let (h, found) = &fits[i];
            let with = with(h);
            let problem = self.problem(&with, self.thin());
            let next = self.refit_place(&problem, h, found.clone(), &stages);
            let dropped = next.chi2 > limit;
            fits[i].1 = next;
            if dropped {
                break;
            }
        }
        Ok(())
    }

    /// A fit, or a better one from another place with the numbers that it found: where the row of an effect goes up and
    /// down along the shaft, a fit stays between two nodes. A step, on half of the lines where there are many, ranks
    /// the places; those with the smallest χ² are fitted.
    fn refit_place(&self, problem: &Problem, h: &Hypothesis, found: Fit, stages: &[Stage]) -> Fit {
        let Some((w, _)) = stages.last().copied() else {
            return found;
        };
        // On fewer lines than these the wrong place may have the smallest χ².
        let enough = self.evidence.lines() / problem.usage.stride >= LINES;
        let half = Problem {
            usage: Subset { stride: if enough { 2 } else { 1 } * problem.usage.stride, ..problem.usage },
            ..*problem
        };
        let places = self.catalogue.par_iter().filter(|o| o.same_name(h));
        let ahead = places.filter_map(|other| {
            let at = found.at.with_newest_at(other)?;
            half.fit(&at, &[(w, 1)]).ok()
        });
        let ahead = lowest(ahead.collect(), |fit: &Fit| fit.chi2, RELOCATED);
        let tried = ahead.par_iter().filter_map(|fit| problem.fit(&fit.at, &[(w, 2)]).ok());
        let tried = lowest(tried.collect(), |fit: &Fit| fit.chi2, RELOCATED / 2);
        let refined = tried.into_iter().filter_map(|fit| problem.fit(&fit.at, stages).ok());
        refined.fold(found, |best, next| if next.chi2 < best.chi2 { next } else { best })
    }

    /// The best strong effects beside a standing, of any size at any place.
    pub(super) fn of_any_size(&self, standing: &Standing) -> Result<Vec<Candidate>, DiagnoseError> {
        let each = STRONG.into_iter().map(|kind| self.best_of_any_size(standing, kind));
        let all = each.collect::<Result<Vec<_>, _>>()?;
        Ok(all.into_iter().flatten().collect())
    }

    /// Those of one kind: at each place the size with the smallest χ² is where a fit begins.
    fn best_of_any_size(&self, standing: &Standing, kind: EffectKind) -> Result<Vec<Candidate>, DiagnoseError> {
        let (present, w) = (&standing.candidate.effects, standing.working_error);
        let mut places: Vec<&Hypothesis> = vec![];
        for h in self.catalogue.iter().filter(|h| h.kind == kind) {
            let taken = present.iter().any(|p| p.same_name(h));
            if !taken && places.iter().all(|other| other.place != h.place) {
                places.push(h);
            }
        }
        // Nuisance parameters that stand in for what is missing lead away from it.
        let mut origin = standing.from.clone();
        origin.p.fill(0.0);
        let sizes = sizes(kind);
        // Sizes are compared, not fitted: what a mass changes of the damping does not count.
        let compared = Model { masses_at_ports: true, ..self.model.clone() };
        let begun = places.par_iter().filter_map(|h| {
            let effects = beside_present(present, h);
            let problem = Problem { model: &compared, ..self.problem(&effects, self.thin()) };
            let sized = |size: &Vec<f64>| {
                let mut at = origin.clone();
                let mut theta = h.start.clone();
                theta.iter_mut().zip(size).for_each(|(t, s)| *t = *s);
                h.clamp(&mut theta);
                let effect = h.effect(&theta);
                if problem.lightest_kg(&effect).zip(effect.values.first()).is_some_and(|(least, value)| *value < least)
                {
                    return None;
                }
                at.theta.push(theta);
                let chi2 = problem.chi2(&at, w).ok()?;
                Some((at, chi2, size.clone()))
            };
            let least = |a: &Sized, b: &Sized| a.1.total_cmp(&b.1);
            let coarse = sizes.iter().filter_map(sized).min_by(least)?;
            let closer = sizes_beside(kind, &coarse.2);
            let closer = closer.iter().filter_map(sized);
            let (at, chi2, _) = closer.chain([coarse]).min_by(least)?;
            Some((*h, at, chi2))
        });
        let begun = lowest(begun.collect(), |found: &(&Hypothesis, Point, f64)| found.2, PLACES[0]);
        let begun = begun.into_par_iter().filter_map(|(h, at, _)| {
            let effects = beside_present(present, h);
            Some((h, self.problem(&effects, self.thin()).fit(&at, &[(w, 2)]).ok()?))
        });
        let chi2 = |found: &(&Hypothesis, Fit)| found.1.chi2;
        let begun = lowest(begun.collect(), chi2, PLACES[1]);
        let lower = next_model_error(w);
        let followed = begun.into_par_iter().filter_map(|(h, fit)| {
            let effects = beside_present(present, h);
            let problem = self.problem(&effects, self.thin());
            Some((h, problem.fit(&fit.at, &[(w, 2), (lower, 4)]).ok()?))
        });
        let followed = lowest(followed.collect(), chi2, PLACES[2]);
        let ends = followed.into_par_iter().filter_map(|(h, fit)| {
            let effects = beside_present(present, h);
            self.finish(&effects, &fit.at, lower, Subset::ALL).ok()
        });
        Ok(ends.filter(matters).collect())
    }

    /// Adds what finalists that end with a mass may stand for, with that mass, fitted from the model error `top`: the
    /// best one on the tool a mass at its tip, where a linear step goes too far as soon as a resonance moves by many of
    /// its widths; those that explain nothing a disc.
    pub(super) fn add_like_masses(&self, finalists: &mut Vec<Candidate>, top: f64) {
        let mass = |c: &Candidate| {
            let (h, theta) = (c.effects.last()?, c.fit.at.theta.last()?);
            (h.kind == EffectKind::AddedMass).then(|| h.effect(theta))
        };
        // The nose face of the spindle is at zero.
        let on_tool = |e: &Effect| e.location.position_m().is_some_and(|z| z < 0.0);
        let tip = finalists.iter().find(|c| mass(c).as_ref().is_some_and(on_tool));
        let tip = tip.and_then(|c| {
            let (effects, at) = self.like_mass(c, EffectKind::ToolMass)?;
            self.finish(&effects, &at, top, Subset::ALL).ok()
        });
        let heavier = |e: Effect| e.values.first().is_some_and(|mass_kg| *mass_kg > 0.0);
        let unexplained = finalists.iter().filter(|c| mass(c).is_some_and(heavier) && !explains(c));
        let discs = unexplained.filter_map(|c| self.disc_like(c, top));
        let found: Vec<Candidate> = tip.into_iter().chain(discs).filter(matters).collect();
        for found in found {
            let rank = |c: &Candidate| (c.model_error, c.score());
            let newest = found.effects.last();
            let same = |c: &&mut Candidate| {
                let both = c.effects.last().zip(newest);
                both.is_some_and(|(a, b)| a.same_name(b))
            };
            match finalists.iter_mut().find(same) {
                Some(known) if rank(known) <= rank(&found) => {}
                Some(known) => *known = found,
                None => finalists.push(found),
            }
        }
    }

    /// A set with a disc in place of its newest effect, a mass. A mass alone stands beside the place of the disc, from
    /// which a fit does not come to it: of the places of a tilting stiffness near the mass that with the smallest χ².
    fn disc_like(&self, c: &Candidate, top: f64) -> Option<Candidate> {
        let (effects, mut at) = self.like_mass(c, EffectKind::AddedDisc)?;
        // Nuisance parameters that stand in for the inertia keep the mass where it is.
        at.p.fill(0.0);
        let problem = self.problem(&effects, self.thin());
        let reach = DISC_REACH_M_PER_M * self.model.reduced.machine.spindle.planes.bearing_span_m();
        let z = effects.last()?.effect(at.theta.last()?).location.position_m()?;
        let near = self.catalogue.par_iter().filter(|o| {
            let apart = o.place.position_m().map_or(f64::INFINITY, |own| (own - z).abs());
            o.kind == EffectKind::TiltingStiffness && apart < reach
        });
        let stages: Vec<Stage> =
            MODEL_ERRORS.into_iter().filter(|e| *e <= top).take(DISC_STAGES).map(|e| (e, 3)).collect();
        let (first, later) = stages.split_at_checked(1)?;
        let begun = near.filter_map(|place| problem.fit(&at.with_newest_at(place)?, first).ok());
        let begun = lowest(begun.collect(), |fit: &Fit| fit.chi2, DISC_PLACES);
        let fits = begun.into_par_iter().filter_map(|fit| problem.fit(&fit.at, later).ok());
        let best = lowest(fits.collect(), |fit: &Fit| fit.chi2, 1).pop()?;
        self.finish(&effects, &best.at, stages.last()?.0, Subset::ALL).ok()
    }

    /// A set with an effect of another kind in place of its newest one, a mass, of the same mass at the same place;
    /// none where the set has that effect already.
    fn like_mass(&self, c: &Candidate, kind: EffectKind) -> Option<(Vec<Hypothesis>, Point)> {
        let (h, theta) = (c.effects.last()?, c.fit.at.theta.last()?);
        let other = self.catalogue.iter().find(|other| other.kind == kind)?;
        if c.effects.iter().any(|e| e.same_name(other)) {
            return None;
        }
        let (mut effects, mut at) = (c.effects.clone(), c.fit.at.clone());
        let mut start = other.nothing();
        *start.first_mut()? = h.slope(0, theta) * theta.first()? / other.slope(0, &start);
        if other.place.position_m().is_some() {
            *start.last_mut()? = *theta.last()?;
        }
        *effects.last_mut()? = other.clone();
        *at.theta.last_mut()? = start;
        Some((effects, at))
    }

    /// Where the best finalist is a tilting stiffness or a disc at the final model error: the same at the place that
    /// fits best, of those of a tilting stiffness. Nuisance parameters that have left their priors fit the place where
    /// they are, so that every place is also tried with those of the machine as it is.
    pub(super) fn move_finalist(&self, finalists: &mut [Candidate]) -> Result<(), DiagnoseError> {
        let Some(best) = finalists.first_mut() else {
            return Ok(());
        };
        let turns = |h: &Hypothesis| matches!(h.kind, EffectKind::TiltingStiffness | EffectKind::AddedDisc);
        if best.model_error != FINAL_MODEL_ERROR || !best.effects.last().is_some_and(turns) {
            return Ok(());
        }
        let problem = self.problem(&best.effects, self.thin());
        let places = self.catalogue.par_iter().filter(|o| o.kind == EffectKind::TiltingStiffness);
        let mut starts = vec![best.fit.at.clone()];
        let (mut kept, mut from_error) = (PLACES[2], FINAL_MODEL_ERROR);
        if self.model.is_strained(&best.fit.at.p) {
            let p = self.origin().p;
            starts.push(Point { p, ..best.fit.at.clone() });
            // Before its nuisance parameters have settled, the right place may be behind.
            (kept, from_error) = (RELOCATED, FINAL_STAGES[1].0);
        }
        let both = places.flat_map_iter(|place| {
            let there = |start: &Point| start.with_newest_at(place);
            starts.iter().filter_map(there).collect::<Vec<Point>>()
        });
        let ranked = both.filter_map(|at| problem.fit(&at, &FINAL_STAGES[..1]).ok());
        let ranked = lowest(ranked.collect(), |fit: &Fit| fit.chi2, RELOCATED);
        let ends = ranked.par_iter().filter_map(|fit| problem.fit(&fit.at, &FINAL_STAGES[1..]).ok());
        let mut ends: Vec<Fit> = ends.collect();
        ends.push(problem.fit(&best.fit.at, &FINAL_STAGES[2..])?);
        for end in lowest(ends, |fit: &Fit| fit.chi2, kept) {
            let moved = self.finish(&best.effects, &end.at, from_error, Subset::ALL)?;
            let rank = |c: &Candidate| (self.model.is_strained(&c.fit.at.p), c.score());
            if rank(&moved) < rank(best) {
                *best = moved;
            }
        }
        Ok(())
    }
}

/// So many with the smallest χ², the best one first.
fn lowest<T>(mut found: Vec<T>, chi2: impl Fn(&T) -> f64, most: usize) -> Vec<T> {
    found.sort_by(|a, b| chi2(a).total_cmp(&chi2(b)));
    found.truncate(most);
    found
}

/// A point, its χ², and the numbers with which the newest effect is tried there.
type Sized = (Point, f64, Vec<f64>);

/// Ratio of the sizes with which a tilting stiffness, and a mass, is tried at every place.
const TILTING_RATIO: f64 = 3.0;
const MASS_RATIO: f64 = 2.25;

/// Numbers next to the best of [`sizes`], half way to its neighbours in the logarithm: from a tilting stiffness 1.7
/// times too large or too small, fits ended at a wrong place.
fn sizes_beside(kind: EffectKind, best: &[f64]) -> Vec<Vec<f64>> {
    let half = match kind {
        EffectKind::ToolJoint => return vec![],
        EffectKind::TiltingStiffness => TILTING_RATIO.sqrt(),
        _ => MASS_RATIO.sqrt(),
    };
    [half.recip(), half].map(|by| best.iter().map(|t| by * t).collect()).to_vec()
}

/// Numbers that an effect is tried with beside its position, in fit coordinates. Stiffnesses and masses have either
/// sign: a tilting stiffness from that of a light rotor's disc to the largest that is fitted, masses on a rotor of 8 kg
/// from 0.1 g at the tool and 1 g on the shaft. Joints from stiff ones to the softest of a small spindle, each with
/// little damping.
fn sizes(kind: EffectKind) -> Vec<Vec<f64>> {
    let up = |first: f64, ratio: f64, count: i32| (0..count).map(move |k| first * ratio.powi(k));
    let signed = |of: f64| [vec![-of], vec![of]];
    match kind {
        EffectKind::TiltingStiffness => up(0.01, TILTING_RATIO, 10).flat_map(signed).collect(),
        EffectKind::ToolJoint => {
            up(0.5, 2.0, 7).flat_map(|along| up(0.5, 2.0, 9).map(move |turning| vec![along, turning, 0.1])).collect()
        }
        _ => up(0.02, MASS_RATIO, 11).flat_map(signed).collect(),
    }
}
