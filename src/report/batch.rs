//! A batch as table, sentences and pictures: one row a tool or variant, made from what a run found, or read back from
//! the folder of a tool that was finished before.

use super::pictures::Picture;
use super::plot::machining::{ToolQuantity, tool_stiffness, tools};
use super::plot::{Curve, Figure, Role};
use super::tables::Table;
use super::worst::least_over_speed;
use crate::pipeline::batch::Finished;
use crate::pipeline::certificates::mu_words;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::worst::WorstPrediction;
use crate::predict::stiffness::stiffness_words;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// File of a row in the folder of its tool.
pub(crate) const ROW_FILE: &str = "row.json";

/// A figure; none where it is no number.
fn finite(figure: f64) -> Option<f64> {
    Some(figure).filter(|x| x.is_finite())
}

/// One line of the table.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BatchRow {
    /// Tool, with what a variant differs in; the name of its folder.
    pub tool: String,
    /// Hash of all that the row was computed from.
    pub inputs_sha256: String,
    /// Why there are no figures, when the run failed.
    pub failure: Option<String>,
    /// Figures.
    pub figures: Option<ToolFigures>,
    /// That the design is unstable, and why; its figures are left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instability: Option<String>,
}

/// Figures of a tool.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolFigures {
    /// Certified µ of the specification as written at rest.
    pub mu_as_specified: Option<f64>,
    /// The same with the gyroscopic split covered, of what the synthesis aimed at.
    pub mu_with_gyroscopic_cover: Option<f64>,
    /// Largest µ of the specification from rest to 1.2 times the top speed.
    pub largest_mu: Option<f64>,
    /// Order of the controller over both planes.
    pub order: usize,
    /// Stability is proven from rest to this speed, rpm.
    pub stable_to_rpm: f64,
    /// The design meets its targets, and its loop at rest is better than zone D.
    pub meets_specification: bool,
    /// What a missed specification lacks; absent where it is met.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub missed: Option<String>,
    /// Largest factor on the tool's specification; absent where it was not sought.
    pub largest_tool_tightening: Option<f64>,
    /// The µ controller.
    pub mu: LoopFigures,
    /// The tuned PID; absent where none was found.
    pub pid: Option<LoopFigures>,
}

/// Figures of one controller's loop at rest.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoopFigures {
    /// Smallest tool stiffness, N/m; absent for an unstable loop.
    pub minimum_stiffness_n_per_m: Option<f64>,
    /// The same in the worst case over uncertain modes at the speeds computed, N/m.
    pub worst_stiffness_n_per_m: Option<f64>,
    /// Largest sensitivity over the axes, dB.
    pub sensitivity_db: Option<f64>,
    /// Zone of ISO 14839-3.
    pub zone: String,
    /// Curve of the tool stiffness in x: frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// And values, N/m.
    pub stiffness_n_per_m: Vec<f64>,
}

impl BatchRow {
    /// The row of a finished tool.
    pub fn of(tool: &str, inputs_sha256: &str, found: &Finished) -> Self {
        let design = &found.run.design;
        let pid = found.run.rivals.as_ref();
        let pid = pid.and_then(|r| r.tuned.as_ref().ok());
        let instability = design.instability_words();
        let of_stable = |figure: f64| finite(figure).filter(|_| design.instability.is_none());
        Self {
            tool: tool.to_owned(),
            inputs_sha256: inputs_sha256.to_owned(),
            failure: None,
            figures: Some(ToolFigures {
                mu_as_specified: of_stable(design.delivery.rounded.specification.upper),
                mu_with_gyroscopic_cover: of_stable(design.delivery.rounded.covered.upper),
                largest_mu: finite(design.largest_mu()),
                order: 2 * design.delivery.rounded.order,
                stable_to_rpm: design.delivery.speed_proof.proven_to_rpm(),
                meets_specification: found.met,
                missed: design.specification_scale.as_ref().filter(|_| !found.met).map(|scale| {
                    let mu = mu_words(design.largest_mu());
                    format!("µ {mu}, {}", scale.words())
                }),
                largest_tool_tightening: found.tightening,
                mu: match &instability {
                    None => LoopFigures::of(&found.run.delivered[0], found.worst.first()),
                    Some(_) => LoopFigures { zone: "-".to_owned(), ..LoopFigures::default() },
                },
                pid: pid.map(|(_, [rest, _])| LoopFigures::of(rest, found.worst.get(1))),
            }),
            instability,
        }
    }

