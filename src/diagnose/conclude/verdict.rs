//! From data to verdict: `adequate`, `named`, `tie` or `unexplained`, with the corrected machine and the gap before and
//! after.
//!
//! `selection` finds the effects. A name is given only when the whole then explains the data; else the verdict
//! is `unexplained`. Rivals of equal score are a tie. Held-out data (hammer tests, or the channels between the
//! bearings) are predicted from a fit that has not seen them.

use super::super::DiagnoseError;
use super::super::data::evidence::Evidence;
use super::super::decide::candidate::{Candidate, Standing};
use super::super::decide::detectability::{Detectable, detectable};
use super::super::decide::judgement::{Judgement, Verdict, judge, lowers_the_gap, overall, relieves};
use super::super::decide::misfit::Misfit;
use super::super::decide::next_measurement::{Proposal, proposals};
use super::super::decide::residuals::{Fitted, MeasuredChannel, channels, gaps};
use super::super::decide::selection::{Chosen, choose};
use super::super::decide::tie::indistinguishable;
use super::super::fit::hypothesis::{self, Hypothesis, Scope, catalogue};
use super::super::fit::model::{FurtherOff, Model};
use super::super::fit::problem::Point;
use super::super::locate::correction::{Correction, correct};
use super::super::locate::localisation::{Localisation, localise};
use super::super::records::finding::FoundFault;
use super::super::records::trial::Trial;
use crate::diagnose::fit::case::Case;
use crate::identify::polluted::PollutedLines;
use crate::identify::{HammerFrf, SweepRecord};
use crate::spindle::{Effect, EffectKind, Location, Machine};

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

impl From<Effect> for NamedEffect {
    /// An effect of which nothing more is known.
    fn from(effect: Effect) -> Self {
        Self { effect, standard_deviations: vec![], intervals: vec![], position_sd_m: None }
    }
}

/// A rival explanation.
#[derive(Clone, Debug, PartialEq)]
pub struct Rival {
    /// Its effects.
    pub effects: Vec<NamedEffect>,
    /// What it says is wrong with the records.
    pub record_faults: Vec<FoundFault>,
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
    /// Effects that the records show and that are too small for a name; they are not in the corrected machine.
    pub small_effects: Vec<NamedEffect>,
    /// The best explanation, even where it is not good enough to be named.
    pub nearest: Vec<Effect>,
    /// The gap that the best explanation leaves over all records.
    pub gap_nearest: f64,
    /// Whether the nearest explanation is a sensor offset, and sensors that read the slope of the shaft on such an arm
    /// are nearer.
    pub slope_read: bool,
    /// Nuisance parameters that the best explanation drives beyond what their priors allow, with how many standard
    /// deviations, the furthest first: what is missing shows in them.
    pub strained: Vec<(String, f64)>,
    /// Numbers of the machine that are further off than a careful updating leaves, the furthest first; empty unless
    /// such a machine explains the records better than several effects.
    pub further_off: Vec<FurtherOff>,
    /// Members of a tie, the best first; empty otherwise.
    pub tie: Vec<Rival>,
    /// Best explanations at the last case, best first: names with score above the best.
    pub ranking: Vec<(Effect, f64)>,
    /// Fall of the score by the best single effect, at least; an effect is named from
    /// `FIRST_EFFECT_BIC_GAIN` on.
    pub strength: f64,
    /// The machine with effects and nuisance parameters.
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
    /// Nuisance parameters of the fit.
    pub small: Vec<f64>,
    /// Measured, model before and model after, channel by channel.
    pub channels: Vec<MeasuredChannel>,
    /// What stands in for a name when the verdict is unexplained.
    pub correction: Option<Correction>,
    /// Measurements that would separate the members of a tie, the most separating first.
    pub menu: Vec<Proposal>,
    /// Smallest size of each effect of the catalogue that these data would show beside what was named; empty when
    /// unexplained.
    pub detectable: Vec<Detectable>,
    /// Score of the best explanation; infinite where it does not explain the records.
    pub score: f64,
    /// What is wrong with the records; of a tie, under the best explanation.
    pub record_faults: Vec<FoundFault>,
    /// Lines of the sweeps that something outside the loop disturbs; the verdict is about the others.
    pub polluted_lines: Vec<PollutedLines>,
    /// The sweeps without these faults.
    pub sweeps: Vec<SweepRecord>,
    /// The hammer tests without these faults.
    pub hammers: Vec<HammerFrf>,
}

