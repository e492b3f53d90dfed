//! Effects at the same site as a member of a set, tried in its place while the others stay where they are.
//!
//! A search for a member begins with the others fitted alone; a place among them may then have moved to where it
//! stands in for the member, and what is right beside the right place is not found. A low-pass of the sensors and a
//! slower loop hardly differ, so that the wrong one of the two can explain the records.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::estimate::{FINAL_MODEL_ERROR, Fit, Stage};
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::problem::Point;
use super::candidate::Candidate;
use super::screening::{explains, matters};
use crate::spindle::EffectKind;
use rayon::prelude::*;

/// First fits, on thinned lines: a relative begins with nothing, which may leave much.
const STAGES: [Stage; 5] = [(0.1, 3), (0.03, 3), (0.01, 3), (0.003, 3), (FINAL_MODEL_ERROR, 2)];
/// Relatives of a member that are fitted to all lines.
const FITTED: usize = 2;

/// Sets with one member exchanged for a relative that explain the records within the priors.
pub(super) fn relatives(case: &Case, set: &Candidate) -> Result<Vec<Candidate>, DiagnoseError> {
    let mut all = vec![];
    for (k, member) in set.effects.iter().enumerate() {
        let mut begun: Vec<(Vec<Hypothesis>, Fit)> = list_relatives(case, &set.effects, member)
            .into_par_iter()
            .filter_map(|h| {
                let (effects, at) = exchange(set, k, h);
                let fit = case.problem(&effects, case.thin()).fit(&at, &STAGES).ok()?;
                Some((effects, fit))
            })
            .collect();
        begun.sort_by(|a, b| a.1.chi2.total_cmp(&b.1.chi2));
        begun.truncate(FITTED);
        for (effects, fit) in begun {
            let found = case.finish(&effects, &fit.at, FINAL_MODEL_ERROR, Subset::ALL)?;
            if explains(&found) && matters(&found) {
                all.push(placed_again(case, found)?);
            }
        }
    }
    all.retain(|c| case.within(c));
    Ok(all)
}

/// The set with its tilting stiffness at the best place, if it has one: with nuisance parameters outside their priors
/// it may stand where it stood in for another effect.
pub(super) fn placed_again(case: &Case, mut found: Candidate) -> Result<Candidate, DiagnoseError> {
    let tilts = |h: &Hypothesis| h.kind == EffectKind::TiltingStiffness;
    if let Some(at) = found.effects.iter().position(tilts)
        && !case.within(&found)
    {
        found = case.rotate_effects(&found, at + 1)?;
        case.move_finalist(std::slice::from_mut(&mut found))?;
    }
    Ok(found)
}

/// Effects without a fitted position that share a site with a member and are not in the set, one start each.
fn list_relatives<'a>(case: &Case<'a>, set: &[Hypothesis], member: &Hypothesis) -> Vec<&'a Hypothesis> {
    let sites = member.kind.entry().sites;
    let mut found: Vec<&Hypothesis> = vec![];
    for h in case.catalogue {
        let near = h.kind.entry().sites.iter().any(|site| sites.contains(site));
        let placed = h.place.position_m().is_some();
        let taken = || set.iter().any(|m| m.same_name(h));
        let known = || found.iter().any(|other| other.same_name(h));
        if near && !placed && !taken() && !known() {
            found.push(h);
        }
    }
    found
}

/// The set with member `k` exchanged, the new one last.
fn exchange(set: &Candidate, k: usize, h: &Hypothesis) -> (Vec<Hypothesis>, Point) {
    let (mut effects, mut at) = set.without(k);
    effects.push(h.clone());
    at.theta.push(h.start.clone());
    (effects, at)
}