    /// The row of a tool whose run failed.
    pub(crate) fn failed_row(tool: &str, inputs_sha256: &str, failure: String) -> Self {
        Self {
            tool: tool.to_owned(),
            inputs_sha256: inputs_sha256.to_owned(),
            failure: Some(failure),
            ..Self::default()
        }
    }

    /// Why there is no stable design.
    fn reason(&self) -> Option<&String> {
        self.failure.as_ref().or(self.instability.as_ref())
    }

    /// True when the specification is met.
    pub(crate) fn met(&self) -> bool {
        self.figures.as_ref().is_some_and(|f| f.meets_specification)
    }

    /// µ controller, PID.
    fn loop_of(&self, k: usize) -> Option<&LoopFigures> {
        let figures = self.figures.as_ref()?;
        if k == 0 { Some(&figures.mu) } else { figures.pid.as_ref() }
    }

    /// A figure of a loop; NaN where there is none.
    fn figure(&self, k: usize, of: impl Fn(&LoopFigures) -> Option<f64>) -> f64 {
        self.loop_of(k).and_then(of).unwrap_or(f64::NAN)
    }

    fn minimum(&self, k: usize) -> f64 {
        self.figure(k, |l| l.minimum_stiffness_n_per_m)
    }

    fn worst(&self, k: usize) -> f64 {
        self.figure(k, |l| l.worst_stiffness_n_per_m)
    }

    fn zone(&self, k: usize) -> &str {
        self.loop_of(k).map_or("-", |l| &l.zone)
    }

    fn mu(&self) -> f64 {
        let figures = self.figures.as_ref();
        figures.and_then(|f| f.mu_as_specified).unwrap_or(f64::NAN)
    }

    /// A figure as text; empty where there is none.
    fn known(&self, of: fn(&ToolFigures) -> Option<f64>) -> String {
        self.figures.as_ref().and_then(of).map_or(String::new(), Table::number)
    }

    fn tightening(&self) -> Option<f64> {
        self.figures.as_ref()?.largest_tool_tightening
    }
}

impl LoopFigures {
    fn of(rest: &Prediction, worst: Option<&Vec<WorstPrediction>>) -> Self {
        let peaks = (0..4).map(|axis| rest.sensitivity.peak(axis).0);
        let db = 20.0 * peaks.fold(0.0, f64::max).log10();
        let worst = worst.and_then(|w| least_over_speed(w).ok());
        Self {
            minimum_stiffness_n_per_m: finite(rest.minimum.0),
            worst_stiffness_n_per_m: worst.and_then(|l| finite(l.n_per_m)),
            sensitivity_db: rest.is_stable().then_some(db).and_then(finite),
            zone: rest.zone_word().to_owned(),
            frequency_hz: rest.stiffness[0].frequency_hz.clone(),
            stiffness_n_per_m: rest.stiffness[0].magnitude_n_per_m.clone(),
        }
    }
}

/// How a batch ended, in a sentence.
pub fn verdict(rows: &[BatchRow]) -> String {
    let met = rows.iter().filter(|r| r.met()).count();
    let failed = rows.iter().filter(|r| r.failure.is_some()).count();
    let words = format!("{met} of {} tools meet the specification", rows.len());
    let words = if failed == 0 { words } else { format!("{words}; {failed} failed") };
    let unstable: Vec<&str> = rows.iter().filter(|r| r.instability.is_some()).map(|r| r.tool.as_str()).collect();
    let missed = rows.iter().filter(|r| r.instability.is_none()).filter_map(|r| {
        let why = r.figures.as_ref()?.missed.as_ref()?;
        Some(format!("{}: {why}", r.tool))
    });
    let words = std::iter::once(words).chain(missed).collect::<Vec<_>>().join("; ");
    if unstable.is_empty() { words } else { format!("unstable: the design for {}; {words}", unstable.join(", ")) }
}

/// The tools of a table for a title: their names, or how many there are.
pub(crate) fn tools_words(rows: &[BatchRow]) -> String {
    match rows {
        [] | [_] | [_, _] | [_, _, _] => rows.iter().map(|r| r.tool.as_str()).collect::<Vec<_>>().join(", "),
        _ => format!("{} tools", rows.len()),
    }
}

