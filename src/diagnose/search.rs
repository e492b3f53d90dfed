//! Which effects are missing: every catalogue entry is fitted jointly with the small parameters, the best is kept, and so on.
//!
//! A missing effect that is far too large for the noise makes a final fit meaningless, so a search works at the model floor at which
//! the present model just fails, from the fit at the floor before. Screening on thinned lines, then all lines, then the final
//! floor for what is still in the race. Score = χ² + d ln N (BIC). An effect is accepted when the score falls by [`ACCEPT`]:
//! with M ≈ 90 hypotheses of up to three numbers the 95 % quantile of the largest gain under the null is
//! 12 for one number and 17.5 for three, near d ln N alone; the surplus pays for correlated model error. It is smaller for the first effect
//! ([`ALONE`]): over 124 null records of an independent simulator it falls in seven, by 4.4 at most: a surplus of 5 leaves about one false alarm
//! in a hundred.

use super::DiagnoseError;
use super::evidence::{Evidence, Use, whiten};
use super::fit::{FINAL_FLOOR, Fit, Stage};
use super::hypothesis::{self, Hypothesis};
use super::model::Model;
use super::problem::{Point, Problem};
use crate::spindle::response::SIDE;
use crate::spindle::{Effect, EffectKind};
use rayon::prelude::*;

/// Model floors of a fit, coarse to fine.
const LADDER: [f64; 6] = [0.1, 0.03, 0.01, 0.003, 0.001, FINAL_FLOOR];
/// Iterations per rung.
const CLIMB: usize = 4;
/// Iterations at the last rung.
const FINISH: usize = 20;
/// χ² per residual above which a model fails at a floor. Where noise and floor describe the data it is below 1.
const FAILS: f64 = 1.0;
/// χ² per residual above which lower floors are not tried: what misses by that much will not fit more closely.
const HOPELESS: f64 = 10.0;
/// Least fall of the score for another effect.
pub const ACCEPT: f64 = 16.0;
/// Least fall for a first one: no large effect is there whose model error a small one could take up.
pub const ALONE: f64 = 5.0;
/// Scores closer than this cannot be told apart (odds of 1 to 30).
pub const TIE: f64 = 7.0;
/// Names that reach the thinned second screening, all lines, and the final floor.
const SHORT_LISTS: [usize; 3] = [24, 8, 5];
/// The same for a second effect.
const PAIR_LISTS: [usize; 3] = [16, 6, 4];
/// What is still so many times the leader's χ² after a first fit does not come down to it, a resonance that is on its way excepted.
const DISTANT: f64 = 3.0;
/// Starts of one name that are fitted.
const STARTS: usize = 2;
/// Names that reach the final floor where none of them explains the data: those that pairs are begun with; twice as many are fitted to all lines.
const BEGINNINGS: usize = 2;
/// A block of channels and lines whose χ² per residual exceeds this is not explained by noise: 240 residuals scatter by 0.1, noise that is not quite
/// white has reached 1.6.
pub const BLOCK_FAILS: f64 = 2.2;

/// A set of effects with its fit.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effects.
    pub effects: Vec<Hypothesis>,
    /// The fit, at `floor`.
    pub fit: Fit,
    /// Model floor of the fit.
    pub floor: f64,
}

impl Candidate {
    /// χ² + d ln N.
    pub fn score(&self) -> f64 {
        let free: usize = self.fit.at.theta.iter().map(Vec::len).sum();
        self.fit.chi2 + free as f64 * (self.fit.residuals.max(2) as f64).ln()
    }
}

/// The data, the model and the catalogue.
pub struct Search<'a> {
    /// The reduced machine.
    pub model: &'a Model,
    /// The data.
    pub evidence: &'a Evidence,
    /// All hypotheses.
    pub catalogue: &'a [Hypothesis],
    /// Told what is being done, and how far a round is.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

