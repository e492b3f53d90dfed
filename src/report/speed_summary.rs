//! Stability and µ over speed as topics of the summary.

use super::summary::finite;
use crate::controller::speed_proof::SpeedProof;
use crate::controller::verification::{Verification, growth_words};
use crate::pipeline::design::Design;
use serde::{Deserialize, Serialize};

/// The proof over speed: how far it reaches, and in words.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct SpeedProofSummary {
    complete: bool,
    proven_to_rpm: Option<f64>,
    asked_to_rpm: Option<f64>,
    centres: usize,
    narrowest_half_width_rpm: Option<f64>,
    slowest_growth_rate_per_s: Option<f64>,
    pub(crate) sentence: Option<String>,
}

impl From<&SpeedProof> for SpeedProofSummary {
    fn from(proof: &SpeedProof) -> Self {
        Self {
            complete: proof.is_complete(),
            proven_to_rpm: finite(proof.proven_to_rpm()),
            asked_to_rpm: finite(proof.to_rpm),
            centres: proof.intervals.len(),
            narrowest_half_width_rpm: proof.narrowest().and_then(|i| finite(i.radius_rpm)),
            slowest_growth_rate_per_s: proof.slowest().and_then(|i| finite(i.growth_rate_per_s)),
            sentence: Some(speed_sentence(proof)),
        }
    }
}

fn speed_sentence(proof: &SpeedProof) -> String {
    let (to, centres) = (proof.proven_to_rpm(), proof.intervals.len());
    if proof.is_complete() {
        return format!(
            "Stable at every speed from rest to {to:.0} rpm: computed at {centres} speeds, and proven between them by \
             a small gain from a change of speed back to itself (sampled loop, full finite-element plant, exact \
             delay, rounded coefficients)."
        );
    }
    match proof.slowest() {
        Some(worst) if worst.growth_rate_per_s >= 0.0 => format!(
            "Stability is proven from rest to {to:.0} rpm; the loop {}.",
            growth_words(worst.growth_rate_per_s, worst.centre_rpm)
        ),
        _ => format!(
            "Stability is proven from rest to {to:.0} rpm; beyond, the loop is stable at the speeds computed, with no \
             proof between them."
        ),
    }
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct ProofCentre {
    speed_rpm: Option<f64>,
    proven_within_rpm: Option<f64>,
    growth_rate_per_s: Option<f64>,
}

/// Every centre of the proof.
pub(crate) fn speed_intervals(proof: &SpeedProof) -> Vec<ProofCentre> {
    let each = proof.intervals.iter().map(|i| ProofCentre {
        speed_rpm: finite(i.centre_rpm),
        proven_within_rpm: finite(i.radius_rpm),
        growth_rate_per_s: finite(i.growth_rate_per_s),
    });
    each.collect()
}

/// µ of the specification at a speed; an unstable loop has none.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct SpeedMuSummary {
    speed_rpm: Option<f64>,
    mu: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frequency_hz: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    whirl: Option<String>,
}

/// µ of the specification over speed.
pub(crate) fn speed_mu(design: &Design) -> Vec<SpeedMuSummary> {
    let each = design.delivery.speed_mu.iter().map(|s| {
        let speed_rpm = finite(s.speed_rpm);
        if !s.mu.is_finite() {
            return SpeedMuSummary {
                speed_rpm,
                reason: Some("the loop is unstable at this speed".to_owned()),
                ..SpeedMuSummary::default()
            };
        }
        let backward = s.frequency_hz < 0.0;
        let whirl = if backward { "backward" } else { "forward" };
        SpeedMuSummary {
            speed_rpm,
            mu: finite(s.mu),
            reason: None,
            frequency_hz: Some(finite(s.frequency_hz.abs())),
            whirl: Some(whirl.to_owned()),
        }
    });
    each.collect()
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct VerificationSummary {
    conditions: String,
    speeds: Vec<SpeedGrowth>,
}

/// Growth of a loop at a speed.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct SpeedGrowth {
    speed_rpm: Option<f64>,
    growth_rate_per_s: Option<f64>,
}

impl From<&Verification> for VerificationSummary {
    fn from(verification: &Verification) -> Self {
        let speeds = verification
            .speeds
            .iter()
            .map(|s| SpeedGrowth { speed_rpm: finite(s.speed_rpm), growth_rate_per_s: finite(s.growth_rate_per_s) });
        Self { conditions: verification.conditions.clone(), speeds: speeds.collect() }
    }
}
