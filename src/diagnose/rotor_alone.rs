//! Diagnosis of a rotor without magnets from the frequencies of hammer tests: whether the rotor as drawn explains them,
//! or a single change of it does, which then has to bring frequencies nearer that no fit has seen.

use super::decide::judgement::Verdict;
use crate::rotor::Rotor;
use crate::update::alternatives::RotorParameter;
use crate::update::single_change::{FittedChange, SingleChanges, single_changes};
use crate::update::{Targets, UpdateError};

/// Changes whose χ² are closer than this are alike: the 99 % quantile of χ² with one degree of freedom.
const ALIKE: f64 = 6.63;

/// What is missing in the model of a rotor.
#[derive(Clone, Debug)]
pub(crate) struct RotorDiagnosis {
    pub(crate) verdict: Verdict,
    pub(crate) found: SingleChanges,
    /// Changes that are as good as the best one, another kind or another place; of each kind and place the best.
    pub(crate) rivals: Vec<FittedChange>,
}

/// Diagnoses a rotor from its measured frequencies.
///
/// # Errors
/// As [`single_changes`].
pub(crate) fn diagnose_rotor(rotor: &Rotor, targets: &Targets) -> Result<RotorDiagnosis, UpdateError> {
    let found = single_changes(rotor, targets)?;
    let rivals = rivals(&found.changes);
    let verdict = match found.changes.first() {
        _ if found.as_drawn.statistic <= found.limit => Verdict::Adequate,
        Some(best) if best.statistic <= found.limit => match found.held_out {
            _ if !rivals.is_empty() => Verdict::Tie,
            0 => Verdict::Probable,
            _ if best.held_out < found.as_drawn.held_out => Verdict::Named,
            _ => Verdict::Unexplained,
        },
        _ => Verdict::Unexplained,
    };
    Ok(RotorDiagnosis { verdict, found, rivals })
}

/// Changes as good as the best one; masses beside a mass, without a worse one between them, are one.
fn rivals(changes: &[FittedChange]) -> Vec<FittedChange> {
    let Some(best) = changes.first() else {
        return vec![];
    };
    let place = |change: &FittedChange| match change.parameter {
        Some(RotorParameter::Mass(place_m)) => Some(place_m),
        _ => None,
    };
    let is_alike = |change: &FittedChange| change.statistic < best.statistic + ALIKE;
    let worse: Vec<f64> = changes.iter().filter(|c| !is_alike(c)).filter_map(place).collect();
    let joined = |a: f64, b: f64| worse.iter().all(|z| (z - a) * (z - b) > 0.0);
    let mut kept: Vec<&FittedChange> = vec![best];
    for change in changes.iter().skip(1).filter(|c| is_alike(c)) {
        let same = |known: &&FittedChange| place(known).zip(place(change)).is_some_and(|(a, b)| joined(a, b));
        if !kept.iter().any(same) {
            kept.push(change);
        }
    }
    kept.into_iter().skip(1).cloned().collect()
}

impl RotorDiagnosis {
    /// The change that the verdict names, or the best of those that it leaves open.
    pub(crate) fn named(&self) -> Option<&FittedChange> {
        let names = matches!(self.verdict, Verdict::Named | Verdict::Probable | Verdict::Tie);
        self.found.changes.first().filter(|_| names)
    }

    /// What is found, in a sentence.
    pub(crate) fn sentence(&self) -> String {
        let SingleChanges { as_drawn, changes, fitted, held_out, limit, .. } = &self.found;
        let drawn = format!(
            "the rotor as drawn leaves χ² = {:.1} against {limit:.1} (99 % for {fitted} frequencies)",
            as_drawn.statistic
        );
        let Some(best) = changes.first() else {
            return drawn;
        };
        let words = format!("{} (χ² = {:.1})", self.change_words(best), best.statistic);
        match self.verdict {
            Verdict::Adequate => drawn,
            Verdict::Named => {
                format!("{words}; {drawn}, and {held_out} antiresonances that were held out come nearer as well")
            }
            Verdict::Probable => format!(
                "{words}; {drawn}; nothing was held out to confirm it: hit at one place and read at another as well"
            ),
            Verdict::Tie => {
                let others: Vec<String> = self.rivals.iter().map(|rival| self.change_words(rival)).collect();
                format!("{words}, or {}: the frequencies do not tell; {drawn}", others.join(", or "))
            }
            Verdict::Unexplained => format!("{drawn}, and no single change explains them; nearest: {words}"),
        }
    }

    /// A change with its size.
    pub(crate) fn change_words(&self, change: &FittedChange) -> String {
        match &change.parameter {
            None => "the rotor as drawn".to_owned(),
            Some(RotorParameter::Mass(place_m)) => {
                format!("a mass of {:.4} kg at {place_m:.4} m", self.mass_kg(change))
            }
            Some(parameter) => format!("{} is {:.4} times that of the file", parameter.words(), change.factor),
        }
    }

    /// Mass that a change adds as a point, kg.
    pub(crate) fn mass_kg(&self, change: &FittedChange) -> f64 {
        (change.factor - 1.0) * self.found.mass_kg
    }
}