/// A model on the ladder: where it still fits, and where it fails.
#[derive(Clone, Debug)]
pub struct Standing {
    /// The last fit.
    pub candidate: Candidate,
    /// Fit from which further effects start.
    pub from: Point,
    /// Floor at which it fails, or the final one.
    pub working_floor: f64,
    /// χ² per residual there.
    pub failure: f64,
}

impl Standing {
    /// Whether this set brings the data closer within reach than another: a lower floor, or a fifth less χ² at the same one.
    pub fn nearer_than(&self, other: &Self) -> bool {
        self.working_floor < other.working_floor
            || self.working_floor == other.working_floor && self.failure < 0.8 * other.failure
    }
}

/// A point with a hypothesis at its start besides.
fn beside(origin: &Point, h: &Hypothesis) -> Point {
    let mut from = origin.clone();
    from.theta.push(h.start.clone());
    from
}

/// What a round found.
#[derive(Clone, Debug)]
pub struct Round {
    /// Finalists at the final floor, best score first.
    pub finalists: Vec<Candidate>,
    /// Effects that left the race before, with their score above the best when they left.
    pub others: Vec<(Effect, f64)>,
}

impl Search<'_> {
    fn problem<'b>(&'b self, effects: &'b [Hypothesis], usage: Use) -> Problem<'b> {
        Problem {
            model: self.model,
            evidence: self.evidence,
            usage,
            effects,
        }
    }

    /// The machine as it is.
    pub fn origin(&self) -> Point {
        Point {
            p: vec![0.0; self.model.layout.len()],
            theta: vec![],
        }
    }

    /// Climbs the ladder until the effects fail or the final floor is reached.
    ///
    /// # Errors
    /// [`DiagnoseError`] when a model cannot be assembled.
    pub fn stand(
        &self,
        effects: &[Hypothesis],
        from: &Point,
        usage: Use,
    ) -> Result<Standing, DiagnoseError> {
        let problem = self.problem(effects, usage);
        let (mut at, mut before) = (from.clone(), from.clone());
        let mut last = None;
        for floor in LADDER {
            let iterations = if floor == FINAL_FLOOR { FINISH } else { CLIMB };
            let fit = problem.fit(&at, &[(floor, iterations)])?;
            let fails = fit.data_chi2 > FAILS * fit.residuals as f64;
            at = fit.at.clone();
            last = Some((fit, floor));
            if fails {
                break;
            }
            before = at.clone();
        }
        let (fit, floor) = last.ok_or(DiagnoseError::NoSweep)?;
        Ok(Standing {
            failure: fit.data_chi2 / fit.residuals.max(1) as f64,
            candidate: Candidate {
                effects: effects.to_vec(),
                fit,
                floor,
            },
            from: before,
            working_floor: floor,
        })
    }

    /// Fits through all rungs from `top` down to the final floor, or to where it is hopeless.
    ///
    /// # Errors
    /// As [`Self::stand`].
    pub fn finish(
        &self,
        effects: &[Hypothesis],
        from: &Point,
        top: f64,
        usage: Use,
    ) -> Result<Candidate, DiagnoseError> {
        let problem = self.problem(effects, usage);
        let (mut at, mut last) = (from.clone(), None);
        for floor in LADDER.into_iter().filter(|f| *f <= top) {
            let iterations = if floor == FINAL_FLOOR { FINISH } else { CLIMB };
            let fit = problem.fit(&at, &[(floor, iterations)])?;
            let hopeless = fit.data_chi2 > HOPELESS * fit.residuals as f64;
            at = fit.at.clone();
            last = Some((fit, floor));
            if hopeless {
                break;
            }
        }
        let (fit, floor) = last.ok_or(DiagnoseError::NoSweep)?;
        Ok(Candidate {
            effects: effects.to_vec(),
            fit,
            floor,
        })
    }

    /// Adds each hypothesis of the catalogue to a standing.
    ///
    /// # Errors
    /// As [`Self::stand`].
    pub fn round(&self, standing: &Standing) -> Result<Round, DiagnoseError> {
        let present = &standing.candidate.effects;
        let w = standing.working_floor;
        let lists = if present.is_empty() {
            SHORT_LISTS
        } else {
            PAIR_LISTS
        };
        let thin = |stride| Use { stride, ..Use::ALL };
        let with = |h: &Hypothesis| -> Vec<Hypothesis> {
            let mut effects = present.clone();
            effects.push(h.clone());
            effects
        };
        // Where nothing fails, a linear step on all lines tells what is worth a fit.
        let settled = w == FINAL_FLOOR && standing.failure < FAILS;
        let mut free: Vec<Hypothesis> = vec![];
        for h in self.catalogue {
            let taken = |p: &Hypothesis| p.same_name(h) && p.kind != EffectKind::HousingMode;
            let mut h = h.clone();
            // What is missing then is small: of a joint, from the rigid one on.
            if settled && h.kind == EffectKind::ToolJoint {
                h.start = h.nothing();
            }
            if !present.iter().any(taken) && !free.contains(&h) {
                free.push(h);
            }
        }
        (self.progress)(&format!(
            "{} hypotheses, beside {} accepted",
            free.len(),
            present.len()
        ));
        let fit = |h: &Hypothesis, from: &Point, usage: Use, stages: &[Stage]| {
            self.problem(&with(h), usage).fit(from, stages)
        };
        let lower = rung_below(w);
        let screen = if settled { Use::ALL } else { thin(3) };
        // Where the small parameters have taken up nothing that the data deny, the step starts from their fit.
        let origin = if settled {
            &standing.candidate.fit.at
        } else {
            &standing.from
        };
        let base = self.problem(present, screen).linear(origin, w)?;
        let first: Vec<(Hypothesis, Point, f64)> = free
            .par_iter()
            .filter_map(|h| {
                let with = with(h);
                let problem = self.problem(&with, screen);
                let (at, chi2) = problem.predicted(&base, &beside(origin, h), w).ok()?;
                let hopeful = chi2 < standing.candidate.fit.chi2 - 0.5 * ACCEPT;
                (!settled || hopeful).then(|| (h.clone(), at, chi2))
            })
            .collect();
        let first = self.best_starts(first, &with, origin, w);
        let first = shortlist(first, lists[0]);
        // From a coarser floor again: the new effect may have moved what the small parameters had been fitted to.
        let stages: &[Stage] = if settled {
            &[(w, 4)]
        } else {
            &[(3.0 * w, 3), (w, 2)]
        };
        let begun: Vec<(Hypothesis, Fit)> = first
            .par_iter()
            .filter_map(|(h, at, _)| {
                let with = with(h);
                let problem = self.problem(&with, thin(3));
                let (start, _) = problem.downhill(&beside(origin, h), at, w).ok()?;
                Some((h.clone(), problem.fit(&start, stages).ok()?))
            })
            .collect();
        let mut others = vec![];
        let begun = ahead(
            begun,
            Gate {
                most: 2 * lists[1],
                beginnings: usize::MAX,
                factor: DISTANT,
                surplus: None,
            },
            &mut others,
        );
        let second: Vec<(Hypothesis, Fit)> = begun
            .into_par_iter()
            .filter_map(|(h, f)| {
                let further = fit(&h, &f.at, thin(3), &[(lower, 4)]).ok()?;
                Some((h, further))
            })
            .collect();
        let gate = Gate {
            most: lists[1],
            beginnings: 2 * BEGINNINGS,
            factor: 10.0,
            surplus: Some(100.0),
        };
        let second = ahead(second, gate, &mut others);
        (self.progress)("finalists");
        let third: Vec<(Hypothesis, Fit)> = second
            .into_par_iter()
            .filter_map(|(h, f)| {
                let all = fit(&h, &f.at, Use::ALL, &[(lower, 4)]).ok()?;
                Some((h, all))
            })
            .collect();
        let gate = Gate {
            most: lists[2],
            beginnings: BEGINNINGS,
            factor: 4.0,
            surplus: Some(50.0),
        };
        let third = ahead(third, gate, &mut others);
        let mut finalists: Vec<Candidate> = third
            .par_iter()
            .filter_map(|(h, f)| self.finish(&with(h), &f.at, lower, Use::ALL).ok())
            .filter(matters)
            .collect();
        // Whoever reaches a lower floor is ahead; at one floor the score counts.
        finalists.sort_by(|a, b| {
            a.floor
                .total_cmp(&b.floor)
                .then(a.score().total_cmp(&b.score()))
        });
        Ok(Round { finalists, others })
    }

    /// Two starts of every name, where there are more: those whose step leads lowest; and the one that promises most. A step is linear, and where
    /// an effect is large the prediction hardly tells one place from another; the places themselves do, unless the step goes too far. All
    /// starts of a name share its best prediction.
    fn best_starts(
        &self,
        all: Vec<Screened>,
        with: &(impl Fn(&Hypothesis) -> Vec<Hypothesis> + Sync),
        origin: &Point,
        floor: f64,
    ) -> Vec<Screened> {
        let usage = Use {
            stride: 3,
            ..Use::ALL
        };
        let twins = |h: &Hypothesis| all.iter().filter(|o| o.0.same_name(h)).count();
        let reached: Vec<f64> = all
            .par_iter()
            .map(|(h, at, _)| {
                if twins(h) <= STARTS {
                    return 0.0;
                }
                let with = with(h);
                let problem = self.problem(&with, usage);
                let there = problem.downhill(&beside(origin, h), at, floor);
                there.map_or(f64::INFINITY, |(_, chi2)| chi2)
            })
            .collect();
        let kept = (0..all.len()).filter_map(|i| {
            let (h, at, _) = &all[i];
            let same = || (0..all.len()).filter(|j| all[*j].0.same_name(h));
            let rank = same()
                .filter(|j| (reached[*j], *j) < (reached[i], i))
                .count();
            let promise = same().filter(|j| (all[*j].2, *j) < (all[i].2, i)).count();
            let best = same().map(|j| all[j].2).fold(f64::INFINITY, f64::min);
            (rank < STARTS || promise < 1).then(|| (h.clone(), at.clone(), best))
        });
        kept.collect()
    }

    /// Largest χ² per residual over blocks of channels and bands at a floor: 1 where noise explains everything.
    ///
    /// # Errors
    /// As [`Self::stand`].
    pub fn misfit(
        &self,
        effects: &[Hypothesis],
        at: &Point,
        floor: f64,
    ) -> Result<Misfit, DiagnoseError> {
        let named = hypothesis::effects(effects, &at.theta);
        let mut worst = Misfit::default();
        for (s, sweep) in self.evidence.sweeps.iter().enumerate() {
            let model = self
                .model
                .assemble(&at.p, &named, sweep.speed_rad_s, false)?;
            let lines = sweep.omega_rad_s.len();
            let bands = (lines / 60).clamp(1, 8);
            let mut sums = vec![[0.0; 16]; bands];
            let mut counts = vec![0usize; bands];
            for line in 0..lines {
                let band = line * bands / lines;
                let f = model.line(sweep.omega_rad_s[line], None).response;
                let rows = sweep.whitening(line, floor, true);
                for i in 0..4 {
                    let gain = 1.0 + at.p[self.model.layout.axis(s, i)];
                    let mut d: [_; 4] = std::array::from_fn(|j| {
                        sweep.response[line][4 * i + j] - f[SIDE * i + j] * gain
                    });
                    whiten(&rows[i], &mut d);
                    for j in 0..4 {
                        sums[band][4 * i + j] += 2.0 * d[j].norm_sqr();
                    }
                }
                counts[band] += 2;
            }
            for band in 0..bands {
                for n in 0..16 {
                    let value = sums[band][n] / counts[band].max(1) as f64;
                    if value > worst.value {
                        let edge = |b: usize| {
                            sweep.omega_rad_s[(b * lines / bands).min(lines - 1)]
                                / std::f64::consts::TAU
                        };
                        worst = Misfit {
                            value,
                            output: n / 4,
                            input: n % 4,
                            band_hz: (edge(band), edge(band + 1)),
                        };
                    }
                }
            }
        }
        Ok(worst)
    }
}

