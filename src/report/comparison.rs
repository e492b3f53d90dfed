//! Figures of a comparison as JSON: the statements of the paper's figure 9 as numbers, measured hammer records, and the
//! figures of a PID's certificate beside its limits.

use super::run_summary::verification_json;
use super::summary::{number, numbers};
use crate::identify::peaks::Resonance;
use crate::pid::certificate::TunedPid;
use crate::pid::certificate::{PeakSensitivity, PidCertificate, ZONE_B_DB};
use crate::pid::settings::TuneSettings;
use crate::pipeline::comparison::{LOW_HZ, Prediction};
use crate::pipeline::worst::WorstPrediction;
use crate::predict::dips::{Dip, dips};
use crate::predict::modes::{FLEXIBLE, LoopMode};
use crate::report::comparison_figures::NamedWorst;
use crate::report::run_figures::Measured;
use crate::report::worst::worst_sentence;
use serde_json::{Map, Value, json};

/// A resonance that dents the curve by less than this is not seen in a plot over four decades: 1 dB.
const SEEN: f64 = 1.122;
/// Rigid-body modes and what a controller makes of them lie in this band, Hz: up to half the first flexible mode.
const RIGID_BAND_HZ: (f64, f64) = (5.0, 500.0);
/// A dip within this factor of a natural frequency is that mode's.
const NEAR: f64 = 1.15;

fn mode_json(mode: &LoopMode) -> Value {
    json!({
        "frequency_hz": number(mode.frequency_hz),
        "damping_ratio": number(mode.damping_ratio),
    })
}

fn dip_json(dip: &Dip) -> Value {
    json!({
        "frequency_hz": number(dip.frequency_hz),
        "stiffness_n_per_m": number(dip.stiffness_n_per_m),
        "depth_db": number(20.0 * dip.prominence.log10()),
    })
}

/// The statements of figure 9 for one controller at one speed; `flexible_hz` are the natural frequencies of the free
/// rotor.
pub fn statements_json(prediction: &Prediction, flexible_hz: &[f64], top_speed_hz: f64) -> Value {
    let axes: Map<String, Value> = ["x", "y"]
        .into_iter()
        .zip(&prediction.stiffness)
        .map(|(axis, curve)| {
            let (f, k) = (&curve.frequency_hz, &curve.magnitude_n_per_m);
            (axis.to_owned(), curve_json(f, k, flexible_hz, top_speed_hz))
        })
        .collect();
    let flexible: Vec<Value> = prediction
        .modes
        .flexible
        .iter()
        .map(|m| m.as_ref().map_or(Value::Null, mode_json))
        .collect();
    let rigid: Vec<Value> = prediction.modes.rigid.iter().map(mode_json).collect();
    json!({
        "speed_rpm": number(prediction.speed_rpm),
        "tool_stiffness": axes,
        "flexible_modes": flexible,
        "rigid_body_modes": rigid,
    })
}

/// The same statements for a measured record, as far as it shows them; `resonances` are its lightly damped ones.
pub fn measured_json(
    measured: &Measured,
    resonances: &[Resonance],
    flexible_hz: &[f64],
    top_speed_hz: f64,
) -> Value {
    json!({
        "speed_rpm": number(measured.speed_rpm),
        "tool_stiffness": curve_json(&measured.frequency_hz, &measured.stiffness_n_per_m, flexible_hz, top_speed_hz),
        "lightly_damped_modes": resonances.iter().map(resonance_json).collect::<Vec<Value>>(),
    })
}

fn resonance_json(r: &Resonance) -> Value {
    json!({
        "frequency_hz": number(r.frequency_hz),
        "standard_deviation_hz": number(r.standard_deviation_hz),
        "damping_ratio": number(r.damping_ratio),
    })
}

