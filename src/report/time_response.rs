//! A time response as table and pictures: displacements, currents, voltages and forces beside their limits, orbits.

use super::pictures::Picture;
use super::plot::Role;
use super::plot::animation::animate;
use super::plot::motion::{orbits, time_panel, time_responses};
use super::simulation::{motion, over_time, simulation_topic};
use super::tables::Table;
use super::whole::{Report, ReportError};
use crate::pipeline::simulation::{SimulatedController, SimulationLimits};
use crate::predict::time::{TimeResponse, TimeSample};
use crate::predict::time_cases::StandardCase;
use crate::spindle::Machine;
use std::f64::consts::TAU;

/// Names of the axes of sensors and magnets, and of the places whose displacement is recorded.
const AXES: [&str; 4] = ["front_x", "front_y", "rear_x", "rear_y"];
const PLACES: [&str; 6] = ["tool_x", "tool_y", "front_x", "front_y", "rear_x", "rear_y"];

/// The report of a simulation: figures, `response.csv`, pictures, and the shaft in motion; `case` is its name.
pub(crate) fn simulation_report(
    machine: &Machine,
    controller: &str,
    case: &str,
    simulated: &SimulatedController,
) -> Result<Report, ReportError> {
    let SimulatedController { scenario, growth_rate_per_s, anti_windup, found } = simulated;
    let mut report = Report::of("simulate", machine);
    let summary = &mut report.summary;
    summary.set("controller", controller);
    summary.set("case", case);
    summary.set("speed_rpm", scenario.speed_rpm);
    summary.set("duration_s", scenario.duration_s);
    summary.set("stability.stable", found.stable);
    summary.set("stability.growth_rate_per_s", growth_rate_per_s);
    if let StandardCase::Impulse { force_n, .. } | StandardCase::Step { force_n } = scenario.case {
        summary.set("force_n", force_n);
    }
    if let StandardCase::Impulse { length_s, .. } = scenario.case {
        summary.set("push_s", length_s);
    }
    summary.set("simulation", simulation_topic(machine, found, anti_windup));
    report.verdict(found.met, &found.end);
    add_response(&mut report, machine, &found.response, case, &found.limits)?;
    let title = format!("Shaft in motion, {case}");
    let moving = animate(&motion(machine, &found.response, &title, scenario.speed_rpm * TAU / 60.0)?);
    report.folder.add_picture(Picture::Animation, moving)?;
    Ok(report)
}

/// Adds `response.csv` and the pictures `response` and `orbits`.
fn add_response(
    report: &mut Report,
    machine: &Machine,
    response: &TimeResponse,
    name: &str,
    limits: &SimulationLimits,
) -> Result<(), ReportError> {
    report.folder.add_table("response.csv", &table(response))?;
    let spindle = &machine.spindle;
    let clearance = 1e6 * spindle.backup_clearance_m;
    let both = |limit: f64, name| [(limit, name), (-limit, name)];
    let capacity = [(spindle.front.max_force_n, "front capacity"), (spindle.rear.max_force_n, "rear capacity")];
    let series = |k: usize, name: &str, of: &dyn Fn(&TimeSample) -> f64| over_time(name, Role::Other(k), response, of);
    let place = |k, name, place: usize| series(k, name, &|s| 1e6 * s.displacements_m[place]);
    // Front x and rear x.
    let bearings =
        |of: fn(&TimeSample) -> [f64; 4]| vec![series(0, "front", &|s| of(s)[0]), series(1, "rear", &|s| of(s)[2])];
    let places = vec![place(0, "tool", 0), place(1, "front", 2), place(2, "rear", 4)];
    let panels = vec![
        time_panel("Displacement x", ["x", "µm"], places, &both(clearance, "backup bearing")),
        time_panel("Control current x", ["i", "A"], bearings(|s| s.currents_a), &both(limits.current_a, "limit")),
        time_panel("Coil voltage x", ["u", "V"], bearings(|s| s.voltages_v), &both(limits.voltage_v, "bus")),
        time_panel("Magnetic force x", ["F", "N"], bearings(|s| s.forces_n), &capacity),
    ];
    let path = |k: usize| response.samples.iter().map(|s| s.displacements_m[k]).collect::<Vec<f64>>();
    let [tx, ty, fx, fy, rx, ry] = [0, 1, 2, 3, 4, 5].map(path);
    let planes = [("tool", tx.as_slice(), ty.as_slice()), ("front actuator", &fx, &fy), ("rear actuator", &rx, &ry)];
    report.figures([
        (Picture::Response, time_responses(&format!("Response to {name}"), panels)),
        (Picture::Orbits, orbits(&format!("Orbits, {name}"), &planes, spindle.backup_clearance_m)),
    ])
}

/// One record a sample: sensors, displacements, currents, voltages, forces, contact.
fn table(response: &TimeResponse) -> Table {
    let mut header = vec!["time_s".to_owned()];
    header.extend(AXES.map(|a| format!("sensor_{a}_m")));
    header.extend(PLACES.map(|p| format!("displacement_{p}_m")));
    for (quantity, unit) in [("current", "a"), ("voltage", "v"), ("force", "n"), ("contact", "n")] {
        header.extend(AXES.map(|a| format!("{quantity}_{a}_{unit}")));
    }
    let mut table = Table::new(header);
    for s in &response.samples {
        let at_sensors = [&[s.time_s][..], &s.sensors_m, &s.displacements_m];
        let at_magnets = [s.currents_a, s.voltages_v, s.forces_n, s.contact_n];
        table.push_numbers(&[at_sensors.concat(), at_magnets.concat()].concat());
    }
    table
}