/// The worst block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Misfit {
    /// χ² per residual.
    pub value: f64,
    /// Sensor axis.
    pub output: usize,
    /// Current axis.
    pub input: usize,
    /// From, to, Hz.
    pub band_hz: (f64, f64),
}

fn rung_below(floor: f64) -> f64 {
    LADDER
        .into_iter()
        .find(|f| *f < floor)
        .unwrap_or(FINAL_FLOOR)
}

fn score(fit: &Fit) -> f64 {
    let free: usize = fit.at.theta.last().map_or(0, Vec::len);
    fit.chi2 + free as f64 * (fit.residuals.max(2) as f64).ln()
}

/// Whether the newest effect of a candidate is large enough to be named.
fn matters(candidate: &Candidate) -> bool {
    let newest = candidate.effects.last().zip(candidate.fit.at.theta.last());
    newest.is_none_or(|(h, theta)| h.matters(theta))
}

/// What may go on with the leader of a stage.
struct Gate {
    /// Most names.
    most: usize,
    /// Most where the leader fails: the beginnings of a pair.
    beginnings: usize,
    /// Largest χ² in terms of the leader's while that fails too: what is still to come down does not come down by more.
    factor: f64,
    /// Largest χ² above the leader's where that does not fail: a lower floor makes every distance larger. None after first fits, where the
    /// factor counts either way and resonances that are on their way go on.
    surplus: Option<f64>,
}

