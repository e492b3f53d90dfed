//! What a set of records can show: the smallest size of every effect of the catalogue that would be found.
//!
//! With v the derivative of the whitened residuals to an effect, J those of the nuisance parameters and of what was
//! named, N = JᵀJ with priors: what remains of a size θ is  λ = θ² (vᵀv − vᵀJ N⁻¹ Jᵀv).  An effect is accepted when the
//! score falls by `FURTHER_EFFECT_BIC_GAIN` (`FIRST_EFFECT_BIC_GAIN`); it is found nine times in ten when √λ
//! exceeds the root of that by 1.28 standard deviations. Linear in the fit coordinate, in which small effects are. It
//! has a name where the gap falls by more than chance too, whose σ holds half a percent of the signal ([`GAP_FLOOR`]).
//! What is too small to be worth a name ([`Hypothesis::matters`]) is not named however clear it is; from which size on
//! it would be is told beside.

use super::super::DiagnoseError;
use super::super::data::evidence::{GAP_FLOOR, Subset};
use super::super::fit::case::Case;
use super::super::fit::estimate::FINAL_MODEL_ERROR;
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::jacobian::Jacobian;
use super::super::fit::linearise::assembled_with_size;
use super::super::fit::prediction::Linear;
use super::super::fit::problem::{Point, Problem};
use super::screening::{FIRST_EFFECT_BIC_GAIN, FURTHER_EFFECT_BIC_GAIN};
use crate::linalg::dense::solve_normal;
use crate::spindle::{Effect, EffectKind};
use rayon::prelude::*;

/// Every so many lines are looked at.
const STRIDE: usize = 6;
/// Growth of a size until it is worth a name.
const GROWTH: f64 = 1.05;
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
    let base = problem(case, named).linear(at, FINAL_MODEL_ERROR)?;
    let residuals = (base.residuals() * STRIDE).max(2) as f64;
    let least = if named.is_empty() { FIRST_EFFECT_BIC_GAIN } else { FURTHER_EFFECT_BIC_GAIN };
    let needed = (least + residuals.ln()).sqrt() + NINE_IN_TEN;
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
    let left = remaining_of(case, named, at, FINAL_MODEL_ERROR, &wanted)?;
    let in_the_gap = remaining_of(case, named, at, GAP_FLOOR, &wanted)?;
    let needed_in_the_gap = residuals.ln().sqrt() + NINE_IN_TEN;
    let mut found = vec![];
    for h in wanted {
        // Hypotheses are few: their place in the list is found by looking.
        let of = |all: &[(Hypothesis, f64)]| all.iter().find(|(l, _)| l == h).map(|(_, left)| *left);
        let smallest_named = of(&in_the_gap).filter(|left| *left > 0.0).map(|left| needed_in_the_gap / left.sqrt());
        let both = of(&left).zip(smallest_named);
        found.extend(both.and_then(|(left, named)| smallest(h, needed / left.sqrt(), named)));
    }
    Ok(found)
}

/// For each hypothesis the curvature of its size that is its own, at a relative model error.
fn remaining_of(
    case: &Case,
    named: &[Hypothesis],
    at: &Point,
    model_error: f64,
    wanted: &[&Hypothesis],
) -> Result<Vec<(Hypothesis, f64)>, DiagnoseError> {
    let base = problem(case, named).linear(at, model_error)?;
    let (sized, without): (Vec<&Hypothesis>, Vec<&Hypothesis>) =
        wanted.iter().copied().partition(|h| assembled_with_size(h.kind));
    let without: Vec<Hypothesis> = without.into_iter().cloned().collect();
    let shared = problem(case, named).beside(at, model_error, &without)?;
    let mut left: Vec<(Hypothesis, f64)> = vec![];
    let all = remaining(&base, &shared.jacobian)?;
    let mut first = 0;
    for h in without {
        // Of the numbers of an effect the first is its size.
        left.push((h.clone(), all[first]));
        first += h.nothing().len();
    }
    let each = sized.into_par_iter().map(|h| {
        let with: Vec<Hypothesis> = named.iter().chain([h]).cloned().collect();
        let mut there = at.clone();
        there.theta.push(h.nothing());
        let linearised = problem(case, &with).newest(&there, model_error, None)?;
        Ok((h.clone(), remaining(&base, &linearised.jacobian)?[0]))
    });
    left.extend(each.collect::<Result<Vec<_>, DiagnoseError>>()?);
    Ok(left)
}

/// For each column the curvature that is its own, the earlier parameters following: all lines counted, zero where the
/// earlier ones take up everything.
fn remaining(base: &Linear, further: &Jacobian) -> Result<Vec<f64>, DiagnoseError> {
    let (jacobian, normal) = base.parts();
    let shared = jacobian.transpose_times_columns(further);
    let own = further.normal_of_each(&vec![1; further.columns()]);
    let absorbed = solve_normal(normal, &shared)?;
    let each = (0..shared.ncols()).map(|c| {
        let taken: f64 = (0..shared.nrows()).map(|i| shared[(i, c)] * absorbed[(i, c)]).sum();
        let own = own[c][(0, 0)];
        let left = own - taken;
        let told = left > 1e-12 * own.max(f64::MIN_POSITIVE);
        if told { left * STRIDE as f64 } else { 0.0 }
    });
    Ok(each.collect())
}

/// The effect at the size of which nine in ten are found, and at which it has a name, from `named` on; none where no
/// size that makes sense would be found.
fn smallest(h: &Hypothesis, mut size: f64, named: f64) -> Option<Detectable> {
    let nothing = h.nothing();
    let start = nothing.first().copied().unwrap_or_default();
    let of_size = |size: f64| {
        let mut theta = nothing.clone();
        if let Some(t) = theta.first_mut() {
            *t = start + size;
        }
        let meant = theta.first().copied();
        h.clamp(&mut theta);
        // A size beyond what the coordinate allows is none.
        (theta.first().copied() == meant).then_some(theta)
    };
    let effect = h.effect(&of_size(size)?);
    size = size.max(named);
    for _ in 0..400 {
        match of_size(size) {
            Some(theta) if !h.matters(&theta) => size *= GROWTH,
            _ => break,
        }
    }
    let theta = of_size(size)?;
    // A disc without inertia has no name at any mass.
    h.matters(&theta).then(|| Detectable { effect, named_from: h.effect(&theta) })
}

fn problem<'a>(case: &Case<'a>, effects: &'a [Hypothesis]) -> Problem<'a> {
    Problem { model: case.model, evidence: case.evidence, usage: Subset { stride: STRIDE, ..Subset::ALL }, effects }
}
