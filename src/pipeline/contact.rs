//! Contact with the backup bearings: one push at the tool at top speed, with two controllers.

use super::PipelineError;
use crate::controller::anti_windup::firmware_rows;
use crate::controller::arithmetic::float32;
use crate::controller::scaling::{ScaledRealisation, SignalLimits};
use crate::controller::{ControlLaw, Controller};
use crate::predict::recovery::{Recovery, touching_force_n};
use crate::predict::time::{TimeResponse, TimeSettings};
use crate::predict::time_cases::{PUSH_S, StandardCase, run_case};
use crate::spindle::Machine;
use std::f64::consts::TAU;

/// Length of what is computed of the push, s.
const SHOWN_S: f64 = 0.1;

/// What the push did.
#[derive(Clone, Debug)]
pub struct Contact {
    /// Peak of the half-sine force, N: a rotor held with the largest current just touches the backup bearings.
    pub force_n: f64,
    /// Length of the push, s.
    pub length_s: f64,
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Largest current that the firmware commands, A.
    pub current_limit_a: f64,
    /// Bus voltage of the amplifiers, V.
    pub voltage_limit_v: f64,
    /// Response with the delivered controller.
    pub delivered: TimeResponse,
    /// Response with the PID, if there is one.
    pub pid: Option<TimeResponse>,
}

/// Pushes the tool with the delivered rows and with a sampled PID, both in float32 and with anti-windup.
///
/// # Errors
/// [`PipelineError`] when the rows of the PID cannot be scaled, or the simulation fails.
pub fn contact(
    machine: &Machine,
    delivered: &ScaledRealisation,
    pid: Option<&Controller>,
) -> Result<Contact, PipelineError> {
    let limits = SignalLimits::of(machine);
    let force_n = touching_force_n(machine, limits.output_a, PUSH_S)?;
    let with_pid = || match pid.map(|p| &p.law) {
        Some(ControlLaw::Discrete(law)) => {
            let (rows, _) = firmware_rows(law, machine)?;
            push_tool(machine, &rows, force_n).map(Some)
        }
        _ => Ok(None),
    };
    let (delivered, pid) = rayon::join(|| push_tool(machine, delivered, force_n), with_pid);
    Ok(Contact {
        force_n,
        length_s: PUSH_S,
        speed_rpm: machine.spindle.max_rpm,
        current_limit_a: limits.output_a,
        voltage_limit_v: TimeSettings::default().bus_voltage_v,
        delivered: delivered?,
        pid: pid?,
    })
}

/// True when the rotor comes free again after the push that [`contact`] makes.
pub(super) fn recovers(machine: &Machine, rows: &ScaledRealisation) -> Result<bool, PipelineError> {
    let force_n = touching_force_n(machine, SignalLimits::of(machine).output_a, PUSH_S)?;
    Ok(Recovery::of(machine, &push_tool(machine, rows, force_n)?) != Recovery::Lost)
}

fn push_tool(machine: &Machine, rows: &ScaledRealisation, force_n: f64) -> Result<TimeResponse, PipelineError> {
    let case = StandardCase::Impulse { force_n, length_s: PUSH_S };
    let speed = machine.spindle.max_rpm * TAU / 60.0;
    let settings = TimeSettings::default();
    let program = float32(rows)?;
    Ok(run_case(machine, &program, case, speed, SHOWN_S, &settings)?)
}
