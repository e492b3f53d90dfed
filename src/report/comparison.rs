//! A comparison as topics of the summary: the statements of the paper's figure 9 as numbers, and measured hammer
//! records.

use super::summary::{Named, finite};
use crate::controller::verification::growth_words;
use crate::identify::peaks::Resonance;
use crate::pipeline::comparison::{LOW_HZ, Prediction};
use crate::pipeline::worst::WorstPrediction;
use crate::predict::dips::{Dip, dips};
use crate::predict::modes::{FLEXIBLE, LoopMode};
use crate::report::comparison_figures::NamedWorst;
use crate::report::run_figures::Measured;
use crate::report::worst::worst_sentence;
use serde::Serialize;

/// A resonance that dents the curve by less than this is not seen in a plot over four decades: 1 dB.
const SEEN: f64 = 1.122;
/// Rigid-body modes and what a controller makes of them lie from here on, in first frequencies of the curve.
const RIGID_FROM: f64 = 5.0;
/// They lie up to this part of the first flexible mode.
const RIGID_TO: f64 = 0.45;
/// A dip within this factor of a natural frequency is that mode's.
const NEAR: f64 = 1.15;

#[derive(Clone, Debug, Serialize)]
struct ModeSummary {
    frequency_hz: Option<f64>,
    damping_ratio: Option<f64>,
}

/// A local minimum of the tool stiffness.
#[derive(Clone, Debug, Serialize)]
struct DipSummary {
    frequency_hz: Option<f64>,
    stiffness_n_per_m: Option<f64>,
    depth_db: Option<f64>,
}

/// A lightly damped resonance of a measured record.
#[derive(Clone, Debug, Serialize)]
struct ResonanceSummary {
    frequency_hz: Option<f64>,
    standard_deviation_hz: Option<f64>,
    damping_ratio: Option<f64>,
}

/// A curve of the tool stiffness in figures.
#[derive(Clone, Debug, Serialize)]
struct CurveSummary {
    from_hz: Option<f64>,
    at_lowest_line_n_per_m: Option<f64>,
    at_10_hz_n_per_m: Option<f64>,
    at_max_speed_n_per_m: Option<f64>,
    minimum_n_per_m: Option<f64>,
    minimum_frequency_hz: Option<f64>,
    flexible_mode_dips: Vec<Option<DipSummary>>,
    deepest_rigid_body_dip: Option<DipSummary>,
}

#[derive(Clone, Debug, Serialize)]
struct AxesSummary {
    x: CurveSummary,
    y: CurveSummary,
}

/// The statements of figure 9 for one controller at one speed: a record of `tool_plane.<controller>`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ToolPlaneSummary {
    speed_rpm: Option<f64>,
    tool_stiffness: AxesSummary,
    flexible_modes: Vec<Option<ModeSummary>>,
    rigid_body_modes: Vec<ModeSummary>,
}

/// The same statements for a measured record, as far as it shows them: `tool_plane.measured_<record>`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MeasuredSummary {
    speed_rpm: Option<f64>,
    tool_stiffness: CurveSummary,
    /// Lines that do not tell the response: the figures leave them out.
    lines_left_out: usize,
    modes: Vec<ResonanceSummary>,
}

/// Ratios of the first controller's stiffness to that of another at the same speed: `stiffness_ratio.<a>_over_<b>`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RatioSummary {
    speed_rpm: Option<f64>,
    at_10_hz: Option<f64>,
    at_max_speed: Option<f64>,
    minimum: Option<f64>,
}

/// A row of `statements`: a controller at a speed on an axis, or a measured record.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StatementRow {
    controller: String,
    speed_rpm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<&'static str>,
    at_10_hz_n_per_m: Option<f64>,
    at_top_speed_n_per_m: Option<f64>,
    smallest_n_per_m: Option<f64>,
    where_hz: Option<f64>,
    #[serde(flatten)]
    predicted: Option<PredictedColumns>,
}

/// What only a prediction has.
#[derive(Clone, Debug, Serialize)]
struct PredictedColumns {
    worst_n_per_m: Option<f64>,
    /// `damping_mode_<number>_percent`.
    #[serde(flatten)]
    damping_percent: Named<Option<f64>>,
    rigid_body_modes: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    unstable_growth_rate_per_s: Option<Option<f64>>,
}

impl From<&LoopMode> for ModeSummary {
    fn from(mode: &LoopMode) -> Self {
        Self { frequency_hz: finite(mode.frequency_hz), damping_ratio: finite(mode.damping_ratio) }
    }
}

impl From<&Dip> for DipSummary {
    fn from(dip: &Dip) -> Self {
        Self {
            frequency_hz: finite(dip.frequency_hz),
            stiffness_n_per_m: finite(dip.stiffness_n_per_m),
            depth_db: finite(20.0 * dip.prominence.log10()),
        }
    }
}

impl From<&Resonance> for ResonanceSummary {
    fn from(r: &Resonance) -> Self {
        Self {
            frequency_hz: finite(r.frequency_hz),
            standard_deviation_hz: finite(r.standard_deviation_hz),
            damping_ratio: finite(r.damping_ratio),
        }
    }
}

