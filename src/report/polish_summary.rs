//! What the polish did as a topic of the summary: figures before and after, limits, rounds.

use super::summary::finite;
use crate::pipeline::judged::Judged;
use crate::pipeline::polishing::{PolishAttempt, PolishOutcome};
use crate::predict::sensitivity::Zone;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PolishSummary {
    delivered: bool,
    sentence: String,
    dk: Option<JudgedSummary>,
    limits: LimitsSummary,
    attempts: Vec<AttemptSummary>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct LimitsSummary {
    sensitivity_db: Option<f64>,
    high_frequency_from_hz: Option<f64>,
    high_frequency_gain_a_per_m: Option<f64>,
    noise_current_a: Option<f64>,
    mu: Option<f64>,
    mu_of: String,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct AttemptSummary {
    start: String,
    delivered: bool,
    objections: Vec<String>,
    failure: Option<String>,
    polished: Option<JudgedSummary>,
    rounds: Vec<RoundSummary>,
    certificates: Vec<CertificateSummary>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct RoundSummary {
    steps: usize,
    lines: usize,
    stiffness_of_the_loss_n_per_m: Option<f64>,
    over_limit: OverLimit,
}

/// Largest ratio of a quantity to its limit.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct OverLimit {
    sensitivity: Option<f64>,
    high_frequency_gain: Option<f64>,
    noise_current: Option<f64>,
    mu: Option<f64>,
    weak_magnets: Option<f64>,
    tool_stiffness: Option<f64>,
}

/// A certified µ and its frequency.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct CertificateSummary {
    mu: Option<f64>,
    frequency_hz: Option<f64>,
}

/// Figures of a controller as the polish judges it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct JudgedSummary {
    controller_order: usize,
    largest_mu: Option<f64>,
    mu_table_as_written: Option<f64>,
    mu_with_gyroscopic_cover: Option<f64>,
    minimum_n_per_m: Option<f64>,
    minimum_at_top_speed_n_per_m: Option<f64>,
    zone: Option<String>,
    zone_at_top_speed: Option<String>,
}

impl From<&PolishOutcome> for PolishSummary {
    fn from(polish: &PolishOutcome) -> Self {
        let limits = &polish.limits;
        let attempts = polish.attempts.iter().enumerate();
        Self {
            delivered: polish.delivered.is_some(),
            sentence: polish.sentence.clone(),
            dk: polish.dk.as_ref().map(JudgedSummary::from),
            limits: LimitsSummary {
                sensitivity_db: finite(20.0 * limits.sensitivity.log10()),
                high_frequency_from_hz: finite(limits.high_frequency_hz),
                high_frequency_gain_a_per_m: finite(limits.high_frequency_gain_a_per_m),
                noise_current_a: finite(limits.noise_current_a),
                mu: finite(limits.mu),
                mu_of: polish.held_to.words(),
            },
            attempts: attempts.map(|(k, attempt)| AttemptSummary::of(attempt, polish.delivered == Some(k))).collect(),
        }
    }
}

impl AttemptSummary {
    fn of(attempt: &PolishAttempt, delivered: bool) -> Self {
        let rounds = attempt.rounds.iter().map(|r| RoundSummary {
            steps: r.steps,
            lines: r.lines,
            stiffness_of_the_loss_n_per_m: finite(r.stiffness_n_per_m),
            over_limit: OverLimit {
                sensitivity: finite(r.over_limit[0]),
                high_frequency_gain: finite(r.over_limit[1]),
                noise_current: finite(r.over_limit[2]),
                mu: finite(r.over_limit[3]),
                weak_magnets: finite(r.over_limit[4]),
                tool_stiffness: finite(r.over_limit[5]),
            },
        });
        let certificates = attempt.certificates.iter();
        Self {
            start: attempt.start.to_owned(),
            delivered,
            objections: attempt.objections.iter().map(|o| (*o).to_owned()).collect(),
            failure: attempt.failure.clone(),
            polished: attempt.judged.as_ref().map(JudgedSummary::from),
            rounds: rounds.collect(),
            certificates: certificates
                .map(|(mu, hz)| CertificateSummary { mu: finite(*mu), frequency_hz: finite(*hz) })
                .collect(),
        }
    }
}

impl From<&Judged> for JudgedSummary {
    fn from(judged: &Judged) -> Self {
        let zone = |k: usize| judged.zones[k].map(Zone::letter).map(str::to_owned);
        Self {
            controller_order: judged.order,
            largest_mu: finite(judged.mu),
            mu_table_as_written: finite(judged.mu_at_rest[0]),
            mu_with_gyroscopic_cover: finite(judged.mu_at_rest[1]),
            minimum_n_per_m: finite(judged.stiffness_n_per_m[0]),
            minimum_at_top_speed_n_per_m: finite(judged.stiffness_n_per_m[1]),
            zone: zone(0),
            zone_at_top_speed: zone(1),
        }
    }
}
