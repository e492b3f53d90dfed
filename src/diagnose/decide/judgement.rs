//! The verdict on a set of effects: its worst block, and records that its fit has not seen.

use super::super::DiagnoseError;
use super::super::data::evidence::{Gap, Subset, held_out};
use super::super::fit::case::Case;
use super::super::fit::estimate::FINAL_MODEL_ERROR;
use super::super::fit::hypothesis::{self, Hypothesis};
use super::super::fit::model::MOST_SD;
use super::super::fit::problem::Point;
use super::candidate::Candidate;
use super::imitation::imitates_a_lag;
use super::misfit::{FAILING_BLOCK_CHI2, Misfit};
use super::screening::TIE_BIC;
use crate::spindle::EffectKind;

/// Relative model error at which a named model must explain the data: what an independent simulation or a good test rig
/// leaves.
const JUDGE_FLOOR: f64 = 2e-3;

/// Gap on held-out records that noise and a model error of 0.5 % leave to a right explanation: 0.7 to 1.3 in an
/// independent simulation.
const PREDICTED: f64 = 1.5;
/// Most of the held-out gap that may remain else: a name that takes away less than seven tenths is one of many that
/// fit.
const REMAINS: f64 = 0.3;

/// Largest gap that several effects together may leave: right ones leave 0.7 to 1, several that stand for one law of no
/// catalogue more.
const MOST_GAP_OF_SEVERAL: f64 = 1.1;

/// Iterations of fits of a sensor offset and of an arm.
const SLOPE_ITERATIONS: usize = 6;

/// Largest held-out gap of a model that is called right: beyond three standard deviations no chance leads.
const MOST_HELD_OUT: f64 = 3.0;

named! {
    /// The verdicts.
    pub enum Verdict {
        /// Nothing is missing.
        Adequate = "adequate",
        /// The effects are named.
        Named = "named",
        /// The effects are named on a machine whose numbers are further off than careful work leaves.
        Probable = "probable",
        /// Several explanations fit alike.
        Tie = "tie",
        /// Something is missing that is in no catalogue.
        Unexplained = "unexplained",
    }
}

/// The verdict on a set of effects, and what it rests on.
pub(crate) struct Judgement {
    pub verdict: Verdict,
    pub misfit: Misfit,
    pub held_out: HeldOut,
    /// Gaps of the machine as it is.
    pub before: Overall,
    /// The set fitted without the held-out records.
    pub trained: Candidate,
    /// Its gaps.
    pub predicted: Overall,
    /// Gaps of the set fitted to all records.
    pub after: Overall,
    /// Nuisance parameters beyond their priors.
    pub strained: Vec<(String, f64)>,
    /// Whether sensors that read the slope explain more than a sensor offset of the set.
    pub slope_read: bool,
}

/// Judges a set of effects by its worst block, by the gap, and by records that its fit has not seen.
pub(crate) fn judge(case: &Case, best: &Candidate) -> Result<Judgement, DiagnoseError> {
    let misfit = case.misfit(&best.effects, &best.fit.at, JUDGE_FLOOR)?;
    let held_out = HeldOut::new(case);
    let before = overall(case, &[], &case.origin())?;
    let after = overall(case, &best.effects, &best.fit.at)?;
    let several = best.effects.iter().filter(|h| !h.is_nuisance()).count() > 1;
    let fits = best.model_error == FINAL_MODEL_ERROR
        && misfit.value < FAILING_BLOCK_CHI2
        && !(several && after.all > MOST_GAP_OF_SEVERAL);
    // What noise and the floor of the gap explain needs no other explanation.
    let explained = fits || after.all <= 1.0;
    let mut trained = case.finish(&best.effects, &best.fit.at, 0.001, held_out.training)?;
    let mut predicted = overall(case, &best.effects, &trained.fit.at)?;
    if predicted.held_out > PREDICTED {
        trained = better_trained(case, best, trained, held_out.training)?;
        predicted = overall(case, &best.effects, &trained.fit.at)?;
    }
    // A name must also predict what it has not seen; where nothing is left to predict, it need not.
    let share = PREDICTED.max(REMAINS * before.held_out);
    let predicts = predicted.held_out < share.min(MOST_HELD_OUT);
    let strained = case.model.list_strained(&best.fit.at.p);
    let mut verdict = match (explained, predicts, best.effects.is_empty()) {
        // What no prior allows is no explanation.
        _ if !strained.is_empty() => Verdict::Unexplained,
        (true, true, false) => Verdict::Named,
        (true, true, true) => Verdict::Adequate,
        (true, false, true) if after.all <= 1.0 && after.held_out <= PREDICTED => Verdict::Adequate,
        _ => Verdict::Unexplained,
    };
    let slope_read = verdict == Verdict::Named && slope_is_read(case, best)?;
    if slope_read || verdict == Verdict::Named && imitates_a_lag(best) {
        verdict = Verdict::Unexplained;
    }
    Ok(Judgement { verdict, misfit, held_out, before, trained, predicted, after, strained, slope_read })
}

/// Of a fit without the held-out records from the fit to all of them, and one from the machine as it is, the better
/// one: without those records the way down has more side valleys.
fn better_trained(
    case: &Case,
    best: &Candidate,
    first: Candidate,
    training: Subset,
) -> Result<Candidate, DiagnoseError> {
    let start = Point { theta: best.fit.at.theta.clone(), ..case.origin() };
    let second = case.finish(&best.effects, &start, 0.03, training)?;
    let by_error = first.model_error.total_cmp(&second.model_error);
    let order = by_error.then(first.fit.chi2.total_cmp(&second.fit.chi2));
    Ok(if order.is_le() { first } else { second })
}

