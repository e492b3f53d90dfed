//! What a set of records can show: the smallest size of every effect of the catalogue that would be found.
//!
//! With v the change of the whitened residuals by an effect, J their derivatives to the nuisance parameters and to what
//! was named, P the priors, N = JᵀJ + P and a = N⁻¹Jᵀv what the parameters take up: χ² falls by  vᵀv − vᵀJa  when the
//! effect is admitted. It is accepted when that exceeds its d numbers' share of the score, `FIRST_EFFECT_BIC_GAIN` (or
//! `FURTHER_EFFECT_BIC_GAIN`) + d ln N; it is found nine times in ten when the root is exceeded by 1.28 standard
//! deviations. It has a name by the rules of the verdict (`needs_longer`): where the gap falls by more than chance,
//! which is the length of v − Ja in its σ, or where it takes more from the priors, aᵀPa, than parameters may be off.
//! What is too small to be worth a name ([`Hypothesis::matters`]) is not named however clear it is; from which size on
//! it would be is told beside. Sizes begin with derivatives and end with the change that the model itself makes.

use super::super::DiagnoseError;
use super::super::data::evidence::{GAP_FLOOR, Subset};
use super::super::fit::case::Case;
use super::super::fit::estimate::FINAL_MODEL_ERROR;
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::jacobian::Jacobian;
use super::super::fit::linearise::assembled_with_size;
use super::super::fit::model::MOST_SD;
use super::super::fit::prediction::Linear;
use super::super::fit::problem::{Point, Problem};
use super::screening::{FIRST_EFFECT_BIC_GAIN, FURTHER_EFFECT_BIC_GAIN};
use crate::linalg::Mat;
use crate::linalg::dense::solve_normal;
use crate::spindle::{Effect, EffectKind};
use rayon::prelude::*;

/// Every so many lines are looked at.
const STRIDE: usize = 6;
/// Growth of a size until it is worth a name.
const GROWTH: f64 = 1.05;
/// A size is enough at this share of what is needed, and is corrected so many times at most: nearly all responses are
/// straight enough for one.
const SETTLED: f64 = 0.98;
const CORRECTIONS: usize = 6;
/// Quantile of the normal distribution for nine in ten.
const NINE_IN_TEN: f64 = 1.28;

/// Smallest size of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Detectable {
    /// The effect at the smallest size that these records show.
    pub effect: Effect,
    /// The effect at the smallest size that has a name: the same, or the least that is worth one.
    pub named_from: Effect,
}