impl Diagnosis {
    /// Gaps before and after of the records that were held out, or of those that were used, for the machine fitted to
    /// the used ones.
    pub fn gaps(&self, held_out: bool) -> (f64, f64) {
        gaps(&self.channels, |c| c.held_out == held_out)
    }
}

/// The diagnosis of records without `faults`, with at most so many effects.
pub(super) fn conclude(
    trial: &Trial,
    null: &Standing,
    (faults, most): (Vec<FoundFault>, usize),
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    conclude_unless(trial, null, (faults, most), &|_, _| Ok(Instead::Nothing), progress)
}

/// What explains records that no single effect explains.
pub(super) enum Instead {
    /// This does.
    Found(Box<Diagnosis>),
    /// Something that is to be compared with what a search without strong effects finds.
    Rival,
    Nothing,
}

/// Looks for it, beside the best single effects and where a free law finds what is missing.
pub(super) type LookElsewhere<'a> = &'a dyn Fn(&[Candidate], &Localisation) -> Result<Instead, DiagnoseError>;

/// The same, unless one effect does not explain the records and something else does.
pub(super) fn conclude_unless(
    trial: &Trial,
    null: &Standing,
    (faults, most): (Vec<FoundFault>, usize),
    elsewhere: LookElsewhere,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    let catalogue = hypotheses(&trial.machine, &trial.model, &trial.evidence)?;
    let mut case = trial.case(&catalogue, progress);
    progress("where it sits");
    let localisation = localise(&case)?;
    let mut round = case.run_round(null)?;
    case.add_located(&localisation, &mut round);
    if !round.finalists.first().is_some_and(|c| case.within(c)) {
        match elsewhere(&round.finalists, &localisation)? {
            Instead::Found(other) => return Ok(*other),
            Instead::Rival => case.seeks_strong = false,
            Instead::Nothing => {}
        }
    }
    case.add_strong(null, &mut round)?;
    let chosen = choose(&case, null, round, localisation.sole(), most)?;
    conclude_diagnosis(trial, &case, null, localisation, chosen, faults)
}

/// The diagnosis in which these effects were chosen.
pub(super) fn conclude_diagnosis(
    trial: &Trial,
    case: &Case,
    null: &Standing,
    localisation: Localisation,
    mut chosen: Chosen,
    faults: Vec<FoundFault>,
) -> Result<Diagnosis, DiagnoseError> {
    let mut best = chosen.standing.candidate.clone();
    let empty = best.effects.is_empty();
    let relieves = relieves(case, &null.candidate, &best);
    if !empty && !relieves && !lowers_the_gap(case, &null.candidate, &best)? {
        best = null.candidate.clone();
        chosen.rivals.clear();
    }
    (case.progress)("held-out records");
    let Judgement { mut verdict, misfit, held_out, before, trained, predicted, after, strained, slope_read } =
        judge(case, &best)?;
    let nameless = best.effects.iter().all(Hypothesis::is_nuisance);
    if verdict == Verdict::Adequate || verdict == Verdict::Named && nameless {
        verdict = if faults.is_empty() { Verdict::Adequate } else { Verdict::Named };
    }
    let members = match verdict {
        Verdict::Named if !nameless || empty => indistinguishable(case, &best, &chosen.rivals),
        _ => vec![&best],
    };
    let tie = match members.len() {
        0 | 1 => vec![],
        _ => rivals(&members, &best, &faults)?,
    };
    if !tie.is_empty() {
        verdict = Verdict::Tie;
    }
    let further_off = trial.model.further_off(&best.fit.at.p);
    if verdict == Verdict::Named && !best.effects.is_empty() && !further_off.is_empty() {
        verdict = Verdict::Probable;
    }
    let mut shown = ShownMachine::of(verdict, &best, &trained, null)?;
    let correction = match (verdict, localisation.named_port()) {
        (Verdict::Unexplained, Some(port)) => Some(correct(case, port, held_out.training)?),
        _ => None,
    };
    let (correction, shown_channels) = worthwhile(case, &shown, correction)?;
    let menu = match verdict {
        Verdict::Tie => proposals(case, &members)?,
        _ => vec![],
    };
    let detectable = match verdict {
        Verdict::Unexplained => vec![],
        // Beside a named effect, not beside small ones: their sizes are what is asked.
        _ if nameless => detectable(case, &[], &Point { theta: vec![], ..shown.point.clone() })?,
        _ => detectable(case, shown.hypotheses, shown.point)?,
    };
    // What is too small for a name is no part of the machine to design for.
    let small_effects = if nameless { shown.take_clear() } else { vec![] };
    let corrected = corrected_machine(trial, &shown);
    let taps = trial.measurement.taps.iter();
    Ok(Diagnosis {
        next_measurement: next_measurement(verdict, &menu),
        menu,
        detectable,
        gap_before: before.all,
        gap_after: overall(case, shown.hypotheses, shown.point)?.all,
        gap_before_held_out: before.held_out,
        gap_after_held_out: match verdict {
            Verdict::Unexplained => overall(case, &[], &null.from)?.held_out,
            _ => predicted.held_out,
        },
        held_out: held_out.name.into(),
        ranking: chosen.ranking,
        strength: chosen.strength,
        nearest: hypothesis::effects(&best.effects, &best.fit.at.theta),
        verdict,
        small: shown.point.p.clone(),
        effects: shown.effects,
        small_effects,
        tie,
        corrected,
        misfit,
        localisation,
        axis_gains: axis_gains(trial, shown.point),
        channels: shown_channels,
        correction,
        gap_nearest: after.all,
        slope_read,
        strained,
        further_off: if verdict == Verdict::Unexplained { vec![] } else { further_off },
        score: match verdict {
            Verdict::Unexplained => f64::INFINITY,
            _ => best.score(),
        },
        record_faults: faults,
        polluted_lines: vec![],
        sweeps: trial.measurement.sweeps.clone(),
        hammers: taps.map(|t| t.frf.clone()).collect(),
    })
}