/// Whether a longer set of effects lowers the gap of a shorter one by more than its further numbers do by chance.
/// Beside a set whose gap is above 1 the question is open: only the next effect may show what this one explains.
pub(crate) fn lowers_the_gap(case: &Case, shorter: &Candidate, longer: &Candidate) -> Result<bool, DiagnoseError> {
    let without = overall(case, &shorter.effects, &shorter.fit.at)?;
    let with = overall(case, &longer.effects, &longer.fit.at)?;
    let free = longer.numbers().saturating_sub(shorter.numbers());
    Ok(further(without, with, free))
}

/// Whether a gap is lower than another by more than so many further numbers do by chance.
pub(crate) fn further(without: Overall, with: Overall, numbers: usize) -> bool {
    // The real and the imaginary part of each residual count.
    let residuals = 2.0 * with.count as f64;
    let fall = residuals * (without.all.powi(2) - with.all.powi(2));
    fall > numbers as f64 * residuals.max(2.0).ln()
}

/// Whether a shorter set has a small gap for a reason that cannot be: beside it nuisance parameters leave their priors,
/// one alone or several together, and beside the longer one they do not. A number that takes more from the χ² of the
/// priors than one parameter may add to it explains several parameters that are off together.
pub(crate) fn relieves(case: &Case, shorter: &Candidate, longer: &Candidate) -> bool {
    let strained = |c: &Candidate| case.model.is_strained(&c.fit.at.p);
    !strained(longer) && (strained(shorter) || takes_over(case, shorter, longer))
}

/// Whether the further numbers of a longer set take more from the χ² of the priors than as many parameters may add.
fn takes_over(case: &Case, shorter: &Candidate, longer: &Candidate) -> bool {
    let prior = |c: &Candidate| case.model.layout.prior(&c.fit.at.p);
    let further = longer.numbers().saturating_sub(shorter.numbers()).max(1) as f64;
    prior(shorter) - prior(longer) > further * MOST_SD.powi(2)
}

/// Whether a longer set explains more than noise and the floor of the gap do with a shorter one. What takes over for
/// some of the nuisance parameters that are off may be one of two: others then still are.
pub(super) fn needs_longer(case: &Case, shorter: &Candidate, longer: &Candidate) -> Result<bool, DiagnoseError> {
    let open = overall(case, &shorter.effects, &shorter.fit.at)?.all > 1.0;
    Ok(open
        || relieves(case, shorter, longer)
        || takes_over(case, shorter, longer)
        || lowers_the_gap(case, shorter, longer)?)
}

/// Whether sensors that read the slope of the shaft explain the sweeps better than a sensor offset of the set: then the
/// offset is not what is missing.
fn slope_is_read(case: &Case, best: &Candidate) -> Result<bool, DiagnoseError> {
    let usage = Subset { taps: false, ..Subset::ALL };
    let problem = case.problem(&best.effects, usage);
    let mut offsets = best.effects.iter().enumerate();
    let Some((e, _)) = offsets.find(|(_, h)| h.kind == EffectKind::SensorOffset) else {
        return Ok(false);
    };
    let stage = (FINAL_MODEL_ERROR, SLOPE_ITERATIONS);
    let offset = problem.fit(&best.fit.at, &[stage])?;
    let elsewhere = offset.data_chi2 + case.model.layout.prior(&offset.at.p);
    let read = problem.with_slope_read(e, &offset.at, stage.0, stage.1)?;
    Ok(read < elsewhere - TIE_BIC)
}

/// What a fit may not see.
pub(crate) struct HeldOut {
    pub training: Subset,
    pub name: &'static str,
}

impl HeldOut {
    /// The hammer tests, or without any those of the rear sensors from the front currents.
    fn new(case: &Case) -> Self {
        if case.evidence.taps.is_empty() {
            Self { training: Subset { off_diagonal: false, ..Subset::ALL }, name: "rear sensors from front currents" }
        } else {
            Self { training: Subset { taps: false, ..Subset::ALL }, name: "hammer at the tool" }
        }
    }
}

/// Gap over all records and over those that are held out.
pub(crate) struct Overall {
    pub all: f64,
    pub held_out: f64,
    /// Complex residuals.
    pub count: usize,
}

pub(crate) fn overall(case: &Case, hypotheses: &[Hypothesis], at: &Point) -> Result<Overall, DiagnoseError> {
    let effects = hypothesis::effects(hypotheses, &at.theta);
    let evidence = case.evidence;
    let (mut used, mut across, mut taps) = (Gap::default(), Gap::default(), Gap::default());
    for sweep in &evidence.sweeps {
        let model = case.model.assemble(&at.p, &effects, sweep.speed_rad_s, false)?;
        for (line, f) in model.responses(&sweep.omega_rad_s).iter().enumerate() {
            sweep.gap(line, f, |i, j| !held_out(i, j), &mut used);
            sweep.gap(line, f, held_out, &mut across);
        }
    }
    for tap in &evidence.taps {
        let model = case.model.assemble(&at.p, &effects, tap.speed_rad_s, false)?;
        for (line, f) in model.responses(&tap.omega_rad_s).iter().enumerate() {
            tap.gap(line, f, &mut taps);
        }
    }
    let held_out = if evidence.taps.is_empty() { across } else { taps };
    let all = used.merge(across).merge(taps);
    Ok(Overall { all: all.value(), count: all.count(), held_out: held_out.value() })
}