impl ToolPlaneSummary {
    /// `flexible_hz` are the natural frequencies of the free rotor.
    pub(crate) fn of(prediction: &Prediction, flexible_hz: &[f64], top_speed_hz: f64) -> Self {
        let curves = prediction.stiffness.each_ref().map(|curve| {
            let (f, k) = (&curve.frequency_hz, &curve.magnitude_n_per_m);
            CurveSummary::of(f, k, flexible_hz, top_speed_hz)
        });
        let [x, y] = curves;
        let modes = &prediction.modes;
        let flexible = modes.flexible.iter();
        Self {
            speed_rpm: finite(prediction.speed_rpm),
            tool_stiffness: AxesSummary { x, y },
            flexible_modes: flexible.map(|m| m.as_ref().map(ModeSummary::from)).collect(),
            rigid_body_modes: modes.rigid.iter().map(ModeSummary::from).collect(),
        }
    }
}

impl MeasuredSummary {
    pub(crate) fn of(
        measured: &Measured,
        lines_left_out: usize,
        resonances: &[Resonance],
        flexible_hz: &[f64],
        top_speed_hz: f64,
    ) -> Self {
        Self {
            speed_rpm: finite(measured.speed_rpm),
            tool_stiffness: CurveSummary::of(
                &measured.frequency_hz,
                &measured.stiffness_n_per_m,
                flexible_hz,
                top_speed_hz,
            ),
            lines_left_out,
            modes: resonances.iter().map(ResonanceSummary::from).collect(),
        }
    }
}

impl CurveSummary {
    fn of(f: &[f64], k: &[f64], flexible_hz: &[f64], top_speed_hz: f64) -> Self {
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
        let flexible = flexible_hz.iter().take(FLEXIBLE);
        Self {
            from_hz: finite(first),
            at_lowest_line_n_per_m: finite(at(f, k, first)),
            at_10_hz_n_per_m: finite(at(f, k, LOW_HZ)),
            at_max_speed_n_per_m: finite(at(f, k, top_speed_hz)),
            minimum_n_per_m: finite(lowest.1),
            minimum_frequency_hz: finite(lowest.0),
            flexible_mode_dips: flexible.map(|natural| deepest(natural).map(DipSummary::from)).collect(),
            deepest_rigid_body_dip: rigid.map(DipSummary::from),
        }
    }
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

impl RatioSummary {
    /// Of two controllers at one speed.
    pub(crate) fn of(first: &Prediction, other: &Prediction) -> Self {
        Self {
            speed_rpm: finite(first.speed_rpm),
            at_10_hz: finite(first.at_10_hz_n_per_m / other.at_10_hz_n_per_m),
            at_max_speed: finite(first.at_max_speed_n_per_m / other.at_max_speed_n_per_m),
            minimum: finite(first.minimum.0 / other.minimum.0),
        }
    }
}

/// The statements of figure 9 as one table: a record per controller, speed and axis. Axes that agree share one.
pub(crate) fn statements_table(
    runs: &[&Prediction],
    worst: &[NamedWorst],
    flexible_hz: &[f64],
    top_speed_hz: f64,
) -> Vec<StatementRow> {
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
            let figures = CurveSummary::of(f, k, flexible_hz, top_speed_hz);
            let peak = at_speed.and_then(|w| w.worst.compliance[axis].peak());
            let damping = run.modes.flexible.iter().enumerate().map(|(n, mode)| {
                let percent = mode.and_then(|m| finite(100.0 * m.damping_ratio));
                (format!("damping_mode_{}_percent", n + 1), percent)
            });
            let unstable = (!run.is_stable()).then(|| finite(run.growth_rate_per_s));
            let name = if alike { "x and y" } else { ["x", "y"][axis] };
            let mut row = StatementRow::of(&run.name, run.speed_rpm, Some(name), &figures);
            row.predicted = Some(PredictedColumns {
                worst_n_per_m: peak.and_then(|(_, e)| finite(1.0 / e.upper)),
                damping_percent: damping.collect(),
                rigid_body_modes: rigid_words(run),
                unstable_growth_rate_per_s: unstable,
            });
            rows.push(row);
        }
    }
    rows
}

impl StatementRow {
    fn of(name: &str, speed_rpm: f64, axis: Option<&'static str>, figures: &CurveSummary) -> Self {
        Self {
            controller: name.to_owned(),
            speed_rpm: finite(speed_rpm),
            axis,
            at_10_hz_n_per_m: figures.at_10_hz_n_per_m,
            at_top_speed_n_per_m: figures.at_max_speed_n_per_m,
            smallest_n_per_m: figures.minimum_n_per_m,
            where_hz: figures.minimum_frequency_hz,
            predicted: None,
        }
    }

    /// A measured record as a row of the same table.
    pub(crate) fn measured_row(measured: &Measured, flexible_hz: &[f64], top_speed_hz: f64) -> Self {
        let (f, k) = (&measured.frequency_hz, &measured.stiffness_n_per_m);
        let figures = CurveSummary::of(f, k, flexible_hz, top_speed_hz);
        Self::of(&measured.name, measured.speed_rpm, None, &figures)
    }
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
