//! The report of a PID: its numbers, stability over speed, stiffness, zone and margins, and the controller's file.

use super::compared::stability_topic;
use super::pid_summary::{numbers_topic, pid_topic};
use super::plot::Role;
use super::run_figures::predictions;
use super::unstable::{instability_topic, search_topic};
use super::whole::{Report, ReportError};
use crate::controller::speed_proof::SpeedProof;
use crate::pid::settings::TuneSettings;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::pid_loop::{PidLoop, PidOrigin};
use crate::spindle::Machine;
use serde_json::{Value, json};

/// Summary, pictures and controller file of a PID.
pub(crate) fn pid_report(machine: &Machine, found: &PidLoop, settings: &TuneSettings) -> Result<Report, ReportError> {
    let mut report = Report::of("pid", machine);
    let words = found.words(settings);
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