/// Gain errors of the axes in each sweep.
fn axis_gains(trial: &Trial, point: &Point) -> Vec<[f64; 4]> {
    let gain = |sweep: usize, axis: usize| point.p[trial.model.layout.axis(sweep, axis)];
    let sweeps = 0..trial.evidence.sweeps.len();
    sweeps.map(|s| std::array::from_fn(|i| gain(s, i))).collect()
}

/// Explanations that the data do not tell apart, beside the best.
fn rivals(members: &[&Candidate], best: &Candidate, faults: &[FoundFault]) -> Result<Vec<Rival>, DiagnoseError> {
    let one = |member: &&Candidate| {
        Ok(Rival {
            effects: name_effects(member)?,
            record_faults: faults.to_vec(),
            score_above_best: member.score() - best.score(),
        })
    };
    members.iter().map(one).collect()
}

/// The correction where it improves held-out data, and the channels with it.
fn worthwhile(
    case: &Case<'_>,
    shown: &ShownMachine<'_>,
    correction: Option<Correction>,
) -> Result<(Option<Correction>, Vec<MeasuredChannel>), DiagnoseError> {
    let fitted = Fitted {
        small: shown.without_held_out.p.clone(),
        effects: hypothesis::effects(shown.hypotheses, &shown.without_held_out.theta),
    };
    let found = channels(case, &fitted, correction.as_ref())?;
    let (as_given, with_law) = gaps(&found, |c| c.held_out);
    if correction.is_some() && with_law >= as_given {
        // What makes predictions worse is no correction.
        return Ok((None, channels(case, &fitted, None)?));
    }
    Ok((correction, found))
}

/// The machine with effects and nuisance parameters. Gains of axes that are further off than calibration usually leaves
/// belong to the sensors, and are kept.
fn corrected_machine(trial: &Trial, shown: &ShownMachine) -> Machine {
    let layout = &trial.model.layout;
    let mut corrected = layout.machine.apply(&trial.machine, &shown.point.p);
    let effects = &mut corrected.spindle.effects;
    effects.extend(shown.effects.iter().map(|e| e.effect.clone()));
    for axis in 0..4 {
        let all = (0..layout.sweeps).map(|s| layout.axis(s, axis));
        let usual = all.clone().map(|k| layout.sd[k]).fold(0.0, f64::max);
        let mean = all.map(|k| shown.point.p[k]).sum::<f64>() / layout.sweeps.max(1) as f64;
        if mean.abs() <= usual {
            continue;
        }
        let place = Location::Axis(axis);
        let own = |e: &&mut Effect| e.kind == EffectKind::SensorGain && e.location == place;
        match effects.iter_mut().find(own) {
            Some(named) => named.values.iter_mut().for_each(|v| *v *= 1.0 + mean),
            None => effects.extend(Effect::new(EffectKind::SensorGain, place, vec![1.0 + mean])),
        }
    }
    corrected
}

