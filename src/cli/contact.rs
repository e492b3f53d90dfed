//! The touch of the backup bearings in the report of a run: the same push for the designed controller and for the PID.

use super::Failure;
use super::export::signal_limits;
use crate::controller::ControlLaw;
use crate::controller::anti_windup::with_anti_windup;
use crate::controller::arithmetic::float32;
use crate::controller::pid_certificate::TunedPid;
use crate::controller::realise::modal_form;
use crate::controller::scaling::{ScaledRealisation, scaled};
use crate::pipeline::design::Design;
use crate::predict::recovery::{Recovery, touching_force_n};
use crate::predict::time::{TimeResponse, TimeSettings};
use crate::predict::time_cases::{Case, run_case};
use crate::report::plot::Role;
use crate::report::results::ResultsFolder;
use crate::report::simulation::{Limits, push_figure, recovery_json};
use crate::report::summary::{Summary, number};
use crate::spindle::Machine;
use std::f64::consts::TAU;

/// Length of the push and of what is shown of it, s.
const PUSH_S: f64 = 5e-4;
const SHOWN_S: f64 = 0.1;

/// Pushes the rotor into its backup bearings at the top speed; figure, `simulation` object and the sentence about it.
pub fn add_contact(
    folder: &mut ResultsFolder,
    summary: &mut Summary,
    machine: &Machine,
    design: &Design,
    pid: Option<&TunedPid>,
) -> Result<String, Failure> {
    let limits = Limits {
        current_a: signal_limits(machine).output_a,
        voltage_v: TimeSettings::default().bus_voltage_v,
    };
    let force_n = touching_force_n(machine, limits.current_a, PUSH_S)?;
    let top_rpm = machine.spindle.max_rpm;
    let mu = pushed(machine, &design.delivery.realisation, force_n)?;
    let mut runs = vec![("mu", "μ", Role::Mu, mu)];
    if let Some(ControlLaw::Discrete(law)) = pid.map(|p| &p.controller.law) {
        let unlimited = scaled(&modal_form(law)?, signal_limits(machine))?;
        let (rows, _) = with_anti_windup(unlimited, machine)?;
        runs.push(("pid", "PID", Role::Pid, pushed(machine, &rows, force_n)?));
    }
    summary.set("simulation.contact.force_n", number(force_n));
    summary.set("simulation.contact.speed_rpm", number(top_rpm));
    let mut sentences = Vec::new();
    for (key, name, _, response) in &runs {
        let recovery = Recovery::of(machine, response);
        summary.set(
            &format!("simulation.contact.{key}"),
            recovery_json(recovery),
        );
        sentences.push(format!(
            "with the {name} controller {}",
            recovery.sentence()
        ));
    }
    let shown: Vec<(&str, Role, &TimeResponse)> = runs
        .iter()
        .map(|(_, name, role, r)| (*name, *role, r))
        .collect();
    let title = format!("Push of {force_n:.0} N at the tool, {top_rpm:.0} rpm");
    folder.add_plot("contact", &push_figure(machine, &title, &shown, &limits))?;
    Ok(format!(
        "After a half-sine push of {force_n:.0} N and {:.1} ms at the tool at {top_rpm:.0} rpm: {}.",
        1e3 * PUSH_S,
        sentences.join("; ")
    ))
}

fn pushed(
    machine: &Machine,
    rows: &ScaledRealisation,
    force_n: f64,
) -> Result<TimeResponse, Failure> {
    let case = Case::Impulse {
        force_n,
        length_s: PUSH_S,
    };
    let speed = machine.spindle.max_rpm * TAU / 60.0;
    let settings = TimeSettings::default();
    let program = float32(rows)?;
    Ok(run_case(
        machine, &program, case, speed, SHOWN_S, &settings,
    )?)
}