fn curve_json(f: &[f64], k: &[f64], flexible_hz: &[f64], top_speed_hz: f64) -> Value {
    let lowest = f
        .iter()
        .zip(k)
        .min_by(|a, b| a.1.total_cmp(b.1))
        .map_or((f64::NAN, f64::NAN), |(f, k)| (*f, *k));
    let (first, last) = (
        f.first().copied().unwrap_or(f64::NAN),
        f.last().copied().unwrap_or(f64::NAN),
    );
    let found = dips(f, k, (first, last), SEEN);
    let rigid = found
        .iter()
        .filter(|d| (RIGID_BAND_HZ.0..RIGID_BAND_HZ.1).contains(&d.frequency_hz))
        .max_by(|a, b| a.prominence.total_cmp(&b.prominence));
    let flexible: Vec<Value> = flexible_hz
        .iter()
        .take(FLEXIBLE)
        .map(|natural| {
            let near = |d: &&Dip| {
                let ratio = d.frequency_hz / natural;
                ratio < NEAR && ratio > 1.0 / NEAR
            };
            let deepest = found
                .iter()
                .filter(near)
                .max_by(|a, b| a.prominence.total_cmp(&b.prominence));
            deepest.map_or(Value::Null, dip_json)
        })
        .collect();
    json!({
        "from_hz": number(first),
        "at_lowest_line_n_per_m": number(at(f, k, first)),
        "at_10_hz_n_per_m": number(at(f, k, LOW_HZ)),
        "at_max_speed_n_per_m": number(at(f, k, top_speed_hz)),
        "minimum_n_per_m": number(lowest.1),
        "minimum_frequency_hz": number(lowest.0),
        "flexible_mode_dips": flexible,
        "deepest_rigid_body_dip": rigid.map_or(Value::Null, dip_json),
    })
}

/// The curve at a frequency, linear between lines in both logarithms; not a number outside.
fn at(f: &[f64], k: &[f64], hz: f64) -> f64 {
    // A line that differs by rounding of its unit is the line.
    let same = |x: &f64| (x / hz - 1.0).abs() < 1e-9;
    if let Some((_, k)) = f.iter().zip(k).find(|(x, _)| same(x)) {
        return *k;
    }
    let after = f.partition_point(|x| *x < hz);
    let before = after.checked_sub(1);
    let line = |i: usize| f.get(i).zip(k.get(i));
    match (before.and_then(line), line(after)) {
        (Some((f0, k0)), Some((f1, k1))) => {
            let t = (hz / f0).ln() / (f1 / f0).ln();
            k0 * (k1 / k0).powf(t)
        }
        _ => f64::NAN,
    }
}

/// Ratios of the first controller's stiffness to that of another at the same speed.
pub fn ratio_json(first: &Prediction, other: &Prediction) -> Value {
    json!({
        "speed_rpm": number(first.speed_rpm),
        "at_10_hz": number(first.at_10_hz_n_per_m / other.at_10_hz_n_per_m),
        "at_max_speed": number(first.at_max_speed_n_per_m / other.at_max_speed_n_per_m),
        "minimum": number(first.minimum.0 / other.minimum.0),
    })
}

