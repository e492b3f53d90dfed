//! The pictures that control engineers know: Bode diagrams of controller and loop gain, Nyquist diagram, closed-loop
//! poles, step at the tool, stiffness of sampled plants, Campbell diagram, unbalance response over speed.

use super::cascade::{GRAM_MILLIMETRE, cascade_figure};
use super::pictures::Picture;
use super::plot::figure::{Axis, Figure, Mark, Panel, Series};
use super::plot::loops::{bode, dynamic_stiffness, nyquist};
use super::plot::shaft::campbell;
use super::plot::whirl::whirl_shapes;
use super::plot::{Color, Curve, Dash, Look, Marker, Role};
use crate::linalg::c64;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::loop_curves::{DrawnPlants, LoopCurves, ModesAtSpeed, UnbalanceCurve};
use crate::predict::loop_gain::LoopGain;
use crate::predict::loop_shape::LoopShape;
use crate::predict::loop_sigma::LoopSigma;
use crate::predict::modes::LoopMode;
use crate::predict::time::TimeSettings;
use crate::predict::tool_step::{SETTLED, ToolStep};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// The pictures of a loop; `runs` are its predictions at rest and at top speed. Of a loop that is unstable at rest only
/// that of the free rotor.
pub(crate) fn loop_figures(curves: &LoopCurves, runs: [&Prediction; 2], top_rpm: f64) -> Vec<(Picture, Figure)> {
    let whirl = campbell("Bending modes of the free rotor over speed", &curves.whirl, &[1.0, 2.0]);
    let title = format!("Whirl modes of the free rotor at {top_rpm:.0} rpm");
    let mut figures = vec![(Picture::Campbell, whirl), (Picture::WhirlShapes, whirl_shapes(&title, &curves.orbits))];
    let Some(stable) = &curves.stable else {
        return figures;
    };
    figures.extend([
        (Picture::ControllerBode, controller_bode(&stable.shape)),
        (Picture::LoopGain, loop_gain(&stable.gain)),
        (Picture::LoopSigma, loop_sigma(&stable.sigma)),
        (Picture::Nyquist, loci(&stable.shape)),
        (Picture::Poles, poles(runs)),
        (Picture::LoopCampbell, loop_campbell(&stable.campbell, top_rpm)),
        (Picture::StiffnessSampled, sampled_stiffness(&stable.sampled_plants, runs[0])),
        (Picture::ToolStep, tool_step(&stable.step)),
        (Picture::UnbalanceSpeed, unbalance(&stable.unbalance, top_rpm)),
        (Picture::Cascade, cascade_figure(&stable.cascade)),
    ]);
    figures
}

fn controller_bode(shape: &LoopShape) -> Figure {
    let names = ["front to front", "rear to rear", "rear to front"];
    let roles = [Role::Mu, Role::Pid, Role::Other(0)];
    let x = shape.frequency_hz.as_slice();
    let curves = [0, 1, 2].map(|k| Curve { name: names[k], role: roles[k], x, y: shape.controller[k].as_slice() });
    bode("Controller with its hold", "|current / displacement|", "A/m", &curves, &[])
}

/// Largest singular values: what has no unit above, what has that of a controller below.
fn loop_sigma(sigma: &LoopSigma) -> Figure {
    let panel = |name: &str, unit: &str, curves: &[(&str, &[f64], Role)]| {
        let mut panel = Panel::new(name, Axis::log("Frequency", "Hz"), Axis::log("largest singular value", unit));
        let series = |(name, y, role): &(&str, &[f64], Role)| Series::curve(name, &sigma.frequency_hz, y, role.look());
        panel.series = curves.iter().map(series).collect();
        panel
    };
    let mut loops = panel(
        "Loop gain and sensitivities",
        "",
        &[
            ("L = G K", &sigma.loop_gain, Role::Other(2)),
            ("S", &sigma.sensitivity, Role::Other(0)),
            ("T = L S", &sigma.complementary, Role::Other(1)),
        ],
    );
    loops.level(1.0, "1");
    let effort = panel(
        "Controller and control effort",
        "A/m",
        &[("K", &sigma.controller, Role::Other(3)), ("K S", &sigma.effort, Role::Other(4))],
    );
    Figure::new(
        "Singular values of the loop at rest",
        "Largest singular values over the four control axes, each in the unit of its channels.",
        vec![loops, effort],
    )
    .with_columns(2)
}