pub(crate) fn sentences(rows: &[BatchRow]) -> Vec<String> {
    let unstable = rows.iter().filter_map(|r| Some(format!("{}: {}", r.tool, r.instability.as_ref()?)));
    let mut words: Vec<String> = unstable.collect();
    let missed: Vec<String> = rows
        .iter()
        .filter(|r| r.figures.is_some() && r.instability.is_none() && !r.met())
        .map(|r| match r.tightening() {
            Some(0.0) => format!("{} (not met however large its limits at the tool are)", r.tool),
            Some(t) => format!("{} (met with limits at the tool {:.2} times as wide)", r.tool, 1.0 / t),
            None => r.tool.clone(),
        })
        .collect();
    if !missed.is_empty() {
        words.push(format!("Specification missed by {}.", missed.join(", ")));
    }
    words.extend(rows.iter().filter_map(|r| Some(format!("{} failed: {}", r.tool, r.failure.as_ref()?))));
    let range = |k: usize| {
        let all = rows.iter().map(|r| r.minimum(k)).filter(|x| x.is_finite());
        let (low, high) = all.fold((f64::INFINITY, 0.0f64), |(a, b), x| (a.min(x), b.max(x)));
        if low <= high { format!("{} to {}", stiffness_words(low), stiffness_words(high)) } else { "none".to_owned() }
    };
    let wins = rows
        .iter()
        .filter(|r| r.minimum(0).is_finite())
        .filter(|r| r.minimum(1).is_nan() || r.minimum(0) > r.minimum(1))
        .count();
    let own = format!("Smallest tool stiffness at rest: {} with the µ controllers", range(0));
    words.push(if has_pid(rows.iter()) {
        format!(
            "{own}, {} with PIDs tuned for it; the µ controller is the stiffer one for {wins} of {} tools.",
            range(1),
            rows.len()
        )
    } else {
        format!("{own}.")
    });
    words
}

/// `table`: one record a tool.
pub(crate) fn overview(rows: &[BatchRow]) -> Vec<Value> {
    let record = |r: &BatchRow| {
        let figures = r.figures.as_ref();
        json!({
            "tool": r.tool,
            "page": format!("{}/report.html", r.tool),
            "mu_as_specified": r.mu(),
            "largest_mu": figures.and_then(|f| f.largest_mu),
            "order": figures.map(|f| f.order),
            "minimum_stiffness_mu_n_per_m": r.minimum(0),
            "minimum_stiffness_pid_n_per_m": r.minimum(1),
            "worst_stiffness_mu_n_per_m": r.worst(0),
            "worst_stiffness_pid_n_per_m": r.worst(1),
            "zone_mu": r.zone(0),
            "zone_pid": r.zone(1),
            "stable_to_rpm": figures.map(|f| f.stable_to_rpm),
            "meets_specification": r.met(),
            "largest_tool_tightening": r.tightening(),
            "failure": r.reason(),
        })
    };
    rows.iter().map(record).collect()
}

/// The table as CSV.
pub fn table(rows: &[BatchRow]) -> Table {
    let columns: [(&str, fn(&BatchRow) -> String); 15] = [
        ("tool", |r| r.tool.clone()),
        ("mu_as_specified", |r| Table::number(r.mu())),
        ("mu_with_gyroscopic_cover", |r| r.known(|f| f.mu_with_gyroscopic_cover)),
        ("order", |r| r.figures.as_ref().map_or(String::new(), |f| f.order.to_string())),
        ("minimum_stiffness_mu_n_per_m", |r| Table::number(r.minimum(0))),
        ("minimum_stiffness_pid_n_per_m", |r| Table::number(r.minimum(1))),
        ("worst_stiffness_mu_n_per_m", |r| Table::number(r.worst(0))),
        ("worst_stiffness_pid_n_per_m", |r| Table::number(r.worst(1))),
        ("iso_zone", |r| r.zone(0).to_owned()),
        ("iso_zone_pid", |r| r.zone(1).to_owned()),
        ("stable_to_rpm", |r| r.known(|f| Some(f.stable_to_rpm))),
        ("meets_specification", |r| r.met().to_string()),
        ("largest_tool_tightening", |r| r.known(|f| f.largest_tool_tightening)),
        ("largest_mu", |r| r.known(|f| f.largest_mu)),
        ("failure", |r| r.reason().cloned().unwrap_or_default()),
    ];
    let mut table = Table::with_columns(&columns.map(|(name, _)| name));
    rows.iter().for_each(|row| table.push(columns.iter().map(|(_, value)| value(row)).collect()));
    table
}