/// The statements of figure 9 as one table: a record per controller, speed and axis. Axes that agree share one.
pub fn statements_table(
    runs: &[&Prediction],
    worst: &[NamedWorst],
    flexible_hz: &[f64],
    top_speed_hz: f64,
) -> Vec<Value> {
    let mut rows = vec![];
    for run in runs {
        let same_speed = |w: &&WorstPrediction| w.speed_rpm == run.speed_rpm;
        let cases = worst.iter().find(|(_, name, _)| *name == run.name);
        let at_speed = cases.and_then(|(_, _, cases)| cases.iter().find(same_speed));
        let [x, y] = &run.stiffness;
        let alike = match (x.minimum(), y.minimum()) {
            (Some(a), Some(b)) => (a.0 / b.0 - 1.0).abs() < 1e-6,
            // An unstable loop has no curve on either axis.
            _ => !run.is_stable(),
        };
        for (axis, curve) in run
            .stiffness
            .iter()
            .enumerate()
            .take(if alike { 1 } else { 2 })
        {
            let (f, k) = (&curve.frequency_hz, &curve.magnitude_n_per_m);
            let figures = curve_json(f, k, flexible_hz, top_speed_hz);
            let peak = at_speed.and_then(|w| w.worst.compliance[axis].peak());
            let mut row = Map::new();
            row.insert("controller".to_owned(), run.name.as_str().into());
            row.insert("speed_rpm".to_owned(), number(run.speed_rpm));
            let name = if alike { "x and y" } else { ["x", "y"][axis] };
            row.insert("axis".to_owned(), name.into());
            copy_figures(&mut row, &figures);
            row.insert(
                "worst_n_per_m".to_owned(),
                number(peak.map_or(f64::NAN, |(_, e)| 1.0 / e.upper)),
            );
            for (n, mode) in run.modes.flexible.iter().enumerate() {
                row.insert(
                    format!("damping_mode_{}_percent", n + 1),
                    mode.map_or(Value::Null, |m| number(100.0 * m.damping_ratio)),
                );
            }
            row.insert("rigid_body_modes".to_owned(), rigid_words(run).into());
            if !run.is_stable() {
                row.insert(
                    "unstable_growth_rate_per_s".to_owned(),
                    number(run.growth_rate_per_s),
                );
            }
            rows.push(Value::Object(row));
        }
    }
    rows
}

/// A measured record as a row of the same table.
pub fn measured_row(measured: &Measured, flexible_hz: &[f64], top_speed_hz: f64) -> Value {
    let figures = curve_json(
        &measured.frequency_hz,
        &measured.stiffness_n_per_m,
        flexible_hz,
        top_speed_hz,
    );
    let mut row = Map::new();
    row.insert("controller".to_owned(), measured.name.as_str().into());
    row.insert("speed_rpm".to_owned(), number(measured.speed_rpm));
    copy_figures(&mut row, &figures);
    Value::Object(row)
}

fn copy_figures(row: &mut Map<String, Value>, figures: &Value) {
    for (to, from) in [
        ("at_10_hz_n_per_m", "at_10_hz_n_per_m"),
        ("at_top_speed_n_per_m", "at_max_speed_n_per_m"),
        ("smallest_n_per_m", "minimum_n_per_m"),
        ("where_hz", "minimum_frequency_hz"),
    ] {
        row.insert(to.to_owned(), figures[from].clone());
    }
}

fn rigid_words(prediction: &Prediction) -> String {
    let each: Vec<String> = prediction
        .modes
        .rigid
        .iter()
        .map(|m| {
            format!(
                "{:.0} Hz with {:.0} % damping",
                m.frequency_hz,
                100.0 * m.damping_ratio
            )
        })
        .collect();
    if each.is_empty() {
        "no oscillating one".to_owned()
    } else {
        each.join(" and ")
    }
}

/// The statements of figure 9 in sentences: the first controller against the others, at the first speed.
pub fn figure_9_words(runs: &[&Prediction], worst: &[NamedWorst]) -> Value {
    let mut words: Vec<String> = vec![];
    let Some(first) = runs.first() else {
        return words.into();
    };
    let at_first: Vec<&&Prediction> = runs
        .iter()
        .filter(|p| p.speed_rpm == first.speed_rpm)
        .collect();
    let list = |value: &dyn Fn(&Prediction) -> String| {
        let each: Vec<String> = at_first
            .iter()
            .map(|p| format!("{} {}", p.name, value(p)))
            .collect();
        each.join(", ")
    };
    words.push(format!(
        "Tool stiffness at {:.0} rpm in N/µm: at 10 Hz {}; at the frequency of the top speed {}; smallest {}.",
        first.speed_rpm,
        list(&|p| stiffness_words(p, p.at_10_hz_n_per_m)),
        list(&|p| stiffness_words(p, p.at_max_speed_n_per_m)),
        list(&|p| match p.is_stable() {
            true => format!("{:.2} at {:.0} Hz", 1e-6 * p.minimum.0, p.minimum.1),
            false => stiffness_words(p, f64::NAN),
        }),
    ));
    let damping = |p: &Prediction| {
        let each: Vec<String> = p
            .modes
            .flexible
            .iter()
            .map(|m| {
                m.map_or("–".to_owned(), |m| {
                    format!("{:.1}", 100.0 * m.damping_ratio)
                })
            })
            .collect();
        each.join("/")
    };
    words.push(format!(
        "Damping of the flexible modes in percent: {}.",
        list(&damping)
    ));
    words.push(format!("Rigid-body modes: {}.", list(&rigid_words)));
    words.extend(unstable_sentence(runs));
    words.extend(worst_sentence(worst));
    words.into()
}

