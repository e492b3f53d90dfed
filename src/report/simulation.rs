//! Figures of a time response beside their limits, and the frames of its animation.

use super::plot::animation::{AnimatedMotion, OrbitPlane};
use super::plot::figure::Figure;
use super::plot::motion::{TimePanel, time_responses};
use super::plot::{Curve, Role};
use super::summary::finite;
use crate::controller::anti_windup::AntiWindup;
use crate::pipeline::simulation::{Simulated, SimulationLimits};
use crate::predict::recovery::Recovery;
use crate::predict::shaft_line::ShaftLine;
use crate::predict::time::{TimeResponse, TimeSample};
use crate::predict::time_cases::Quantisation;
use crate::spindle::{Machine, SpindleError};
use serde::Serialize;
use std::f64::consts::TAU;

/// Frames of an animation at most, and stations along its shaft.
const FRAMES: usize = 96;
const STATIONS: usize = 25;
/// Turns shown of a steady rotation, and its frames a turn.
const TURNS: usize = 2;
/// A response is shown until what follows stays below this part of its largest displacement.
const QUIET: f64 = 0.05;

/// A value at each bearing.
#[derive(Clone, Debug, Serialize)]
struct Sides {
    front: Option<f64>,
    rear: Option<f64>,
}

impl From<[f64; 2]> for Sides {
    fn from(values: [f64; 2]) -> Self {
        let [front, rear] = values.map(finite);
        Self { front, rear }
    }
}

/// A value at the tool and at each bearing.
#[derive(Clone, Debug, Serialize)]
struct Places {
    tool: Option<f64>,
    front: Option<f64>,
    rear: Option<f64>,
}

impl From<[f64; 3]> for Places {
    fn from(values: [f64; 3]) -> Self {
        let [tool, front, rear] = values.map(finite);
        Self { tool, front, rear }
    }
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct QuantisationSummary {
    quantum_m: Option<f64>,
    displacement_m: Places,
    part_of_settled_displacement: Option<f64>,
    dominates: bool,
}

impl From<&Quantisation> for QuantisationSummary {
    fn from(found: &Quantisation) -> Self {
        Self {
            quantum_m: finite(found.quantum_m),
            displacement_m: Places::from(found.displacement_m),
            part_of_settled_displacement: finite(found.part),
            dominates: found.dominates(),
        }
    }
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct SimulationSummary {
    peak_displacement_m: Places,
    settled_displacement_m: Places,
    backup_clearance_m: f64,
    clearance_ratio: Option<f64>,
    /// None of a loop that is unstable: what it does in a moment tells no zone.
    #[serde(skip_serializing_if = "Option::is_none")]
    vibration_zone_iso_14839_2: Option<&'static str>,
    peak_current_a: Sides,
    current_limit_a: Option<f64>,
    peak_voltage_v: Sides,
    voltage_limit_v: Option<f64>,
    peak_force_n: Sides,
    force_limit_n: Sides,
    margin: MarginSummary,
    peak_contact_force_n: Option<f64>,
    share_current_limited: Option<f64>,
    share_voltage_limited: Option<f64>,
    share_in_contact: Option<f64>,
    diverged: bool,
    anti_windup: AntiWindupSummary,
    backup_bearings: RecoverySummary,
    quantisation: QuantisationSummary,
}

/// What is left of each limit: one is all, zero is the limit itself.
#[derive(Clone, Debug, Serialize)]
struct MarginSummary {
    displacement: Sides,
    current: Sides,
    voltage: Sides,
    force: Sides,
}

impl SimulationSummary {
    /// Of a simulation of a machine, with the anti-windup of the controller.
    pub(crate) fn of(machine: &Machine, simulated: &Simulated, anti_windup: &AntiWindup) -> Self {
        let (response, found) = (&simulated.response, &simulated.figures);
        let limits = &simulated.limits;
        let (front, rear) = (&machine.spindle.front, &machine.spindle.rear);
        let clearance = machine.spindle.backup_clearance_m;
        let capacity = [front.max_force_n, rear.max_force_n];
        let margin =
            |peak: [f64; 2], limit: [f64; 2]| Sides::from([1.0 - peak[0] / limit[0], 1.0 - peak[1] / limit[1]]);
        let [_, front, rear] = found.displacement_m;
        Self {
            peak_displacement_m: Places::from(found.displacement_m),
            settled_displacement_m: Places::from(found.settled_displacement_m),
            backup_clearance_m: clearance,
            clearance_ratio: finite(found.clearance_ratio),
            vibration_zone_iso_14839_2: simulated.stable.then(|| vibration_zone(found.clearance_ratio)),
            peak_current_a: Sides::from(found.current_a),
            current_limit_a: finite(limits.current_a),
            peak_voltage_v: Sides::from(found.voltage_v),
            voltage_limit_v: finite(limits.voltage_v),
            peak_force_n: Sides::from(found.force_n),
            force_limit_n: Sides::from(capacity),
            margin: MarginSummary {
                displacement: margin([front, rear], [clearance; 2]),
                current: margin(found.current_a, [limits.current_a; 2]),
                voltage: margin(found.voltage_v, [limits.voltage_v; 2]),
                force: margin(found.force_n, capacity),
            },
            peak_contact_force_n: finite(found.contact_force_n),
            share_current_limited: finite(response.current_limited),
            share_voltage_limited: finite(response.voltage_limited),
            share_in_contact: finite(response.in_contact),
            diverged: response.diverged,
            anti_windup: AntiWindupSummary::from(anti_windup),
            backup_bearings: RecoverySummary::from(simulated.recovery),
            quantisation: QuantisationSummary::from(&simulated.steps),
        }
    }
}

/// What became of the rotor: whether it touches the backup bearings, whether it comes free again, and how soon.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RecoverySummary {
    touches: bool,
    recovers: bool,
    recovery_s: Option<f64>,
    sentence: String,
}

impl From<Recovery> for RecoverySummary {
    fn from(recovery: Recovery) -> Self {
        Self {
            touches: recovery != Recovery::Clear,
            recovers: recovery != Recovery::Lost,
            recovery_s: match recovery {
                Recovery::Recovered { after_s } => finite(after_s),
                _ => None,
            },
            sentence: recovery.sentence(),
        }
    }
}

/// The anti-windup of a controller: its rate, and the smallest gains of a saturation that its loop stands.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AntiWindupSummary {
    conditioned_states: usize,
    rate_1_s: Option<f64>,
    forgetting_1_s: Option<f64>,
    smallest_gain_with_margin: Option<f64>,
    smallest_gain_with_margin_without: Option<f64>,
    smallest_gain_circle_criterion: Option<f64>,
}

