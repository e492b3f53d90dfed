//! Explanations that the data do not tell apart.

use super::super::fit::case::Case;
use super::super::fit::hypothesis::Hypothesis;
use super::candidate::Candidate;
use super::judgement::relieves;
use super::screening::TIE_BIC;

/// The best set of effects, and the rivals with other names whose score the data cannot tell from its own.
pub(crate) fn indistinguishable<'a>(case: &Case, best: &'a Candidate, rivals: &'a [Candidate]) -> Vec<&'a Candidate> {
    let mut members = vec![best];
    for rival in rivals {
        // What drives nuisance parameters out of their priors is no explanation.
        if relieves(case, rival, best) {
            continue;
        }
        // χ² differences count less where the model error, not the noise, limits the fit.
        if rival.model_error > best.model_error {
            continue;
        }
        let distance = rival.score() - best.score();
        let known = |m: &&Candidate| same_names(&m.effects, &rival.effects);
        if distance < TIE_BIC && !members.iter().any(known) {
            members.push(rival);
        }
    }
    members
}

fn same_names(a: &[Hypothesis], b: &[Hypothesis]) -> bool {
    a.len() == b.len() && a.iter().all(|x| b.iter().any(|y| x.same_name(y)))
}