/// True when a PID was tuned for some tool.
fn has_pid<'a>(mut rows: impl Iterator<Item = &'a BatchRow>) -> bool {
    rows.any(|r| r.loop_of(1).is_some())
}

/// Bars over the tools, and their stiffness curves.
pub fn figures(rows: &[BatchRow], top_speed_hz: f64) -> Vec<(Picture, Figure)> {
    let rows: Vec<&BatchRow> = rows.iter().filter(|r| r.figures.is_some()).collect();
    if rows.is_empty() {
        return vec![];
    }
    let names: Vec<String> = rows.iter().map(|r| r.tool.clone()).collect();
    let curves = |k: usize| -> Vec<Curve> {
        let each = rows.iter().enumerate();
        each.filter_map(|(n, r)| {
            let found = r.loop_of(k).filter(|found| !found.frequency_hz.is_empty())?;
            Some(Curve { name: &r.tool, role: Role::Other(n), x: &found.frequency_hz, y: &found.stiffness_n_per_m })
        })
        .collect()
    };
    let mut panels = vec![("µ controllers", curves(0))];
    if has_pid(rows.iter().copied()) {
        panels.push(("tuned PIDs", curves(1)));
    }
    vec![
        (Picture::Tools, tools("A design per tool", &names, &quantities(&rows))),
        (Picture::ToolsStiffness, tool_stiffness("Dynamic stiffness with each tool", &panels, top_speed_hz)),
    ]
}

/// The bars of the picture over the tools.
fn quantities(rows: &[&BatchRow]) -> Vec<ToolQuantity<'static>> {
    let column = |f: &dyn Fn(&BatchRow) -> f64| rows.iter().map(|r| f(r)).collect::<Vec<f64>>();
    let both = |f: &dyn Fn(&BatchRow, usize) -> f64| {
        let mut bars = vec![("µ controller", column(&|r| f(r, 0)))];
        if has_pid(rows.iter().copied()) {
            bars.push(("tuned PID", column(&|r| f(r, 1))));
        }
        bars
    };
    let own = |f: &dyn Fn(&BatchRow) -> f64| vec![("µ controller", column(f))];
    let order = |r: &BatchRow| r.figures.as_ref().map_or(f64::NAN, |f| f.order as f64);
    let zones = vec![(9.5, "A | B"), (12.0, "B | C"), (14.0, "C | D")];
    let worst = "The same in the worst case over uncertain modes, at rest, top speed and between";
    let quantity = |label, unit, references, bars| ToolQuantity { label, unit, references, bars };
    let mut quantities = vec![
        quantity("µ of the specification as written", "", vec![(1.0, "µ = 1")], own(&BatchRow::mu)),
        quantity("Smallest tool stiffness at rest", "N/µm", vec![], both(&|r, k| 1e-6 * r.minimum(k))),
        quantity(worst, "N/µm", vec![], both(&|r, k| 1e-6 * r.worst(k))),
        quantity(
            "Sensitivity peak and the zones of ISO 14839-3",
            "dB",
            zones,
            both(&|r, k| r.figure(k, |l| l.sensitivity_db)),
        ),
        quantity("Order of the controller", "", vec![], own(&order)),
    ];
    if rows.iter().any(|r| r.tightening().is_some()) {
        let bars = own(&|r| r.tightening().unwrap_or(f64::NAN));
        quantities.push(quantity("Largest factor on the tool's specification", "", vec![(1.0, "as written")], bars));
    }
    quantities
}

/// Rows of a table for a person: tool, verdict, µ, order, stiffness, zone, speed.
pub(crate) fn shown_rows(rows: &[BatchRow]) -> Vec<Vec<String>> {
    let stiffness = |x: f64| if x.is_finite() { stiffness_words(x) } else { "-".to_owned() };
    rows.iter()
        .map(|r| {
            let Some(figures) = &r.figures else {
                return vec![r.tool.clone(), "failed".to_owned()];
            };
            if r.instability.is_some() {
                return vec![r.tool.clone(), "unstable".to_owned()];
            }
            let verdict = if r.met() { "met" } else { "missed" };
            vec![
                r.tool.clone(),
                verdict.to_owned(),
                format!("{:.3}", r.mu()),
                figures.order.to_string(),
                stiffness(r.minimum(0)),
                stiffness(r.minimum(1)),
                r.zone(0).to_owned(),
                format!("{:.0}", figures.stable_to_rpm),
            ]
        })
        .collect()
}
