//! A PID as the topic `pid` of the summary: the figures of its certificate beside their limits.

use super::speed_summary::verification_topic;
use crate::pid::certificate::{PeakSensitivity, PidCertificate, TunedPid, ZONE_B_DB};
use crate::pid::parameters::{AxisParameters, Biquad};
use crate::pid::settings::TuneSettings;
use serde_json::{Value, json};
use std::f64::consts::TAU;

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

/// Numbers of a tuned PID at one bearing: kp (1 + wᵢ/s + T_d s/(1 + s/w_d)), a roll-off and two sections
/// (s²/w_z² + 2ζ_z s/w_z + 1)/(s²/w_p² + 2ζ_p s/w_p + 1).
pub(super) fn numbers_topic(axis: &AxisParameters) -> Value {
    let section = |s: &Biquad| {
        json!({
            "zero_hz": s.zero_rad_s / TAU,
            "zero_damping": s.zero_damping,
            "pole_hz": s.pole_rad_s / TAU,
            "pole_damping": s.pole_damping,
        })
    };
    json!({
        "gain_a_per_m": axis.gain_a_per_m,
        "integral_hz": axis.integral_rad_s / TAU,
        "derivative_s": axis.derivative_s,
        "derivative_rolloff_hz": axis.derivative_corner_rad_s / TAU,
        "rolloff_hz": axis.lowpass_rad_s / TAU,
        "sections": axis.biquads.iter().map(section).collect::<Vec<_>>(),
    })
}
