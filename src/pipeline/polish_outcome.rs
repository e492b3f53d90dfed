//! What the polish of a design did: its attempts, which of them is delivered, and that in words.

use super::certificates::mu_words;
use super::judged::Judged;
use super::polish_job::{Goal, PolishJob, Polished};
use super::widening::Widening;
use crate::controller::polish::{LoopLimits, PolishRound};
use crate::pid::parameters::PidParameters;
use crate::pid::surviving::SurvivingLaw;
use crate::predict::stiffness::stiffness_words;

/// A polish from one start.
#[derive(Clone, Debug)]
pub struct PolishAttempt {
    /// Where it started, in words.
    pub start: &'static str,
    /// The polished controller; none when the polish could not start.
    pub judged: Option<Judged>,
    /// Why it did not take the place of the best before it; empty when it did.
    pub objections: Vec<&'static str>,
    /// What the loss said of the start, and after each round.
    pub rounds: Vec<PolishRound>,
    /// Certificates: μ of the specification and its frequency, Hz.
    pub certificates: Vec<(f64, f64)>,
    /// Why it could not start.
    pub failure: Option<String>,
}

impl PolishAttempt {
    /// From a start, without a result.
    pub(super) fn from(start: &'static str) -> Self {
        Self { start, judged: None, objections: vec![], rounds: vec![], certificates: vec![], failure: None }
    }

    /// From a start to a polished controller.
    pub(super) fn of(start: &'static str, judged: Judged, course: Polished) -> Self {
        Self { judged: Some(judged), rounds: course.rounds, certificates: course.certificates, ..Self::from(start) }
    }
}

/// What the polish of a design did.
#[derive(Clone, Debug)]
pub struct PolishOutcome {
    /// The controller of the D-K iteration, reduced and rounded; none where the iteration was left out.
    pub dk: Option<Judged>,
    /// Limits asked for.
    pub limits: LoopLimits,
    /// The specification whose μ the polish and its certificates are held to: as written, or with wider limits.
    pub held_to: Widening,
    /// Attempts in their order: from an earlier design where there is one, from the D-K iteration, where that misses a
    /// target from a tuned PID, where none is stable at every speed from a law that is, and from the best of these.
    pub attempts: Vec<PolishAttempt>,
    /// Number of the attempt whose controller is delivered; none: that of the D-K iteration is.
    pub delivered: Option<usize>,
    /// A PID tuned without regard to the design, where the controller of the D-K iteration missed a goal.
    pub tuned_pid: Option<PidParameters>,
    /// The search of a law over speed, when no other controller was stable at every speed.
    pub surviving: Option<SurvivingLaw>,
    /// The outcome in a sentence or two.
    pub sentence: String,
}

impl PolishOutcome {
    /// Before the first attempt.
    pub(super) fn open(job: &PolishJob<'_>, limits: LoopLimits, dk: Option<Judged>) -> Self {
        Self {
            dk,
            limits,
            held_to: Goal::of(job).widening,
            attempts: vec![],
            delivered: None,
            tuned_pid: None,
            surviving: None,
            sentence: String::new(),
        }
    }
}

/// The outcome in words.
pub(super) fn sentence(outcome: &PolishOutcome) -> String {
    let words = |k: f64| {
        if k.is_nan() { "none (unstable loop)".to_owned() } else { stiffness_words(k) }
    };
    let beside = |dk: &Judged| {
        format!(" (D-K iteration: {} and {})", words(dk.stiffness_n_per_m[0]), words(dk.stiffness_n_per_m[1]))
    };
    let beside = outcome.dk.as_ref().map_or_else(String::new, beside);
    let figures = |attempt: &PolishAttempt, judged: &Judged| {
        format!(
            "The polish from the {} has a smallest tool stiffness of {} at rest and {} at top speed{beside}, µ of the \
             specification at most {} from rest to 1.2 times the top speed",
            attempt.start,
            words(judged.stiffness_n_per_m[0]),
            words(judged.stiffness_n_per_m[1]),
            mu_words(judged.mu),
        )
    };
    if let Some(attempt) = outcome.delivered.and_then(|k| outcome.attempts.get(k))
        && let Some(judged) = &attempt.judged
    {
        let delivered = match outcome.dk {
            Some(_) => "the polished controller is delivered",
            None => "it meets every goal and is delivered; no D-K iteration was run",
        };
        return format!("{}; {delivered}.", figures(attempt, judged));
    }
    let reasons: Vec<String> = outcome
        .attempts
        .iter()
        .map(|attempt| match (&attempt.judged, &attempt.failure) {
            (Some(judged), _) => {
                format!("{}; it is not delivered: {}.", figures(attempt, judged), attempt.objections.join(", "))
            }
            (None, failure) => {
                format!("No polish from the {}: {}.", attempt.start, failure.as_deref().unwrap_or("it did not start"))
            }
        })
        .collect();
    format!("The controller of the D-K iteration is delivered. {}", reasons.join(" "))
}