impl From<&AntiWindup> for AntiWindupSummary {
    fn from(found: &AntiWindup) -> Self {
        let conditioned =
            (0..found.gain.nrows()).filter(|i| (0..found.gain.ncols()).any(|j| found.gain[(*i, j)] != 0.0)).count();
        Self {
            conditioned_states: conditioned,
            rate_1_s: finite(found.rate_1_s),
            forgetting_1_s: finite(found.forgetting_1_s),
            smallest_gain_with_margin: finite(found.smallest_gain),
            smallest_gain_with_margin_without: finite(found.smallest_gain_without),
            smallest_gain_circle_criterion: finite(found.circle_gain),
        }
    }
}

/// The same push with several controllers: displacement of both bearings in x, and the current of the front one.
pub(crate) fn push_figure(
    machine: &Machine,
    title: &str,
    responses: &[(&str, Role, &TimeResponse)],
    limits: &SimulationLimits,
) -> Figure {
    let clearance = 1e6 * machine.spindle.backup_clearance_m;
    let stops = vec![(clearance, "backup bearing"), (-clearance, "backup bearing")];
    let time: Vec<Vec<f64>> = responses.iter().map(|(_, _, r)| r.samples.iter().map(|s| s.time_s).collect()).collect();
    let values = |of: &dyn Fn(&TimeSample) -> f64| -> Vec<Vec<f64>> {
        responses.iter().map(|(_, _, r)| r.samples.iter().map(of).collect()).collect()
    };
    let front = values(&|s| 1e6 * s.displacements_m[2]);
    let rear = values(&|s| 1e6 * s.displacements_m[4]);
    let current = values(&|s| s.currents_a[0]);
    let panels = [
        TimePanel {
            title: "Front bearing x",
            label: "x",
            unit: "µm",
            curves: name_curves(responses, &time, &front),
            limits: stops.clone(),
        },
        TimePanel {
            title: "Rear bearing x",
            label: "x",
            unit: "µm",
            curves: name_curves(responses, &time, &rear),
            limits: stops,
        },
        TimePanel {
            title: "Control current front x",
            label: "i",
            unit: "A",
            curves: name_curves(responses, &time, &current),
            limits: vec![(limits.current_a, "limit"), (-limits.current_a, "limit")],
        },
    ];
    time_responses(title, &panels)
}

/// Curves of the responses, each over its own time.
fn name_curves<'a>(
    responses: &[(&'a str, Role, &TimeResponse)],
    time: &'a [Vec<f64>],
    values: &'a [Vec<f64>],
) -> Vec<Curve<'a>> {
    responses.iter().zip(time).zip(values).map(|(((name, role, _), x), y)| Curve { name, x, y, role: *role }).collect()
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
        x_m: at.iter().map(|d| d[2 * k]).collect(),
        y_m: at.iter().map(|d| d[2 * k + 1]).collect(),
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
