//! Figures of a time response beside their limits, and the frames of its animation.

use super::plot::Role;
use super::plot::animation::{AnimatedMotion, OrbitPlane};
use super::plot::figure::{Figure, Series};
use super::plot::motion::{time_panel, time_responses};
use super::summary::omit_absent;
use crate::controller::anti_windup::AntiWindup;
use crate::pipeline::simulation::{Simulated, SimulationLimits};
use crate::predict::recovery::Recovery;
use crate::predict::shaft_line::ShaftLine;
use crate::predict::time::{TimeResponse, TimeSample};
use crate::predict::time_cases::Quantisation;
use crate::spindle::{Machine, SpindleError};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Frames of an animation at most, and stations along its shaft.
const FRAMES: usize = 96;
const STATIONS: usize = 25;
/// Turns shown of a steady rotation, and its frames a turn.
const TURNS: usize = 2;
/// A response is shown until what follows stays below this part of its largest displacement.
const QUIET: f64 = 0.05;

/// Values at each bearing.
fn at_bearings([front, rear]: [f64; 2]) -> Value {
    json!({ "front": front, "rear": rear })
}

/// Values at the tool and at each bearing.
fn at_places([tool, front, rear]: [f64; 3]) -> Value {
    json!({ "tool": tool, "front": front, "rear": rear })
}

/// `simulation.quantisation`.
pub(crate) fn quantisation_topic(found: &Quantisation) -> Value {
    json!({
        "quantum_m": found.quantum_m,
        "displacement_m": at_places(found.displacement_m),
        "part_of_settled_displacement": found.part,
        "dominates": found.dominates(),
    })
}

/// `simulation`: a simulation of a machine, with the anti-windup of the controller.
pub(crate) fn simulation_topic(machine: &Machine, simulated: &Simulated, anti_windup: &AntiWindup) -> Value {
    let (response, found) = (&simulated.response, &simulated.figures);
    let limits = &simulated.limits;
    let (front, rear) = (&machine.spindle.front, &machine.spindle.rear);
    let clearance = machine.spindle.backup_clearance_m;
    let capacity = [front.max_force_n, rear.max_force_n];
    // What is left of each limit: one is all, zero is the limit itself.
    let margin = |peak: [f64; 2], limit: [f64; 2]| at_bearings([1.0 - peak[0] / limit[0], 1.0 - peak[1] / limit[1]]);
    let [_, front, rear] = found.displacement_m;
    let topic = json!({
        "peak_displacement_m": at_places(found.displacement_m),
        "settled_displacement_m": at_places(found.settled_displacement_m),
        "backup_clearance_m": clearance,
        "clearance_ratio": found.clearance_ratio,
        // None of a loop that is unstable: what it does in a moment tells no zone.
        "vibration_zone_iso_14839_2": simulated.stable.then(|| vibration_zone(found.clearance_ratio)),
        "peak_current_a": at_bearings(found.current_a),
        "current_limit_a": limits.current_a,
        "peak_voltage_v": at_bearings(found.voltage_v),
        "voltage_limit_v": limits.voltage_v,
        "peak_force_n": at_bearings(found.force_n),
        "force_limit_n": at_bearings(capacity),
        "margin": {
            "displacement": margin([front, rear], [clearance; 2]),
            "current": margin(found.current_a, [limits.current_a; 2]),
            "voltage": margin(found.voltage_v, [limits.voltage_v; 2]),
            "force": margin(found.force_n, capacity),
        },
        "peak_contact_force_n": found.contact_force_n,
        "share_current_limited": response.current_limited,
        "share_voltage_limited": response.voltage_limited,
        "share_in_contact": response.in_contact,
        "diverged": response.diverged,
        "anti_windup": anti_windup_topic(anti_windup),
        "backup_bearings": recovery_topic(simulated.recovery),
        "quantisation": quantisation_topic(&simulated.steps),
    });
    omit_absent(topic, &["vibration_zone_iso_14839_2"])
}

/// What became of the rotor: whether it touches the backup bearings, whether it comes free again, and how soon.
pub(crate) fn recovery_topic(recovery: Recovery) -> Value {
    json!({
        "touches": recovery != Recovery::Clear,
        "recovers": recovery != Recovery::Lost,
        "recovery_s": match recovery {
            Recovery::Recovered { after_s } => Some(after_s),
            _ => None,
        },
        "sentence": recovery.sentence(),
    })
}

/// The anti-windup of a controller: its rate, and the smallest gains of a saturation that its loop stands.
pub(crate) fn anti_windup_topic(found: &AntiWindup) -> Value {
    let conditioned =
        (0..found.gain.nrows()).filter(|i| (0..found.gain.ncols()).any(|j| found.gain[(*i, j)] != 0.0)).count();
    json!({
        "conditioned_states": conditioned,
        "rate_1_s": found.rate_1_s,
        "forgetting_1_s": found.forgetting_1_s,
        "smallest_gain_with_margin": found.smallest_gain,
        "smallest_gain_with_margin_without": found.smallest_gain_without,
        "smallest_gain_circle_criterion": found.circle_gain,
    })
}

