//! Descents of a PID search from several starts: each goes in rounds on lines renewed for it, and the worse half of
//! them ends after every few rounds.

use super::law::PidLaw;
use crate::controller::polish::descent::{Effort, Memory, PENALTY, descend};
use crate::controller::polish::loss::{Evaluation, Loss};
use crate::controller::verification_error::VerificationError;
use crate::linalg::c64;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Relative gain of a round, on renewed lines and with its curvature learnt afresh, that pays for another one.
const ROUND_GAIN: f64 = 5e-3;
/// Rounds in a row without that gain that end a descent: a peak that one lets grow between its lines is on those of the
/// next.
const IDLE: usize = 2;
/// Rounds after which the worse half of the starts ends.
const STAGE: usize = 2;
/// Steps of the first round. With half as many the PIDs of sixty machines are 2 % softer in the mean; with three times
/// as many a search takes a tenth longer, and they are no stiffer.
const SHORT: usize = 40;
/// What a start may be behind the best of them then to go on, in the logarithm of the stiffness.
const BEHIND: f64 = 0.3;

/// Where the loss was before its lines are renewed: poles of the loops met, and the loss, whose responses hold on the
/// same lines.
pub(super) type Earlier<'a> = (&'a mut Vec<c64>, Option<&'a Loss>);

/// The loss on lines renewed for a law with these parameters, and what it makes of them.
pub(super) type FreshLoss<'a> =
    dyn Fn(&PidLaw, &[f64], Earlier) -> Result<(Loss, Judged), VerificationError> + Sync + 'a;

/// What a loss makes of parameters: rotors with an unstable loop, the machine as it is before those with shifted
/// modes, then the merit.
pub(super) type Judged = ([usize; 2], f64);

/// The better first.
pub(super) fn order(a: &Judged, b: &Judged) -> Ordering {
    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
}

/// A start on its way to its end.
pub(super) struct Descent {
    pub law: PidLaw,
    /// Where the descent stands, and the loss on lines renewed for that.
    x: Vec<f64>,
    loss: Loss,
    /// Poles of the loops met, rad/s: a peak that was once found cannot grow between the lines again.
    poles: Vec<c64>,
    /// The best parameters met at the end of a round, judged on lines renewed for them: a descent finds the gaps
    /// between its own.
    pub best: (Judged, Vec<f64>),
    evaluations: usize,
    /// What the last round made of it on its own lines.
    own: Judged,
    /// Rounds in a row without gain; as many as [`IDLE`] end it.
    idle: usize,
}

impl Descent {
    pub(super) fn new(law: PidLaw, x: Vec<f64>, fresh: &FreshLoss) -> Result<Self, VerificationError> {
        let mut poles = vec![];
        let (loss, own) = fresh(&law, &x, (&mut poles, None))?;
        Ok(Self { poles, best: (own, x.clone()), law, x, own, loss, evaluations: 0, idle: 0 })
    }

    /// What it may come to: peaks that the lines renewed for it show are mended by the next round.
    fn promise(&self) -> Judged {
        std::cmp::min_by(self.own, self.best.0, order)
    }

    /// Descends once and renews the lines; true when that pays for another round.
    fn run_round(&mut self, effort: &Effort, fresh: &FreshLoss) -> Result<bool, VerificationError> {
        // A descent that stands still on the curvature learnt on its way goes on without it.
        let how = (effort, &mut Memory::default());
        self.evaluations += descend(&mut self.loss, &self.law, &mut self.x, how.0, how.1)?;
        self.own = judge_evaluation(&self.loss, &self.loss.evaluate(&self.law, &self.x));
        let earlier = (&mut self.poles, Some(&self.loss));
        let (loss, found) = fresh(&self.law, &self.x, earlier)?;
        self.loss = loss;
        let before = self.best.0;
        if order(&found, &before).is_lt() {
            self.best = (found, self.x.clone());
        }
        // The merit is logarithmic.
        Ok(order(&(found.0, found.1 + ROUND_GAIN), &before).is_lt())
    }

    /// Rounds, until as many as [`IDLE`] in a row bring nothing.
    fn rounds(&mut self, most: usize, effort: &Effort, fresh: &FreshLoss) -> Result<(), VerificationError> {
        for _ in 0..most {
            if self.idle >= IDLE {
                break;
            }
            self.idle = if self.run_round(effort, fresh)? { 0 } else { self.idle + 1 };
        }
        Ok(())
    }
}

pub(super) fn judge_evaluation(loss: &Loss, found: &Evaluation) -> Judged {
    let mut lost = [0; 2];
    for (rotor, active) in loss.rotors.iter().zip(&loss.active) {
        let shifted = usize::from(!rotor.role.is_nominal());
        lost[shifted] += usize::from(!active);
    }
    (lost, found.merit(PENALTY))
}

/// The start that ends best. After a short round, and after every few then, the worse half of those left ends, and what
/// is far behind. The controllers judged come with it.
pub(super) fn best_end(
    mut descents: Vec<Descent>,
    effort: &Effort,
    rounds: usize,
    fresh: &FreshLoss,
) -> Result<(Option<Descent>, usize), VerificationError> {
    let short = Effort { steps: effort.steps.min(SHORT), ..*effort };
    descents.par_iter_mut().try_for_each(|d| d.rounds(1, &short, fresh))?;
    let mut left = rounds.saturating_sub(1);
    let mut going = descents.len();
    while left > 0 && descents.iter().any(|d| d.idle < IDLE) {
        descents.sort_by(|a, b| order(&a.promise(), &b.promise()));
        let Some(best) = descents.iter().map(|d| d.best.0).min_by(order) else {
            break;
        };
        going = going.div_ceil(2);
        for (place, descent) in descents.iter_mut().enumerate() {
            let (lost, merit) = descent.promise();
            if place >= going || !order(&(lost, merit - BEHIND), &best).is_lt() {
                descent.idle = IDLE;
            }
        }
        let now = STAGE.min(left);
        left -= now;
        descents.par_iter_mut().try_for_each(|d| d.rounds(now, effort, fresh))?;
    }
    let evaluations = descents.iter().map(|d| d.evaluations).sum();
    let winner = descents.into_iter().min_by(|a, b| order(&a.best.0, &b.best.0));
    Ok((winner, evaluations))
}
