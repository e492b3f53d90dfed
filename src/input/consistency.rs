//! Values that are possible alone and do not go together: what a slip of unit, cable or column leaves behind. Each is
//! used as it stands and said.

use super::plausible::Warning;
use crate::augment::weights::Weights;
use crate::rotor::{Disc, PlanarModes, Rotor};
use crate::spindle::{Bearing, Side, Spindle};
use serde_yaml::Value;
use std::f64::consts::{PI, TAU};

/// ks over ki·bias/gap. A magnet linearised about its bias has 1 (the cosine of half the pole angle, 0.92, where the
/// force is taken along the axis); leakage and saturation take it to 0.7, and a gap or a current that is off by a
/// factor of two leaves this range.
const STIFFNESS_RATIO: [f64; 2] = [0.6, 1.6];
/// Largest force over ki·(largest current − bias). One where the magnet is linear; saturation takes it to a half, and
/// the quadratic force of one side alone to two.
const FORCE_RATIO: [f64; 2] = [0.3, 3.0];
/// Share of the overhang by which the tool plane may lie behind the tip: cutting edges act over some millimetres.
const BEHIND_TIP: f64 = 0.05;
/// Relative difference within which a delay is that of the hold alone: what is printed has four digits.
const SAME_DELAY: f64 = 1e-3;
/// Samples that no controller takes.
const MOST_DELAY: f64 = 6.0;
/// Surface speed, m/s, above which nothing is said of a top speed; spindles reach 100 to 200.
const FAST: f64 = 60.0;
/// Surface speed at which steel rotors burst, m/s.
const BURST: f64 = 300.0;
/// First bending frequency over the top speed in Hz from which a top speed looks too small: rotors are built stiff
/// enough, which takes 1.2 to 3, seldom 7, and rad/s for rpm is another factor of 9.5.
const STIFF: f64 = 8.0;
/// Polar over diametral moment of inertia below which a disc looks like a rod: 2 is a thin disc, 0.5 one with both
/// exchanged. At 0.55 a body is 2.8 times as long as its radius, which is an element of the shaft.
const ROD: f64 = 0.55;

/// What does not go together in a spindle.
pub(super) fn of_spindle(file: &str, spindle: &Spindle) -> Vec<Warning> {
    let mut found: Vec<String> =
        Side::ALL.into_iter().flat_map(|side| of_bearing(side, spindle.bearing(side))).collect();
    found.extend(front_planes(spindle));
    found.extend(delay(spindle));
    found.extend(top_speed(spindle));
    found.extend(discs("rotor.discs", &spindle.discs));
    warnings(file, found)
}

/// What does not go together in the tree of a tool file.
pub(super) fn of_tool(file: &str, tool: &Value) -> Vec<Warning> {
    let number = |value: &Value, key: &str| value.get(key).and_then(Value::as_f64);
    let elements = tool.get("elements").and_then(Value::as_sequence).into_iter().flatten();
    let length_m: f64 = elements.filter_map(|element| number(element, "length_m")).sum();
    let listed = tool.get("discs").and_then(Value::as_sequence).into_iter().flatten();
    let listed: Vec<Disc> = listed
        .map(|disc| Disc {
            position_m: number(disc, "position_m").unwrap_or_default(),
            mass_kg: number(disc, "mass_kg").unwrap_or_default(),
            polar_inertia_kg_m2: number(disc, "polar_inertia_kg_m2").unwrap_or_default(),
            diametral_inertia_kg_m2: number(disc, "diametral_inertia_kg_m2").unwrap_or_default(),
        })
        .collect();
    let plane_m = number(tool, "tool_plane_m").filter(|plane_m| *plane_m < length_m * (1.0 - BEHIND_TIP));
    let mut found = vec![];
    found.extend(plane_m.map(|plane_m| {
        format!(
            "tool_plane_m: {plane_m} lies inside the tool, which reaches to {length_m:.6}: cutting forces act \
             at the tip; \
             it counts from the nose face"
        )
    }));
    found.extend(discs("discs", &listed));
    warnings(file, found)
}

/// What does not go together in weights.
pub(super) fn of_weights(file: &str, weights: &Weights) -> Vec<Warning> {
    let places = [("tool", &weights.tool), ("front", &weights.front), ("rear", &weights.rear)];
    let mut found = vec![];
    for (place, limits) in places {
        let (hf, dc) = (limits.max_hf_load_n, limits.max_dc_load_n);
        if hf > dc {
            found.push(format!(
                "{place}.max_hf_load_n: {hf} is larger than max_dc_load_n ({dc}): loads fall with frequency, from the \
                 mean cutting force and weight to tooth passing; the two look exchanged"
            ));
        }
    }
    let (hf, dc) = (weights.tool.max_hf_displacement_m, weights.tool.max_dc_displacement_m);
    if hf > dc {
        found.push(format!(
            "tool.max_hf_displacement_m: {hf} is larger than max_dc_displacement_m ({dc}): slow displacement of a tool \
             can be corrected by the axes, fast one marks the workpiece; the two look exchanged"
        ));
    }
    if let (Some(corner_hz), Some(decay)) = (weights.integral_corner_hz, weights.least_decay_per_s)
        && decay > TAU * corner_hz
    {
        found.push(format!(
            "least_decay_per_s: {decay} leaves no room for the integral action below {corner_hz} Hz that \
             integral_corner_hz asks for: that is a pole of the controller next to none"
        ));
    }
    warnings(file, found)
}