fn loop_gain(gain: &LoopGain) -> Figure {
    let bearings = [(0, "front", Role::Mu), (2, "rear", Role::Pid)];
    let curves = bearings.map(|(k, name, role)| Curve { name, role, x: &gain.frequency_hz, y: &gain.channels[k] });
    let mut figure = bode("Loop gain at rest, one channel opened", "|L|", "", &curves, &[]);
    if let Some(magnitude) = figure.panels.first_mut() {
        magnitude.level(1.0, "1");
    }
    for panel in &mut figure.panels {
        let crossovers = bearings.map(|(channel, _, role)| (gain.margin(channel).crossover_hz, role.look().color));
        panel.marks.extend(crossovers.into_iter().filter(|(hz, _)| hz.is_finite()).map(|(value, color)| Mark {
            value,
            label: String::new(),
            color,
            dash: Dash::Dotted,
            legend: "highest crossover".to_owned(),
        }));
    }
    figure
}

fn loci(shape: &LoopShape) -> Figure {
    let names: Vec<String> = (1..=shape.loci.len()).map(|k| format!("locus {k}")).collect();
    let numbered = names.iter().zip(&shape.loci).enumerate();
    let loci: Vec<Curve<c64>> =
        numbered.map(|(k, (name, y))| Curve { name, role: Role::Other(k), x: &shape.frequency_hz, y }).collect();
    nyquist("Characteristic loci of the loop at rest", &loci)
}

/// The curve of the model in front of those of the sampled plants.
fn sampled_stiffness(sampled: &DrawnPlants, rest: &Prediction) -> Figure {
    let own = &rest.stiffness[0];
    let model = Curve { name: "model", role: Role::Mu, x: &own.frequency_hz, y: &own.magnitude_n_per_m };
    let behind = |y| Curve { name: "sampled plants", role: Role::Nominal, x: &sampled.frequency_hz, y };
    let curves = sampled.stiffness_n_per_m.iter().map(|y| behind(y.as_slice())).chain([model]).collect();
    let drawn = sampled.stiffness_n_per_m.len();
    let title = match sampled.unstable {
        0 => format!("Dynamic stiffness at rest of {drawn} sampled plants"),
        unstable => format!("Dynamic stiffness at rest of {drawn} sampled plants; {unstable} more are unstable"),
    };
    let mut figure = dynamic_stiffness(&title, &[("", curves)], &[]);
    figure.description =
        "Magnitude of force over displacement at the tool plane over frequency, for the model and for \
                          rotors whose natural frequencies are drawn from their ranges."
            .to_owned();
    let cloud = figure.panels.iter_mut().flat_map(|panel| panel.series.iter_mut().take(drawn));
    for (k, series) in cloud.enumerate() {
        series.look = Look::line(Color::Grey, Dash::Solid).with_width(0.6);
        series.in_legend = k == 0;
    }
    figure
}

/// `simulation.step`: displacement of the tool after a step of force.
pub(crate) fn tool_step_topic(step: &ToolStep) -> Value {
    json!({
        "final_m_per_n": step.final_m_per_n,
        "overshoot_percent": 100.0 * step.overshoot,
        "settling_s": step.settling_s,
        "settled_within_percent": 100.0 * SETTLED,
    })
}

/// Most points of the step that are drawn.
const STEP_POINTS: usize = 1500;