/// Best start of every name, best score first, as far as the gate is open; those that go are added to `others`.
fn ahead(
    mut all: Vec<(Hypothesis, Fit)>,
    gate: Gate,
    others: &mut Vec<(Effect, f64)>,
) -> Vec<(Hypothesis, Fit)> {
    all.sort_by(|a, b| score(&a.1).total_cmp(&score(&b.1)));
    let Some((best, limit, most)) = all.first().map(|(_, leader)| {
        let fails = leader.data_chi2 > FAILS * leader.residuals as f64;
        let limit = match gate.surplus {
            Some(surplus) if !fails => leader.chi2 + surplus,
            _ => gate.factor * leader.chi2 + 100.0,
        };
        let most = gate
            .most
            .min(if fails { gate.beginnings } else { usize::MAX });
        (score(leader), limit, most)
    }) else {
        return all;
    };
    let mut kept: Vec<(Hypothesis, Fit)> = vec![];
    for (h, fit) in all {
        if kept.iter().any(|k| k.0.same_name(&h)) {
            continue;
        }
        let resonance = h.sole() || h.kind == EffectKind::HousingMode;
        let on_its_way = gate.surplus.is_none() && resonance;
        if kept.len() < most && (fit.chi2 <= limit || on_its_way) {
            kept.push((h, fit));
        } else if let Some(theta) = fit.at.theta.last() {
            others.push((h.effect(theta), score(&fit) - best));
        }
    }
    kept
}

type Screened = (Hypothesis, Point, f64);

/// Hypotheses by predicted χ²: the best `most`, and one start of each effect that has one place
/// only (a sharp resonance that moves far is not predicted by a linear step).
fn shortlist(mut all: Vec<Screened>, most: usize) -> Vec<Screened> {
    all.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut kept: Vec<Screened> = vec![];
    for entry in all {
        let first = !kept.iter().any(|k| k.0.same_name(&entry.0));
        if first && entry.0.sole() || kept.len() < most {
            kept.push(entry)
        }
    }
    kept
}