/// Smallest sizes beside `named` effects at `at`, in the order of the catalogue.
///
/// # Errors
/// [`DiagnoseError`] when a model cannot be assembled.
pub fn detectable(case: &Case, named: &[Hypothesis], at: &Point) -> Result<Vec<Detectable>, DiagnoseError> {
    let wanted: Vec<&Hypothesis> = case
        .catalogue
        .iter()
        .enumerate()
        // One start of a name is enough where the start does not say what is meant.
        .filter(|(i, h)| {
            let before = &case.catalogue[..*i];
            h.kind == EffectKind::HousingMode
                || h.place.position_m().is_some()
                || !before.iter().any(|b| b.same_name(h))
        })
        .map(|(_, h)| h)
        .filter(|h| !h.in_place_of_another() && !named.iter().any(|n| n.same_name(h)))
        .collect();
    let records = LinearRecords::new(case, named, at)?;
    let (sized, without): (Vec<&Hypothesis>, Vec<&Hypothesis>) =
        wanted.iter().copied().partition(|h| assembled_with_size(h.kind));
    let mut units = records.of_unit_sizes(&without)?;
    let each = sized.par_iter().map(|h| records.of_unit_size(h));
    units.extend(each.collect::<Result<Vec<_>, DiagnoseError>>()?);
    let known: Vec<(&Hypothesis, Remainder)> = without.into_iter().chain(sized).zip(units).collect();
    let found = wanted.par_iter().map(|h| {
        // Hypotheses are few: their place in the list is found by looking.
        let unit = known.iter().find(|(k, _)| k == h).map(|(_, unit)| unit);
        unit.map_or(Ok(None), |unit| records.smallest(h, unit))
    });
    Ok(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// What remains of a change of the residuals once the other parameters follow it.
#[derive(Clone, Copy, Default)]
struct Remainder {
    /// Fall of χ² with its priors when the change is admitted.
    chi2: f64,
    /// Fall of the squared gap, summed over real and imaginary parts.
    gap: f64,
    /// χ² of the priors that the parameters pay.
    prior: f64,
    /// Prior standard deviations of the parameter that moves furthest.
    furthest: f64,
}

/// Records linearised in all parameters but the effect that is asked for, as a fit sees them and in σ of the gap.
struct LinearRecords<'a> {
    case: &'a Case<'a>,
    named: &'a [Hypothesis],
    at: &'a Point,
    fit: Linear,
    gap: Linear,
    /// N of all lines, and JᵀJ in σ of the gap, over the stride.
    normal: Mat<f64>,
    normal_of_gap: Mat<f64>,
}

impl<'a> LinearRecords<'a> {
    fn new(case: &'a Case<'a>, named: &'a [Hypothesis], at: &'a Point) -> Result<Self, DiagnoseError> {
        let problem = every_few_lines(case, named);
        let (fit, gap) = (problem.linear(at, FINAL_MODEL_ERROR)?, problem.linear(&in_the_gap(at), GAP_FLOOR)?);
        // Every line stands for as many as are not looked at; a prior counts once.
        let mut normal = fit.parts().1.clone();
        for (k, (weight, _)) in case.model.layout.pull(&at.p).enumerate() {
            normal[(k, k)] -= weight * (1.0 - 1.0 / STRIDE as f64);
        }
        let normal_of_gap = gap.parts().0.normal();
        Ok(Self { case, named, at, fit, gap, normal, normal_of_gap })
    }

    /// Of unit sizes of effects that share one linearisation.
    fn of_unit_sizes(&self, wanted: &[&Hypothesis]) -> Result<Vec<Remainder>, DiagnoseError> {
        let further: Vec<Hypothesis> = wanted.iter().copied().cloned().collect();
        let problem = every_few_lines(self.case, self.named);
        let fit = problem.beside(self.at, FINAL_MODEL_ERROR, &further)?;
        let gap = problem.beside(&in_the_gap(self.at), GAP_FLOOR, &further)?;
        let all = self.of_columns(&fit.jacobian, &gap.jacobian)?;
        // Of the numbers of an effect the first is its size.
        let firsts = further.iter().scan(0, |next, h| {
            *next += h.nothing().len();
            Some(*next - h.nothing().len())
        });
        Ok(firsts.map(|first| all[first]).collect())
    }

    /// Of the unit size of an effect that has to be assembled.
    fn of_unit_size(&self, h: &Hypothesis) -> Result<Remainder, DiagnoseError> {
        let (with, there) = self.beside(h, h.nothing());
        let problem = every_few_lines(self.case, &with);
        let fit = problem.newest(&there, FINAL_MODEL_ERROR, None)?;
        let gap = problem.newest(&in_the_gap(&there), GAP_FLOOR, None)?;
        Ok(self.of_columns(&fit.jacobian, &gap.jacobian)?[0])
    }

    /// Of an effect as the model has it.
    fn of_effect(&self, h: &Hypothesis, theta: &[f64]) -> Result<Remainder, DiagnoseError> {
        let (with, there) = self.beside(h, theta.to_vec());
        let problem = every_few_lines(self.case, &with);
        let change = |base: &Linear, at: &Point, model_error: f64| -> Result<(Mat<f64>, f64), DiagnoseError> {
            let mut change = problem.residual(at, model_error)?;
            change.iter_mut().zip(base.residual()).for_each(|(there, here)| *there = here - *there);
            Ok((base.parts().0.transpose_times(&change), change.iter().map(|c| c * c).sum()))
        };
        let fit = change(&self.fit, &there, FINAL_MODEL_ERROR)?;
        let gap = change(&self.gap, &in_the_gap(&there), GAP_FLOOR)?;
        let all = self.remainders((&fit.0, &[fit.1]), (&gap.0, &[gap.1]))?;
        Ok(all[0])
    }

    fn beside(&self, h: &Hypothesis, theta: Vec<f64>) -> (Vec<Hypothesis>, Point) {
        let mut there = self.at.clone();
        there.theta.push(theta);
        (self.named.iter().chain([h]).cloned().collect(), there)
    }

    fn of_columns(&self, fit: &Jacobian, gap: &Jacobian) -> Result<Vec<Remainder>, DiagnoseError> {
        let own = |further: &Jacobian| -> Vec<f64> {
            further.normal_of_each(&vec![1; further.columns()]).iter().map(|own| own[(0, 0)]).collect()
        };
        let shared = |base: &Linear, further: &Jacobian| base.parts().0.transpose_times_columns(further);
        self.remainders((&shared(&self.fit, fit), &own(fit)), (&shared(&self.gap, gap), &own(gap)))
    }

    /// Of changes whose products with J and with themselves are given, as a fit sees them and in σ of the gap.
    fn remainders(&self, fit: Products, gap: Products) -> Result<Vec<Remainder>, DiagnoseError> {
        let layout = &self.case.model.layout;
        let lines = STRIDE as f64;
        let absorbed = solve_normal(&self.normal, fit.0)?;
        let each = (0..absorbed.ncols()).map(|c| {
            let taken: f64 = (0..absorbed.nrows()).map(|i| fit.0[(i, c)] * absorbed[(i, c)]).sum();
            let left = fit.1[c] - taken;
            // What the other parameters take up but for rounding is not told from them.
            if left <= 1e-12 * fit.1[c].max(f64::MIN_POSITIVE) {
                return Remainder::default();
            }
            // The gap is that of the machine, without the gains of the axes.
            let machine = layout.machine.count();
            let of_record = |k: usize| (machine..layout.len()).contains(&k);
            let a = |k: usize| if of_record(k) { 0.0 } else { absorbed[(k, c)] };
            let across: f64 = (0..absorbed.nrows()).map(|k| a(k) * gap.0[(k, c)]).sum();
            let along = |k: usize| (0..absorbed.nrows()).map(|l| self.normal_of_gap[(k, l)] * a(l)).sum::<f64>();
            let squared: f64 = (0..absorbed.nrows()).map(|k| a(k) * along(k)).sum();
            let off =
                layout.pull(&self.at.p).enumerate().map(|(k, (weight, _))| weight.sqrt() * absorbed[(k, c)].abs());
            let off: Vec<f64> = off.collect();
            Remainder {
                chi2: lines * left,
                gap: lines * (gap.1[c] - 2.0 * across + squared).max(0.0),
                prior: off.iter().map(|off| off * off).sum(),
                furthest: off.iter().copied().fold(0.0, f64::max),
            }
        });
        Ok(each.collect())
    }

    /// What an effect of this size reaches, as a share of what it needs to be found and of what it needs to have a
    /// name.
    fn shares_of_needed(&self, h: &Hypothesis, remainder: &Remainder) -> (f64, f64) {
        let residuals = ((self.fit.residuals() * STRIDE).max(2) as f64).ln();
        let least = if self.named.is_empty() { FIRST_EFFECT_BIC_GAIN } else { FURTHER_EFFECT_BIC_GAIN };
        let numbers = h.nothing().len() as f64;
        let of = |square: f64, needed: f64| square.sqrt() / (needed.sqrt() + NINE_IN_TEN);
        let found = of(remainder.chi2, least + numbers * residuals);
        let taken_over = of(remainder.prior, numbers * MOST_SD.powi(2));
        let strained = remainder.furthest / (MOST_SD + NINE_IN_TEN);
        let in_the_gap = of(remainder.gap, numbers * residuals);
        (found, found.min(in_the_gap.max(taken_over).max(strained)))
    }

    /// The effect at the size of which nine in ten are found, and at which it has a name; none where no size that makes
    /// sense would be found.
    fn smallest(&self, h: &Hypothesis, unit: &Remainder) -> Result<Option<Detectable>, DiagnoseError> {
        let (found, named) = self.shares_of_needed(h, unit);
        let nothing = h.nothing();
        let of_size = |size: f64| {
            let mut theta = nothing.clone();
            theta.iter_mut().take(1).for_each(|t| *t += size);
            let meant = theta.first().copied();
            h.clamp(&mut theta);
            // A size beyond what the coordinate allows is none.
            (theta.first().copied() == meant).then_some(theta)
        };
        let Some(effect) = of_size(found.recip()).map(|theta| h.effect(&theta)) else {
            return Ok(None);
        };
        let mut size = named.recip();
        for _ in 0..CORRECTIONS {
            for _ in 0..400 {
                match of_size(size) {
                    Some(theta) if !h.matters(&theta) => size *= GROWTH,
                    _ => break,
                }
            }
            let Some(theta) = of_size(size).filter(|theta| h.matters(theta)) else {
                // Too large, or without a name at any size as a disc without inertia is.
                return Ok(None);
            };
            let reached = self.shares_of_needed(h, &self.of_effect(h, &theta)?).1;
            if reached > SETTLED {
                return Ok(Some(Detectable { effect, named_from: h.effect(&theta) }));
            }
            // A size that changes nothing is none.
            size /= reached.max(0.1);
        }
        Ok(None)
    }
}

/// Products of changes with J, parameters × changes, and squares of the changes.
type Products<'a> = (&'a Mat<f64>, &'a [f64]);

/// The point without smooth errors, which the gap does not know.
fn in_the_gap(at: &Point) -> Point {
    Point { smooth: 0.0, ..at.clone() }
}

fn every_few_lines<'a>(case: &Case<'a>, effects: &'a [Hypothesis]) -> Problem<'a> {
    Problem { model: case.model, evidence: case.evidence, usage: Subset { stride: STRIDE, ..Subset::ALL }, effects }
}