fn warnings(file: &str, messages: Vec<String>) -> Vec<Warning> {
    messages.into_iter().map(|message| Warning { file: file.to_owned(), message }).collect()
}

fn is_outside([low, high]: [f64; 2], value: f64) -> bool {
    !(low..=high).contains(&value)
}

fn of_bearing(side: Side, b: &Bearing) -> Vec<String> {
    let name = side.name();
    let mut found = vec![];
    let linear = b.ki_n_per_a * b.bias_current_a / b.gap_m;
    // Zero is a part without negative stiffness, which is none of these magnets.
    if b.ks_n_per_m > 0.0 && is_outside(STIFFNESS_RATIO, b.ks_n_per_m / linear) {
        found.push(format!(
            "bearings.{name}.ks_n_per_m: {:e} is {:.2} times ki · bias / gap ({linear:.3e} N/m), the negative \
             stiffness \
             of a magnet linearised about its bias: look at ki_n_per_a, bias_current_a and gap_m (radial, not of the \
             diameter)",
            b.ks_n_per_m,
            b.ks_n_per_m / linear
        ));
    }
    let reach = b.ki_n_per_a * (b.max_current_a - b.bias_current_a);
    if is_outside(FORCE_RATIO, b.max_force_n / reach) {
        found.push(format!(
            "bearings.{name}.max_force_n: {} is {:.2} times ki · (largest current − bias) ({reach:.4} N), the force of \
             the current that is left beside the bias: look at its unit, at ki_n_per_a and at the currents",
            b.max_force_n,
            b.max_force_n / reach
        ));
    }
    found
}

/// Front sensors behind their actuators and further from them than the actuators from the nose: between planes that
/// far apart a bending mode has a node, and nobody puts sensors there when there is room in front.
fn front_planes(spindle: &Spindle) -> Option<String> {
    let (sensor, actuator) = (spindle.planes.front_sensor_m, spindle.planes.front_actuator_m);
    (sensor - actuator > actuator).then(|| {
        format!(
            "planes.front_sensor_m: {sensor} lies further behind front_actuator_m ({actuator}) than that behind \
             the nose \
             face: bending modes have a node between planes that far apart; the two look exchanged"
        )
    })
}

fn delay(spindle: &Spindle) -> Option<String> {
    let e = &spindle.electronics;
    let hold = 0.5 * e.sample_period_s();
    if e.delay_s > MOST_DELAY * e.sample_period_s() {
        let samples = e.delay_s / e.sample_period_s();
        return Some(format!(
            "electronics.delay_s: {:e} is {samples:.0} samples: computation, conversion and hold take 1.5, with slow \
             filters some more; milliseconds and microseconds look confused",
            e.delay_s
        ));
    }
    ((e.delay_s / hold - 1.0).abs() < SAME_DELAY).then(|| {
        format!(
            "electronics.delay_s: {:e} is half a sample, the delay of the hold alone: computation and conversion take \
             half a sample to a whole one more, usually 1.5 samples ({:e}) together",
            e.delay_s,
            3.0 * hold
        )
    })
}

/// A top speed at which the surface hardly moves, far below the first bending mode.
fn top_speed(spindle: &Spindle) -> Option<String> {
    let diameter_m = spindle.sections.iter().flat_map(|s| s.outer_diameter_m).fold(0.0, f64::max);
    let speed = |rpm: f64| PI * diameter_m * rpm / 60.0;
    let rpm = spindle.max_rpm;
    if speed(rpm) >= FAST {
        return None;
    }
    let rotor = Rotor::new(0.0, spindle.sections.clone(), &spindle.discs).ok()?;
    let first_hz = *PlanarModes::new(&rotor).ok()?.flexible_hz().first()?;
    let ratio = first_hz / (rpm / 60.0);
    let units = [("Hz", 60.0), ("rad/s", 60.0 / TAU)];
    let (unit, factor) = units.into_iter().find(|(_, factor)| speed(rpm * factor) < BURST)?;
    (ratio > STIFF).then(|| {
        format!(
            "speed.max_rpm: {rpm} moves the surface of the shaft by {:.1} m/s and lies {ratio:.0} times below \
             its first \
             bending mode ({first_hz:.0} Hz): {rpm} looks like {unit}: write {:.0}",
            speed(rpm),
            rpm * factor
        )
    })
}

fn discs(list: &str, discs: &[Disc]) -> Vec<String> {
    let rods = discs
        .iter()
        .enumerate()
        .filter(|(_, d)| d.polar_inertia_kg_m2 > 0.0 && d.polar_inertia_kg_m2 < ROD * d.diametral_inertia_kg_m2);
    let words = rods.map(|(k, d)| {
        format!(
            "{list}[{k}].polar_inertia_kg_m2: {:e} is {:.2} times diametral_inertia_kg_m2 ({:e}); a thin disc \
             has twice \
             as much: the two look exchanged",
            d.polar_inertia_kg_m2,
            d.polar_inertia_kg_m2 / d.diametral_inertia_kg_m2,
            d.diametral_inertia_kg_m2
        )
    });
    words.collect()
}
