//! A comparison as topics of the summary: the statements of the paper's figure 9 as numbers, and measured hammer
//! records.

use super::summary::omit_absent;
use crate::controller::verification::growth_words;
use crate::identify::peaks::Resonance;
use crate::pipeline::comparison::{LOW_HZ, Prediction};
use crate::pipeline::worst::WorstPrediction;
use crate::predict::dips::{Dip, dips};
use crate::predict::modes::{FLEXIBLE, LoopMode};
use crate::report::comparison_figures::NamedWorst;
use crate::report::run_figures::Measured;
use crate::report::worst::worst_sentence;
use serde_json::{Value, json};

/// A resonance that dents the curve by less than this is not seen in a plot over four decades: 1 dB.
const SEEN: f64 = 1.122;
/// Rigid-body modes and what a controller makes of them lie from here on, in first frequencies of the curve.
const RIGID_FROM: f64 = 5.0;
/// They lie up to this part of the first flexible mode.
const RIGID_TO: f64 = 0.45;
/// A dip within this factor of a natural frequency is that mode's.
const NEAR: f64 = 1.15;

/// The statements of figure 9 for one controller at one speed: a record of `tool_plane.<controller>`. `flexible_hz` are
/// the natural frequencies of the free rotor.
pub(crate) fn tool_plane_topic(prediction: &Prediction, flexible_hz: &[f64], top_speed_hz: f64) -> Value {
    let [x, y] = prediction
        .stiffness
        .each_ref()
        .map(|curve| curve_topic(&curve.frequency_hz, &curve.magnitude_n_per_m, flexible_hz, top_speed_hz));
    let mode = |m: &LoopMode| json!({ "frequency_hz": m.frequency_hz, "damping_ratio": m.damping_ratio });
    let modes = &prediction.modes;
    json!({
        "speed_rpm": prediction.speed_rpm,
        "tool_stiffness": { "x": x, "y": y },
        "flexible_modes": modes.flexible.iter().map(|m| m.as_ref().map(mode)).collect::<Vec<_>>(),
        "rigid_body_modes": modes.rigid.iter().map(mode).collect::<Vec<_>>(),
    })
}

/// The same statements for a measured record, as far as it shows them: `tool_plane.measured_<record>`. The figures
/// leave out `lines_left_out` that do not tell the response.
pub(crate) fn measured_topic(
    measured: &Measured,
    lines_left_out: usize,
    resonances: &[Resonance],
    flexible_hz: &[f64],
    top_speed_hz: f64,
) -> Value {
    let mode = |r: &Resonance| {
        json!({
            "frequency_hz": r.frequency_hz,
            "standard_deviation_hz": r.standard_deviation_hz,
            "damping_ratio": r.damping_ratio,
        })
    };
    json!({
        "speed_rpm": measured.speed_rpm,
        "tool_stiffness": measured_curve_topic(measured, flexible_hz, top_speed_hz),
        "lines_left_out": lines_left_out,
        "modes": resonances.iter().map(mode).collect::<Vec<_>>(),
    })
}

/// The figures of a curve of the tool stiffness: `tool_stiffness`.
fn curve_topic(f: &[f64], k: &[f64], flexible_hz: &[f64], top_speed_hz: f64) -> Value {
    let lowest = f.iter().zip(k).min_by(|a, b| a.1.total_cmp(b.1)).map_or((f64::NAN, f64::NAN), |(f, k)| (*f, *k));
    let (first, last) = (f.first().copied().unwrap_or(f64::NAN), f.last().copied().unwrap_or(f64::NAN));
    let found = dips(f, k, first, last, SEEN);
    let bending_hz = flexible_hz.first().copied().unwrap_or(last);
    let rigid_hz = RIGID_FROM * first..RIGID_TO * bending_hz;
    let rigid = found
        .iter()
        .filter(|d| rigid_hz.contains(&d.frequency_hz))
        .max_by(|a, b| a.prominence.total_cmp(&b.prominence));
    let deepest = |natural: &f64| {
        let near = |d: &&Dip| {
            let ratio = d.frequency_hz / natural;
            ratio < NEAR && ratio > 1.0 / NEAR
        };
        let near = found.iter().filter(near);
        near.max_by(|a, b| a.prominence.total_cmp(&b.prominence))
    };
    let dip = |dip: &Dip| {
        json!({
            "frequency_hz": dip.frequency_hz,
            "stiffness_n_per_m": dip.stiffness_n_per_m,
            "depth_db": 20.0 * dip.prominence.log10(),
        })
    };
    json!({
        "from_hz": first,
        "at_lowest_line_n_per_m": at(f, k, first),
        "at_10_hz_n_per_m": at(f, k, LOW_HZ),
        "at_max_speed_n_per_m": at(f, k, top_speed_hz),
        "minimum_n_per_m": lowest.1,
        "minimum_frequency_hz": lowest.0,
        "flexible_mode_dips": flexible_hz.iter().take(FLEXIBLE).map(|hz| deepest(hz).map(dip)).collect::<Vec<_>>(),
        "deepest_rigid_body_dip": rigid.map(dip),
    })
}