fn tool_step(step: &ToolStep) -> Figure {
    let axis = Axis::linear("Displacement of the tool for 1 N", "µm");
    let mut panel = Panel::new("", Axis::linear("Time", "ms"), axis);
    panel.height_px = 320;
    let settled = step.time_s.iter().position(|t| *t >= step.settling_s).unwrap_or(step.time_s.len());
    let shown = (2 * settled).clamp(STEP_POINTS.min(step.time_s.len()), step.time_s.len());
    let every = shown.div_ceil(STEP_POINTS);
    let points = step.time_s.iter().zip(&step.displacement_m_per_n).take(shown).step_by(every);
    let points = points.map(|(t, d)| (1e3 * t, 1e6 * d));
    panel.series.push(Series::of_points("displacement", points, Role::Mu.look()));
    let end = 1e6 * step.final_m_per_n;
    for (value, label) in [(end, "final"), ((1.0 + SETTLED) * end, ""), ((1.0 - SETTLED) * end, "")] {
        panel.level(value, label);
    }
    let settles = match step.settling_s {
        s if s.is_finite() => format!("settles to 2 % in {:.1} ms", 1e3 * s),
        _ => "does not settle to 2 % in the time computed".to_owned(),
    };
    Figure::new(
        &format!("Step of force at the tool: overshoot {:.0} %, {settles}", 100.0 * step.overshoot),
        "Displacement of the tool after a constant force begins to act on it at rest, linear loop.",
        vec![panel],
    )
}

const PLACES: [&str; 3] = ["tool", "front bearing", "rear bearing"];

/// `simulation.unbalance`: maxima of the unbalance response and their amplification factors (API 617).
pub(crate) fn unbalance_topic(curve: &UnbalanceCurve, top_rpm: f64) -> Value {
    let maxima = || curve.maxima.iter().flatten();
    let largest = maxima().map(|m| m.amplification).fold(0.0, f64::max);
    let to_rpm = curve.speed_rpm.last().copied().unwrap_or_default();
    let too_close = "neither well damped nor far enough from the speeds of operation";
    let judged = match maxima().filter(|m| !m.is_acceptable(top_rpm)).count() {
        0 => "every maximum is well damped or far enough away".to_owned(),
        1 => format!("one maximum is {too_close}"),
        several => format!("{several} maxima are {too_close}"),
    };
    let found = match maxima().next() {
        None => "the response has no maximum and so no amplification factor".to_owned(),
        Some(_) => format!("largest amplification factor {largest:.1}; {judged}"),
    };
    let sentence =
        format!("Unbalance at the tool, amplification factors of API 617 from rest to {to_rpm:.0} rpm: {found}.");
    let each = PLACES.into_iter().zip(&curve.maxima).flat_map(|(at, own)| own.iter().map(move |m| (at, m)));
    let each = each.map(|(at, maximum)| {
        json!({
            "at": at,
            "speed_rpm": maximum.speed_rpm,
            "amplification_factor": maximum.amplification,
            "half_power_from_rpm": maximum.half_power_rpm[0],
            "half_power_to_rpm": maximum.half_power_rpm[1],
            "separation_asked_percent": 100.0 * maximum.separation_asked(),
            "acceptable": maximum.is_acceptable(top_rpm),
        })
    });
    json!({ "sentence": sentence, "maxima": each.collect::<Vec<_>>() })
}

/// `simulation.bearings`: what the magnets can do (API 617, annex on magnetic bearings).
pub(crate) fn bearings_topic(capacity: &[(f64, f64); 2]) -> Value {
    let bus_voltage_v = TimeSettings::default().bus_voltage_v;
    let [front, rear] = capacity;
    let words = |(load, slew): &(f64, f64)| format!("{load:.0} N and {:.2} MN/s", 1e-6 * slew);
    let sentence = format!(
        "Static load capacity and force slew rate on a bus of {bus_voltage_v:.0} V: front {}, rear {}.",
        words(front),
        words(rear)
    );
    let topic = |(load, slew): &(f64, f64)| json!({ "static_load_capacity_n": load, "force_slew_rate_n_per_s": slew });
    json!({ "sentence": sentence, "bus_voltage_v": bus_voltage_v, "front": topic(front), "rear": topic(rear) })
}

