//! What a set of records can show: the smallest size of every effect of the catalogue that would be found.
//!
//! With v the derivative of the whitened residuals to an effect, J those of the nuisance parameters and of what was
//! named, N = JᵀJ with priors: what remains of a size θ is  λ = θ² (vᵀv − vᵀJ N⁻¹ Jᵀv).  An effect is accepted when the
//! score falls by [`FURTHER_EFFECT_BIC_GAIN`] ([`FIRST_EFFECT_BIC_GAIN`]); it is found nine times in ten when √λ
//! exceeds the root of that by 1.28 standard deviations. Linear in the fit coordinate, in which small effects are. What
//! is too small to be worth a name ([`Hypothesis::matters`]) is not named however clear it is: then that is the
//! smallest size.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::estimate::FINAL_MODEL_ERROR;
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::problem::{Point, Problem};
use super::screening::{FIRST_EFFECT_BIC_GAIN, FURTHER_EFFECT_BIC_GAIN};
use crate::linalg::{Mat, solve};
use crate::spindle::{Effect, EffectKind, Location};
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
    /// The effect at its smallest size.
    pub effect: Effect,
}

/// Smallest sizes beside `named` effects at `at`, in the order of the catalogue.
///
/// # Errors
/// [`DiagnoseError`] when a model cannot be assembled.
pub fn detectable(
    case: &Case,
    named: &[Hypothesis],
    at: &Point,
) -> Result<Vec<Detectable>, DiagnoseError> {
    let base = problem(case, named).linear(at, FINAL_MODEL_ERROR)?;
    let (jacobian, normal) = base.parts();
    let residuals = (base.residuals() * STRIDE).max(2) as f64;
    let least = if named.is_empty() {
        FIRST_EFFECT_BIC_GAIN
    } else {
        FURTHER_EFFECT_BIC_GAIN
    };
    let needed = (least + residuals.ln()).sqrt() + NINE_IN_TEN;
    let wanted: Vec<&Hypothesis> = case
        .catalogue
        .iter()
        .enumerate()
        // One start of a name is enough where the start does not say what is meant.
        .filter(|(i, h)| {
            let before = &case.catalogue[..*i];
            h.kind == EffectKind::HousingMode
                || matches!(h.place, Location::Position(_))
                || !before.iter().any(|b| b.same_name(h))
        })
        .map(|(_, h)| h)
        .filter(|h| !named.iter().any(|n| n.same_name(h)))
        .collect();
    let sizes: Result<Vec<Option<Effect>>, DiagnoseError> = wanted
        .into_par_iter()
        .map(|h| {
            let theta = h.nothing();
            let with: Vec<Hypothesis> = named.iter().chain([h]).cloned().collect();
            let problem = problem(case, &with);
            let mut there = at.clone();
            there.theta.push(theta.clone());
            let linearised = problem.newest(&there, FINAL_MODEL_ERROR, None)?;
            let start = theta.first().copied().unwrap_or_default();
            // Of the numbers of an effect the first is its size.
            let own = linearised.jacobian.normal()[(0, 0)];
            let shared = jacobian.transpose_times_columns(&linearised.jacobian);
            let shared = Mat::from_fn(shared.nrows(), 1, |i, _| shared[(i, 0)]);
            let absorbed = solve(normal, &shared)?;
            let taken: f64 = (0..shared.nrows())
                .map(|i| shared[(i, 0)] * absorbed[(i, 0)])
                .sum();
            let left = (own - taken) * STRIDE as f64;
            if left <= 1e-12 * own.max(f64::MIN_POSITIVE) * STRIDE as f64 {
                return Ok(None);
            }
            let mut smallest = theta.clone();
            if let Some(t) = smallest.first_mut() {
                *t += needed / left.sqrt();
            }
            for _ in 0..400 {
                if h.matters(&smallest) {
                    break;
                }
                let nothing = start;
                if let Some(t) = smallest.first_mut() {
                    *t = nothing + (*t - nothing) * GROWTH;
                }
            }
            let meant = smallest.first().copied();
            h.clamp(&mut smallest);
            // A size beyond what the coordinate allows is none.
            Ok((smallest.first().copied() == meant).then(|| h.effect(&smallest)))
        })
        .collect();
    Ok(sizes?
        .into_iter()
        .flatten()
        .map(|effect| Detectable { effect })
        .collect())
}

fn problem<'a>(case: &Case<'a>, effects: &'a [Hypothesis]) -> Problem<'a> {
    Problem {
        model: case.model,
        evidence: case.evidence,
        usage: Subset {
            stride: STRIDE,
            ..Subset::ALL
        },
        effects,
    }
}