/// The same of a measured record.
fn measured_curve_topic(measured: &Measured, flexible_hz: &[f64], top_speed_hz: f64) -> Value {
    curve_topic(&measured.frequency_hz, &measured.stiffness_n_per_m, flexible_hz, top_speed_hz)
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

/// Ratios of the first controller's stiffness to that of another at the same speed: `stiffness_ratio.<a>_over_<b>`.
pub(crate) fn ratio_topic(first: &Prediction, other: &Prediction) -> Value {
    json!({
        "speed_rpm": first.speed_rpm,
        "at_10_hz": first.at_10_hz_n_per_m / other.at_10_hz_n_per_m,
        "at_max_speed": first.at_max_speed_n_per_m / other.at_max_speed_n_per_m,
        "minimum": first.minimum.0 / other.minimum.0,
    })
}

/// The statements of figure 9 as one table: a record per controller, speed and axis. Axes that agree share one.
pub(crate) fn statements_table(
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
        let axes = if alike { 1 } else { 2 };
        for (axis, curve) in run.stiffness.iter().enumerate().take(axes) {
            let (f, k) = (&curve.frequency_hz, &curve.magnitude_n_per_m);
            let figures = curve_topic(f, k, flexible_hz, top_speed_hz);
            let peak = at_speed.and_then(|w| w.worst.compliance[axis].peak());
            let name = if alike { "x and y" } else { ["x", "y"][axis] };
            let mut row = statement_row(&run.name, run.speed_rpm, Some(name), &figures);
            row["worst_n_per_m"] = json!(peak.map(|(_, e)| 1.0 / e.upper));
            for (n, mode) in run.modes.flexible.iter().enumerate() {
                row[format!("damping_mode_{}_percent", n + 1)] = json!(mode.map(|m| 100.0 * m.damping_ratio));
            }
            row["rigid_body_modes"] = json!(rigid_words(run));
            if !run.is_stable() {
                row["unstable_growth_rate_per_s"] = json!(run.growth_rate_per_s);
            }
            rows.push(row);
        }
    }
    rows
}

/// A row of `statements`: a controller at a speed on an axis, or a measured record.
fn statement_row(name: &str, speed_rpm: f64, axis: Option<&str>, figures: &Value) -> Value {
    let row = json!({
        "controller": name,
        "speed_rpm": speed_rpm,
        "axis": axis,
        "at_10_hz_n_per_m": figures["at_10_hz_n_per_m"],
        "at_top_speed_n_per_m": figures["at_max_speed_n_per_m"],
        "smallest_n_per_m": figures["minimum_n_per_m"],
        "where_hz": figures["minimum_frequency_hz"],
    });
    omit_absent(row, &["axis"])
}

/// A measured record as a row of the same table.
pub(crate) fn measured_row(measured: &Measured, flexible_hz: &[f64], top_speed_hz: f64) -> Value {
    let figures = measured_curve_topic(measured, flexible_hz, top_speed_hz);
    statement_row(&measured.name, measured.speed_rpm, None, &figures)
}

fn rigid_words(prediction: &Prediction) -> String {
    let each: Vec<String> = prediction
        .modes
        .rigid
        .iter()
        .map(|m| format!("{:.0} Hz with {:.0} % damping", m.frequency_hz, 100.0 * m.damping_ratio))
        .collect();
    if each.is_empty() { "no oscillating one".to_owned() } else { each.join(" and ") }
}

/// The statements of figure 9 in sentences: the first controller against the others, at the first speed.
pub(crate) fn figure_9_words(runs: &[&Prediction], worst: &[NamedWorst]) -> Vec<String> {
    let mut words: Vec<String> = vec![];
    let Some(first) = runs.first() else {
        return words;
    };
    let at_first: Vec<&&Prediction> = runs.iter().filter(|p| p.speed_rpm == first.speed_rpm).collect();
    let list = |value: &dyn Fn(&Prediction) -> String| {
        let each: Vec<String> = at_first.iter().map(|p| format!("{} {}", p.name, value(p))).collect();
        each.join(", ")
    };
    words.push(format!(
        "Tool stiffness at {:.0} rpm in N/µm: at 10 Hz {}; at the frequency of the top speed {}; smallest {}.",
        first.speed_rpm,
        list(&|p| stiffness_words(p, p.at_10_hz_n_per_m)),
        list(&|p| stiffness_words(p, p.at_max_speed_n_per_m)),
        list(&|p| if p.is_stable() {
            format!("{:.2} at {:.0} Hz", 1e-6 * p.minimum.0, p.minimum.1)
        } else {
            stiffness_words(p, f64::NAN)
        }),
    ));
    let damping = |p: &Prediction| {
        let each: Vec<String> = p
            .modes
            .flexible
            .iter()
            .map(|m| m.map_or("–".to_owned(), |m| format!("{:.1}", 100.0 * m.damping_ratio)))
            .collect();
        each.join("/")
    };
    words.push(format!("Damping of the flexible modes in percent: {}.", list(&damping)));
    words.push(format!("Rigid-body modes: {}.", list(&rigid_words)));
    words.extend(unstable_sentence(runs));
    words.extend(worst_sentence(worst));
    words
}

fn stiffness_words(prediction: &Prediction, n_per_m: f64) -> String {
    if prediction.is_stable() { format!("{:.2}", 1e-6 * n_per_m) } else { "none (unstable)".to_owned() }
}

/// The loops that are unstable, speed by speed.
fn unstable_sentence(runs: &[&Prediction]) -> Option<String> {
    let bad = runs.iter().filter(|p| !p.is_stable());
    let each: Vec<String> =
        bad.map(|p| format!("{} {}", p.name, growth_words(p.growth_rate_per_s, p.speed_rpm))).collect();
    (!each.is_empty()).then(|| format!("Unstable: {}.", each.join(", ")))
}
