//! A PID as the topic `pid` of the summary: the figures of its certificate beside their limits.

use super::speed_summary::verification_topic;
use crate::pid::certificate::{PeakSensitivity, PidCertificate, TunedPid, ZONE_B_DB};
use crate::pid::settings::TuneSettings;
use serde_json::{Value, json};

/// Amplifier limits that [`crate::pipeline::comparison::rival_settings`] took from the delivered controller.
pub(crate) const OF_DELIVERED: &str = "the figures of the delivered controller";

/// `pid`: figures of a tuned PID, the settings of its search, and where its amplifier limits come from.
pub(crate) fn pid_topic(pid: &TunedPid, settings: &TuneSettings, amplifier_limits: &str) -> Value {
    let certificate = &pid.certificate;
    let mut topic = certificate_topic(certificate);
    topic["meets_limits"] = json!(certificate.meets(settings));
    topic["limits"] = json!({
        "sensitivity_db": ZONE_B_DB,
        "noise_current_a": settings.noise_current_a,
        "high_frequency_gain_a_per_m": settings.high_frequency_gain_a_per_m,
        "high_frequency_from_hz": certificate.high_frequency_hz,
        "high_frequency_norm": "largest singular value of the controller",
        "amplifier_limits": amplifier_limits,
        "mode_shift": settings.mode_shift,
    });
    topic
}

/// `pid` when the search found none, with the reason in a sentence.
pub(crate) fn no_pid_topic(sentence: &str) -> Value {
    json!({ "found": false, "sentence": sentence })
}

/// Figures of a PID on the full plant.
pub(crate) fn certificate_topic(c: &PidCertificate) -> Value {
    json!({
        "stable": c.is_stable(),
        "sensitivity": sensitivity_topic(&c.sensitivity),
        "sensitivity_at_top_speed": sensitivity_topic(&c.sensitivity_at_speed),
        "noise_current_a": c.noise_current_a,
        "high_frequency_gain_a_per_m": c.high_frequency_gain_a_per_m,
        "minimum_stiffness_n_per_m": c.stiffness_n_per_m,
        "minimum_stiffness_at_top_speed_n_per_m": c.stiffness_at_speed_n_per_m,
        "evaluations": c.evaluations,
        "certificates": {
            "nominal": verification_topic(&c.nominal),
            "modes_lowered": verification_topic(&c.lowered),
            "modes_raised": verification_topic(&c.raised),
            "modes_alone_and_combined": {
                "shift": c.shifted.shift,
                "loops": c.shifted.loops,
                "worst_growth_rate_per_s": c.shifted.worst_growth_rate_per_s,
                "worst_frequency_factors": c.shifted.worst_factors,
                "worst_speed_rpm": c.shifted.worst_speed_rpm,
            },
        },
    })
}

fn sensitivity_topic(both: &[PeakSensitivity; 2]) -> Value {
    let [front, rear] = both
        .each_ref()
        .map(|p| json!({ "attained_db": p.db, "not_above_db": p.upper_db, "frequency_hz": p.frequency_hz }));
    json!({ "front": front, "rear": rear })
}