fn stiffness_words(prediction: &Prediction, n_per_m: f64) -> String {
    match prediction.is_stable() {
        true => format!("{:.2}", 1e-6 * n_per_m),
        false => "none (unstable)".to_owned(),
    }
}

/// The loops that are unstable, speed by speed.
fn unstable_sentence(runs: &[&Prediction]) -> Option<String> {
    let bad = runs.iter().filter(|p| !p.is_stable());
    let each: Vec<String> = bad
        .map(|p| {
            let (growth, rpm) = (p.growth_rate_per_s, p.speed_rpm);
            format!("{} grows by {growth:.1} 1/s at {rpm:.0} rpm", p.name)
        })
        .collect();
    (!each.is_empty()).then(|| format!("Unstable: {}.", each.join(", ")))
}

/// The `pid` object: the tuned PID's figures beside their limits, which [`crate::pipeline::comparison::rival_settings`]
/// took from the delivered controller.
pub fn pid_json(pid: &TunedPid, settings: &TuneSettings) -> Value {
    let c = &pid.certificate;
    let mut object = certificate_json(c);
    if let Some(map) = object.as_object_mut() {
        map.insert("meets_limits".to_owned(), c.meets(settings).into());
        map.insert(
            "limits".to_owned(),
            json!({
                "sensitivity_db": number(ZONE_B_DB),
                "noise_current_a": number(settings.noise_current_a),
                "high_frequency_gain_a_per_m": number(settings.high_frequency_gain_a_per_m),
                "high_frequency_from_hz": number(c.high_frequency_hz),
                "high_frequency_norm": "largest singular value of the controller",
                "amplifier_limits": "the figures of the delivered controller",
                "mode_shift": number(settings.mode_shift),
            }),
        );
    }
    object
}

/// Figures of a PID on the full plant.
pub fn certificate_json(c: &PidCertificate) -> Value {
    let peak = |p: &PeakSensitivity| {
        json!({
            "attained_db": number(p.db),
            "not_above_db": number(p.upper_db),
            "frequency_hz": number(p.frequency_hz),
        })
    };
    let both = |p: &[PeakSensitivity; 2]| json!({ "front": peak(&p[0]), "rear": peak(&p[1]) });
    json!({
        "stable": c.is_stable(),
        "sensitivity": both(&c.sensitivity),
        "sensitivity_at_top_speed": both(&c.sensitivity_at_speed),
        "noise_current_a": number(c.noise_current_a),
        "high_frequency_gain_a_per_m": number(c.high_frequency_gain_a_per_m),
        "minimum_stiffness_n_per_m": number(c.stiffness_n_per_m),
        "minimum_stiffness_at_top_speed_n_per_m": number(c.stiffness_at_speed_n_per_m),
        "evaluations": c.evaluations,
        "certificates": {
            "nominal": verification_json(&c.nominal),
            "modes_lowered": verification_json(&c.lowered),
            "modes_raised": verification_json(&c.raised),
            "modes_alone_and_combined": {
                "shift": number(c.shifted.shift),
                "loops": c.shifted.loops,
                "worst_growth_rate_per_s": number(c.shifted.worst_growth_rate_per_s),
                "worst_frequency_factors": numbers(&c.shifted.worst_factors),
                "worst_speed_rpm": number(c.shifted.worst_speed_rpm),
            },
        },
    })
}