/// Hypotheses that the records of a measurement can show.
pub(super) fn hypotheses(
    machine: &Machine,
    model: &Model,
    evidence: &Evidence,
) -> Result<Vec<Hypothesis>, DiagnoseError> {
    let sweeps = || evidence.sweeps.iter();
    let first = sweeps().filter_map(|s| s.omega_rad_s.first().copied());
    let last = sweeps().filter_map(|s| s.omega_rad_s.last().copied());
    let scope = Scope {
        turning: sweeps().any(|s| s.speed_rad_s != 0.0),
        first_rad_s: first.fold(f64::INFINITY, f64::min),
        top_rad_s: last.fold(0.0, f64::max),
    };
    let (span_m, modes) = (model.reduced.span_m(), model.reduced.flexible_rad_s());
    catalogue(machine, span_m, modes, scope)
}

/// What goes into files and pictures: what was named, or the machine as it is.
struct ShownMachine<'a> {
    effects: Vec<NamedEffect>,
    hypotheses: &'a [Hypothesis],
    point: &'a Point,
    /// The fit that has not seen the held-out records.
    without_held_out: &'a Point,
}

impl<'a> ShownMachine<'a> {
    /// Takes the effects away; those are returned that the records show, their 90 % interval without zero.
    fn take_clear(&mut self) -> Vec<NamedEffect> {
        let named = std::mem::take(&mut self.effects).into_iter().zip(self.hypotheses);
        let clear = named.filter(|(named, h)| {
            let nothing = h.effect(&h.nothing()).values;
            let both = named.intervals.iter().zip(nothing).take(1);
            both.into_iter().all(|((from, to), nothing)| nothing < *from || nothing > *to)
        });
        clear.map(|(named, _)| named).collect()
    }

    fn of(
        verdict: Verdict,
        best: &'a Candidate,
        trained: &'a Candidate,
        null: &'a Standing,
    ) -> Result<Self, DiagnoseError> {
        Ok(match verdict {
            Verdict::Unexplained => {
                Self { effects: vec![], hypotheses: &[], point: &null.from, without_held_out: &null.from }
            }
            _ => Self {
                effects: name_effects(best)?,
                hypotheses: &best.effects,
                point: &best.fit.at,
                without_held_out: &trained.fit.at,
            },
        })
    }
}

/// Effects of a candidate with standard deviations and 90 % intervals from the curvature.
fn name_effects(candidate: &Candidate) -> Result<Vec<NamedEffect>, DiagnoseError> {
    let covariance = candidate.fit.covariance()?;
    // Model error beyond noise and model error widens everything.
    let excess = (candidate.fit.data_chi2 / candidate.fit.residuals.max(1) as f64).max(1.0).sqrt();
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
            let slope = if step > 0.0 { (at(step) - at(-step)) / (2.0 * step) } else { 0.0 };
            deviations.push((slope * sd(i)).abs());
            // 1.645 σ on either side hold 90 % of a normal distribution in fit coordinates.
            let (a, b) = (at(-1.645 * sd(i)), at(1.645 * sd(i)));
            intervals.push((a.min(b), a.max(b)));
        }
        let placed = effect.location.position_m();
        let position_sd_m = placed.map(|_| h.slope(theta.len() - 1, theta) * sd(theta.len() - 1));
        column += theta.len();
        all.push(NamedEffect { effect, standard_deviations: deviations, intervals, position_sd_m });
    }
    Ok(all)
}

/// What to measure next: what separates the members of a tie most, or what tells kinds of the unexplained apart.
fn next_measurement(verdict: Verdict, menu: &[Proposal]) -> Option<String> {
    match verdict {
        Verdict::Unexplained => Some(
            "repeat the sweep at half the amplitude, and with a second sensor at the place the localisation names: \
             that tells a nonlinear or a sensor effect from a mechanical one"
                .into(),
        ),
        Verdict::Tie => menu.first().map(Proposal::words),
        _ => None,
    }
}
