//! The report of a PID: its numbers, stability over speed, stiffness, zone and margins, and the controller's file.

use super::compared::stability_topic;
use super::pid_summary::pid_topic;
use super::plot::Role;
use super::run_figures::predictions;
use super::unstable::{instability_topic, search_topic};
use super::whole::{Report, ReportError};
use crate::controller::speed_proof::SpeedProof;
use crate::pid::parameters::{AxisParameters, Biquad};
use crate::pid::settings::TuneSettings;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::pid_loop::{PidLoop, PidOrigin};
use crate::spindle::Machine;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Summary, pictures and controller file of a PID.
pub(crate) fn pid_report(machine: &Machine, found: &PidLoop, settings: &TuneSettings) -> Result<Report, ReportError> {
    let mut report = Report::of("pid", machine);
    let words = found.words();
    report.verdict(found.meets(settings), &words);
    let summary = &mut report.summary;
    summary.set("controller", found.pid.controller.name.as_str());
    if let PidOrigin::Tuned(pid) = &found.pid.origin {
        summary.set("pid", pid_topic(pid, settings, "those asked for"));
        summary.set("pid.front", numbers_topic(&pid.parameters.front));
        summary.set("pid.rear", numbers_topic(&pid.parameters.rear));
    }
    summary.set("stability.pid", stability_topic(&found.verification));
    if let Some((_, law)) = &found.pid.further {
        summary.set("search", search_topic(law));
    }
    if let Some(instability) = &found.instability {
        let proven_to_rpm = found.verification.proof.as_ref().map_or(0.0, SpeedProof::proven_to_rpm);
        summary.set("instability", instability_topic(instability, &words, proven_to_rpm, None));
    }
    report.predictions("pid", found.ends.each_ref());
    let speeds: Vec<Value> = found.predictions.iter().map(speed_topic).collect();
    report.summary.set("stiffness.over_speed", speeds);
    let drawn: Vec<(Role, &Prediction)> = found.predictions.iter().map(|p| (Role::Pid, p)).collect();
    let top_rpm = machine.spindle.max_rpm;
    report.figures(predictions(&drawn, &[], top_rpm / 60.0))?;
    report.loop_of("pid", &found.curves, found.ends.each_ref(), top_rpm)?;
    report.controller_alone(machine, &found.pid.controller)?;
    Ok(report)
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

/// The loop at a speed: a record of `stiffness.over_speed`.
fn speed_topic(at: &Prediction) -> Value {
    json!({
        "speed_rpm": at.speed_rpm,
        "growth_rate_per_s": at.growth_rate_per_s,
        "minimum_n_per_m": at.minimum.0,
        "minimum_frequency_hz": at.minimum.1,
        "sensitivity_peak_db": at.is_stable().then(|| at.sensitivity_peak_db()),
        "zone": at.zone_word(),
    })
}