/// The same push with several controllers: displacement of both bearings in x, and the current of the front one.
pub(crate) fn push_figure(
    machine: &Machine,
    title: &str,
    responses: &[(&str, Role, &TimeResponse)],
    limits: &SimulationLimits,
) -> Figure {
    let clearance = 1e6 * machine.spindle.backup_clearance_m;
    let stops = [(clearance, "backup bearing"), (-clearance, "backup bearing")];
    let current_a = [(limits.current_a, "limit"), (-limits.current_a, "limit")];
    let panel = |title, quantity, limits: &[(f64, &str)], of: fn(&TimeSample) -> f64| {
        let series = responses.iter().map(|(name, role, response)| over_time(name, *role, response, &of));
        time_panel(title, quantity, series.collect(), limits)
    };
    let panels = vec![
        panel("Front bearing x", ["x", "µm"], &stops, |s| 1e6 * s.displacements_m[2]),
        panel("Rear bearing x", ["x", "µm"], &stops, |s| 1e6 * s.displacements_m[4]),
        panel("Control current front x", ["i", "A"], &current_a, |s| s.currents_a[0]),
    ];
    time_responses(title, panels)
}

/// A quantity of a response over time in ms.
pub(super) fn over_time(name: &str, role: Role, response: &TimeResponse, of: &dyn Fn(&TimeSample) -> f64) -> Series {
    Series::of_points(name, response.samples.iter().map(|s| (1e3 * s.time_s, of(s))), role.look())
}

/// Zone of ISO 14839-2 by the displacement in parts of the clearance: A and B end at 0.3 and 0.4, C at 0.5.
fn vibration_zone(clearance_ratio: f64) -> &'static str {
    match clearance_ratio {
        r if r < 0.3 => "A",
        r if r < 0.4 => "B",
        r if r < 0.5 => "C",
        _ => "D",
    }
}

/// The motion of the shaft: the last turns of a steady rotation, else the response until it is quiet.
pub(crate) fn motion(
    machine: &Machine,
    response: &TimeResponse,
    title: &str,
    speed_rad_s: f64,
) -> Result<AnimatedMotion, SpindleError> {
    let line = ShaftLine::new(machine, STATIONS)?;
    let samples = &response.samples;
    let period = machine.spindle.electronics.sample_period_s();
    let (from, to) = window(samples, speed_rad_s, period);
    let steps = ((to - from) / period).ceil().clamp(2.0, FRAMES as f64) as usize;
    let time_s: Vec<f64> = (0..=steps).map(|k| from + (to - from) * k as f64 / steps as f64).collect();
    let at: Vec<[f64; 6]> = time_s.iter().map(|t| interpolate_samples(samples, t / period)).collect();
    let frames = at.iter().map(|d| [line.through([d[0], d[2], d[4]]), line.through([d[1], d[3], d[5]])]).collect();
    let planes = &machine.spindle.planes;
    let plane = |name: &str, position_m: f64, in_bearing: bool, k: usize| OrbitPlane {
        name: name.to_owned(),
        position_m,
        in_bearing,
        path_m: at.iter().map(|d| [d[2 * k], d[2 * k + 1]]).collect(),
    };
    Ok(AnimatedMotion {
        title: title.to_owned(),
        position_m: line.position_m.clone(),
        frames,
        time_s,
        planes: vec![
            plane("tool", machine.tool_plane_m(), false, 0),
            plane("front actuator", planes.front_actuator_m, true, 1),
            plane("rear actuator", planes.rear_actuator_m, true, 2),
        ],
        clearance_m: machine.spindle.backup_clearance_m,
        seconds: 6.0,
    })
}

/// Start and end of what is shown, s.
fn window(samples: &[TimeSample], speed_rad_s: f64, period: f64) -> (f64, f64) {
    let end = samples.len().saturating_sub(1) as f64 * period;
    let turns = TURNS as f64 * TAU / speed_rad_s;
    let size = |s: &TimeSample| s.displacements_m.iter().fold(0.0f64, |a, d| a.max(d.abs()));
    let largest = samples.iter().map(size).fold(0.0, f64::max);
    let last_size = samples.last().map_or(0.0, size);
    // A steady rotation does not come to rest: its last turns close on themselves.
    if speed_rad_s > 0.0 && turns < end && last_size > QUIET * largest {
        return (end - turns, end);
    }
    let rest = samples.last().map(|s| s.displacements_m).unwrap_or_default();
    let moves = |s: &TimeSample| {
        let away = s.displacements_m.iter().zip(&rest);
        away.map(|(d, r)| (d - r).abs()).fold(0.0, f64::max) > QUIET * largest
    };
    let quiet = samples.iter().rposition(moves).map_or(0, |k| k + 1);
    (0.0, (quiet as f64 * period).clamp((20.0 * period).min(end), end))
}

/// Displacements between two samples.
fn interpolate_samples(samples: &[TimeSample], place: f64) -> [f64; 6] {
    let k = place.max(0.0).floor() as usize;
    let last = samples.len().saturating_sub(1);
    let of = |k: usize| samples.get(k.min(last)).map(|s| s.displacements_m).unwrap_or_default();
    let (a, b, t) = (of(k), of(k + 1), place - place.floor());
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}
