//! The report of a PID: its numbers, stability over speed, stiffness, zone and margins, and the controller's file.

use super::compared::StabilitySummary;
use super::pid_summary::PidSummary;
use super::plot::Role;
use super::run_figures::predictions;
use super::summary::finite;
use super::unstable::{InstabilitySummary, SearchSummary};
use super::whole::{Report, ReportError};
use crate::controller::speed_proof::SpeedProof;
use crate::pid::parameters::{AxisParameters, Biquad};
use crate::pid::settings::TuneSettings;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::pid_loop::{PidLoop, PidOrigin};
use crate::spindle::Machine;
use serde::Serialize;
use std::f64::consts::TAU;

/// Numbers of a tuned PID at one bearing: kp (1 + wᵢ/s + T_d s/(1 + s/w_d)), a roll-off and two sections.
#[derive(Clone, Debug, Serialize)]
struct NumbersSummary {
    gain_a_per_m: Option<f64>,
    integral_hz: Option<f64>,
    derivative_s: Option<f64>,
    derivative_rolloff_hz: Option<f64>,
    rolloff_hz: Option<f64>,
    sections: Vec<SectionSummary>,
}

/// (s²/w_z² + 2ζ_z s/w_z + 1)/(s²/w_p² + 2ζ_p s/w_p + 1).
#[derive(Clone, Debug, Serialize)]
struct SectionSummary {
    zero_hz: Option<f64>,
    zero_damping: Option<f64>,
    pole_hz: Option<f64>,
    pole_damping: Option<f64>,
}

/// The loop at a speed: a record of `stiffness.over_speed`.
#[derive(Clone, Debug, Serialize)]
struct SpeedSummary {
    speed_rpm: Option<f64>,
    growth_rate_per_s: Option<f64>,
    minimum_n_per_m: Option<f64>,
    minimum_frequency_hz: Option<f64>,
    sensitivity_peak_db: Option<f64>,
    zone: &'static str,
}

/// Summary, pictures and controller file of a PID.
pub(crate) fn pid_report(machine: &Machine, found: &PidLoop, settings: &TuneSettings) -> Result<Report, ReportError> {
    let mut report = Report::of("pid", machine);
    let words = found.words();
    report.verdict(found.meets(settings), &words);
    let summary = &mut report.summary;
    summary.set("controller", found.pid.controller.name.as_str());
    if let PidOrigin::Tuned(pid) = &found.pid.origin {
        summary.set("pid", PidSummary::of(pid, settings, "those asked for"));
        summary.set("pid.front", NumbersSummary::from(&pid.parameters.front));
        summary.set("pid.rear", NumbersSummary::from(&pid.parameters.rear));
    }
    summary.set("stability.pid", StabilitySummary::from(&found.verification));
    if let Some((_, law)) = &found.pid.further {
        summary.set("search", SearchSummary::from(law));
    }
    if let Some(instability) = &found.instability {
        let proven_to_rpm = found.verification.proof.as_ref().map_or(0.0, SpeedProof::proven_to_rpm);
        summary.set("instability", InstabilitySummary::of(instability, &words, proven_to_rpm));
    }
    report.predictions("pid", found.ends.each_ref());
    let speeds: Vec<SpeedSummary> = found.predictions.iter().map(SpeedSummary::from).collect();
    report.summary.set("stiffness.over_speed", speeds);
    let drawn: Vec<(Role, &Prediction)> = found.predictions.iter().map(|p| (Role::Pid, p)).collect();
    let top_rpm = machine.spindle.max_rpm;
    report.figures(predictions(&drawn, &[], top_rpm / 60.0))?;
    report.loop_of("pid", &found.curves, found.ends.each_ref(), top_rpm)?;
    report.controller_alone(machine, &found.pid.controller)?;
    Ok(report)
}

impl From<&AxisParameters> for NumbersSummary {
    fn from(axis: &AxisParameters) -> Self {
        Self {
            gain_a_per_m: finite(axis.gain_a_per_m),
            integral_hz: finite(axis.integral_rad_s / TAU),
            derivative_s: finite(axis.derivative_s),
            derivative_rolloff_hz: finite(axis.derivative_corner_rad_s / TAU),
            rolloff_hz: finite(axis.lowpass_rad_s / TAU),
            sections: axis.biquads.iter().map(SectionSummary::from).collect(),
        }
    }
}

impl From<&Biquad> for SectionSummary {
    fn from(section: &Biquad) -> Self {
        Self {
            zero_hz: finite(section.zero_rad_s / TAU),
            zero_damping: finite(section.zero_damping),
            pole_hz: finite(section.pole_rad_s / TAU),
            pole_damping: finite(section.pole_damping),
        }
    }
}

impl From<&Prediction> for SpeedSummary {
    fn from(at: &Prediction) -> Self {
        Self {
            speed_rpm: finite(at.speed_rpm),
            growth_rate_per_s: finite(at.growth_rate_per_s),
            minimum_n_per_m: finite(at.minimum.0),
            minimum_frequency_hz: finite(at.minimum.1),
            sensitivity_peak_db: at.is_stable().then(|| at.sensitivity_peak_db()).and_then(finite),
            zone: at.zone_word(),
        }
    }
}