fn poles(runs: [&Prediction; 2]) -> Figure {
    let mut panel = Panel::new("", Axis::log("Frequency |s|/2π", "Hz"), Axis::log("Damping ratio", ""));
    panel.height_px = 320;
    let looks = [Look::points(Color::Blue, Marker::Circle), Look::points(Color::Vermillion, Marker::Triangle)];
    for (run, look) in runs.into_iter().zip(looks).filter(|(r, _)| r.is_stable()) {
        let oscillating = run.poles_rad_s.iter().filter(|s| s.im > 0.0 && s.norm() > TAU);
        let points = oscillating.map(|s| (s.norm() / TAU, -s.re / s.norm()));
        panel.series.push(Series::of_points(&format!("{:.0} rpm", run.speed_rpm), points, look));
    }
    Figure::new(
        "Closed-loop poles",
        "Damping ratio of the oscillating poles of the sampled loop over their frequency, s = ln(z)/T.",
        vec![panel],
    )
}

/// Frequencies of the closed loop over speed with the line of the speed, and their logarithmic decrements.
fn loop_campbell(speeds: &[ModesAtSpeed], top_rpm: f64) -> Figure {
    let points = |of: fn(&LoopMode) -> f64| {
        speeds.iter().flat_map(move |at| at.modes.iter().map(move |mode| (at.speed_rpm, of(mode))))
    };
    let look = Look::points(Color::Blue, Marker::Circle);
    let speed = || Axis::linear("Speed", "rpm");
    let mut frequency = Panel::new("Frequency", speed(), Axis::log("Frequency", "Hz"));
    frequency.series.push(Series::of_points("mode", points(|mode| mode.frequency_hz), look));
    let turning = points(|mode| mode.frequency_hz).filter(|(rpm, _)| *rpm > 0.0);
    let once = turning.map(|(rpm, _)| (rpm, rpm / 60.0));
    frequency.series.push(Series::of_points("1 ×", once, Look::line(Color::Vermillion, Dash::Dashed)));
    let mut decrement = Panel::new("Logarithmic decrement", speed(), Axis::log("Logarithmic decrement", ""));
    decrement.series.push(Series::of_points("mode", points(LoopMode::logarithmic_decrement), look));
    for panel in [&mut frequency, &mut decrement] {
        panel.marks.push(Mark::top_speed(top_rpm));
    }
    Figure::new(
        "Modes of the closed loop over speed",
        "Poles of the sampled loop that show at the actuators or in a flexible mode, both whirls apart, full model.",
        vec![frequency, decrement],
    )
    .with_columns(2)
}

fn unbalance(curve: &UnbalanceCurve, top_rpm: f64) -> Figure {
    let mut panel =
        Panel::new("", Axis::linear("Speed", "rpm"), Axis::log("Displacement for 1 g mm at the tool", "µm"));
    panel.marks.push(Mark::top_speed(top_rpm));
    let looks = [(Color::Blue, Dash::Solid), (Color::Vermillion, Dash::Dashed), (Color::Green, Dash::DashDot)];
    for (k, (name, (color, dash))) in PLACES.into_iter().zip(looks).enumerate() {
        let size = curve.displacement.iter();
        let y: Vec<f64> = size.map(|d| d[k] * GRAM_MILLIMETRE * 1e6).collect();
        panel.series.push(Series::curve(name, &curve.speed_rpm, &y, Look::line(color, dash)));
    }
    Figure::new(
        "Unbalance response over speed",
        "Amplitude of the circular motion that an unbalance of 1 g mm at the tool plane causes, closed loop of the \
         full model.",
        vec![panel],
    )
}
