//! A time response as table and pictures: displacements, currents, voltages and forces beside their limits, orbits.

use super::pictures::Picture;
use super::plot::animation::animate;
use super::plot::motion::{TimePanel, orbits, time_responses};
use super::plot::{Curve, Role};
use super::simulation::{motion, simulation_topic};
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
    let column = |of: &dyn Fn(&TimeSample) -> f64| response.samples.iter().map(of).collect();
    let [tx, ty, fx, fy, rx, ry] = [0, 1, 2, 3, 4, 5].map(|k| -> Vec<f64> { column(&|s| s.displacements_m[k]) });
    let micro = |v: &[f64]| v.iter().map(|m| 1e6 * m).collect::<Vec<f64>>();
    let shown = [micro(&tx), micro(&fx), micro(&rx)];
    // Front x and rear x.
    let [currents, voltages, forces] =
        [|s: &TimeSample| s.currents_a, |s: &TimeSample| s.voltages_v, |s: &TimeSample| s.forces_n]
            .map(|of| [0, 2].map(|k| -> Vec<f64> { column(&|s| of(s)[k]) }));
    let time: Vec<f64> = column(&|s| s.time_s);
    let spindle = &machine.spindle;
    let clearance = 1e6 * spindle.backup_clearance_m;
    let at_bearings = |values| curves(&time, &["front", "rear"], values);
    let both = |limit: f64, name| [(limit, name), (-limit, name)];
    let places = curves(&time, &["tool", "front", "rear"], &shown);
    let capacity = [(spindle.front.max_force_n, "front capacity"), (spindle.rear.max_force_n, "rear capacity")];
    let panels = [
        TimePanel::of("Displacement x", ["x", "µm"], places, both(clearance, "backup bearing")),
        TimePanel::of("Control current x", ["i", "A"], at_bearings(&currents), both(limits.current_a, "limit")),
        TimePanel::of("Coil voltage x", ["u", "V"], at_bearings(&voltages), both(limits.voltage_v, "bus")),
        TimePanel::of("Magnetic force x", ["F", "N"], at_bearings(&forces), capacity),
    ];
    let planes = [("tool", tx.as_slice(), ty.as_slice()), ("front actuator", &fx, &fy), ("rear actuator", &rx, &ry)];
    let title = format!("Orbits, {name}");
    report.figures([
        (Picture::Response, time_responses(&format!("Response to {name}"), &panels)),
        (Picture::Orbits, orbits(&title, &planes, spindle.backup_clearance_m)),
    ])
}

/// One record a sample: sensors, displacements, currents, voltages, forces, contact.
fn table(response: &TimeResponse) -> Table {
    let mut header = vec!["time_s".to_owned()];
    header.extend(AXES.map(|a| format!("sensor_{a}_m")));
    header.extend(PLACES.map(|p| format!("displacement_{p}_m")));
    header.extend(AXES.map(|a| format!("current_{a}_a")));
    header.extend(AXES.map(|a| format!("voltage_{a}_v")));
    header.extend(AXES.map(|a| format!("force_{a}_n")));
    header.extend(AXES.map(|a| format!("contact_{a}_n")));
    let mut table = Table::new(header);
    for s in &response.samples {
        let row: Vec<f64> = std::iter::once(s.time_s)
            .chain(s.sensors_m)
            .chain(s.displacements_m)
            .chain(s.currents_a)
            .chain(s.voltages_v)
            .chain(s.forces_n)
            .chain(s.contact_n)
            .collect();
        table.push_numbers(&row);
    }
    table
}

/// Curves over one time axis, told apart by number.
fn curves<'a>(time: &'a [f64], names: &[&'a str], values: &'a [Vec<f64>]) -> Vec<Curve<'a>> {
    names
        .iter()
        .zip(values)
        .enumerate()
        .map(|(k, (name, y))| Curve { name, x: time, y, role: Role::Other(k) })
        .collect()
}
