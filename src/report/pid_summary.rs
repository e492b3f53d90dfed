//! A PID as the topic `pid` of the summary: the figures of its certificate beside their limits.

use super::speed_summary::VerificationSummary;
use super::summary::{finite, finite_all};
use crate::pid::certificate::{PeakSensitivity, PidCertificate, TunedPid, ZONE_B_DB};
use crate::pid::settings::TuneSettings;
use serde::Serialize;

/// Amplifier limits that [`crate::pipeline::comparison::rival_settings`] took from the delivered controller.
pub(crate) const OF_DELIVERED: &str = "the figures of the delivered controller";

/// `pid`: the tuned PID's figures beside their limits.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PidSummary {
    #[serde(flatten)]
    certificate: CertificateSummary,
    meets_limits: bool,
    limits: LimitsSummary,
}

/// `pid` when the search found none.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct NoPid {
    found: bool,
    sentence: String,
}

/// Limits of the search.
#[derive(Clone, Debug, Serialize)]
struct LimitsSummary {
    sensitivity_db: Option<f64>,
    noise_current_a: Option<f64>,
    high_frequency_gain_a_per_m: Option<f64>,
    high_frequency_from_hz: Option<f64>,
    high_frequency_norm: &'static str,
    amplifier_limits: &'static str,
    mode_shift: Option<f64>,
}

/// Figures of a PID on the full plant.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CertificateSummary {
    stable: bool,
    sensitivity: BothBearings,
    sensitivity_at_top_speed: BothBearings,
    noise_current_a: Option<f64>,
    high_frequency_gain_a_per_m: Option<f64>,
    minimum_stiffness_n_per_m: Option<f64>,
    minimum_stiffness_at_top_speed_n_per_m: Option<f64>,
    evaluations: usize,
    certificates: Certificates,
}

#[derive(Clone, Debug, Serialize)]
struct BothBearings {
    front: PeakSummary,
    rear: PeakSummary,
}

#[derive(Clone, Debug, Serialize)]
struct PeakSummary {
    attained_db: Option<f64>,
    not_above_db: Option<f64>,
    frequency_hz: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
struct Certificates {
    nominal: VerificationSummary,
    modes_lowered: VerificationSummary,
    modes_raised: VerificationSummary,
    modes_alone_and_combined: ShiftedModes,
}

#[derive(Clone, Debug, Serialize)]
struct ShiftedModes {
    shift: Option<f64>,
    loops: usize,
    worst_growth_rate_per_s: Option<f64>,
    worst_frequency_factors: Vec<Option<f64>>,
    worst_speed_rpm: Option<f64>,
}

impl PidSummary {
    /// Of a tuned PID, the settings of its search, and where its amplifier limits come from.
    pub(crate) fn of(pid: &TunedPid, settings: &TuneSettings, amplifier_limits: &'static str) -> Self {
        let c = &pid.certificate;
        Self {
            certificate: CertificateSummary::from(c),
            meets_limits: c.meets(settings),
            limits: LimitsSummary {
                sensitivity_db: finite(ZONE_B_DB),
                noise_current_a: finite(settings.noise_current_a),
                high_frequency_gain_a_per_m: finite(settings.high_frequency_gain_a_per_m),
                high_frequency_from_hz: finite(c.high_frequency_hz),
                high_frequency_norm: "largest singular value of the controller",
                amplifier_limits,
                mode_shift: finite(settings.mode_shift),
            },
        }
    }
}

impl NoPid {
    /// With the reason in a sentence.
    pub(crate) fn because(sentence: String) -> Self {
        Self { found: false, sentence }
    }
}

impl From<&PidCertificate> for CertificateSummary {
    fn from(c: &PidCertificate) -> Self {
        Self {
            stable: c.is_stable(),
            sensitivity: BothBearings::from(&c.sensitivity),
            sensitivity_at_top_speed: BothBearings::from(&c.sensitivity_at_speed),
            noise_current_a: finite(c.noise_current_a),
            high_frequency_gain_a_per_m: finite(c.high_frequency_gain_a_per_m),
            minimum_stiffness_n_per_m: finite(c.stiffness_n_per_m),
            minimum_stiffness_at_top_speed_n_per_m: finite(c.stiffness_at_speed_n_per_m),
            evaluations: c.evaluations,
            certificates: Certificates {
                nominal: VerificationSummary::from(&c.nominal),
                modes_lowered: VerificationSummary::from(&c.lowered),
                modes_raised: VerificationSummary::from(&c.raised),
                modes_alone_and_combined: ShiftedModes {
                    shift: finite(c.shifted.shift),
                    loops: c.shifted.loops,
                    worst_growth_rate_per_s: finite(c.shifted.worst_growth_rate_per_s),
                    worst_frequency_factors: finite_all(&c.shifted.worst_factors),
                    worst_speed_rpm: finite(c.shifted.worst_speed_rpm),
                },
            },
        }
    }
}

impl From<&[PeakSensitivity; 2]> for BothBearings {
    fn from(both: &[PeakSensitivity; 2]) -> Self {
        let [front, rear] = both.each_ref().map(|p| PeakSummary {
            attained_db: finite(p.db),
            not_above_db: finite(p.upper_db),
            frequency_hz: finite(p.frequency_hz),
        });
        Self { front, rear }
    }
}
