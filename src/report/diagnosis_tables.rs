//! Tables of a diagnosis in the report: the gap, the parameters with their intervals, the hypotheses, the places, the
//! smallest sizes that the data could show.

use super::readable::{Grid, figure, four_digits, show_known, words};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// A topic of which the page quotes the sentence.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct QuotedTopic {
    pub(crate) sentence: Option<String>,
}

/// `diagnosis`, as far as the page shows it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct DiagnosisTopic {
    pub(crate) verdict: Option<String>,
    pub(crate) sentence: Option<String>,
    pub(crate) effects: Vec<EffectTopic>,
    tie: Vec<RivalTopic>,
    pub(crate) gap_before: Option<f64>,
    pub(crate) gap_after: Option<f64>,
    pub(crate) consequence: QuotedTopic,
    #[serde(flatten)]
    pub(crate) parts: GapsOfParts,
    /// What was held out, in words; of a rotor without magnets the number of frequencies.
    held_out: Value,
    localisation: Vec<PortTopic>,
    menu: Vec<ProposalTopic>,
    detectable: Vec<DetectableTopic>,
    ranking: Vec<RankedTopic>,
    correction: Option<CorrectionTopic>,
}

/// Gaps before and after of the records that were used and of those that were held out.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct GapsOfParts {
    gap_before_used: Option<f64>,
    gap_after_used: Option<f64>,
    gap_before_held_out: Option<f64>,
    pub(crate) gap_after_held_out: Option<f64>,
}

/// Where an effect sits.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct PlaceTopic {
    bearing: Option<String>,
    axis: Option<String>,
    from: Option<String>,
    to: Option<String>,
    position_m: Option<f64>,
    mode: Option<usize>,
    region: Option<String>,
}

impl PlaceTopic {
    /// The place in words; empty for an effect without one.
    fn words(&self) -> String {
        let position = self.position_m.map(|z| figure("position_m", z));
        let mode = self.mode.map(|m| m.to_string());
        let named = [&self.bearing, &self.axis, &self.from, &self.to, &self.region].map(Option::clone);
        let all = named.into_iter().chain([position, mode]).flatten();
        all.collect::<Vec<String>>().join(", ")
    }
}

/// An effect with its parameters and their intervals.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct EffectTopic {
    pub(crate) effect: String,
    #[serde(default, rename = "where")]
    place: PlaceTopic,
    #[serde(default)]
    parameters: Map<String, Value>,
    #[serde(default)]
    standard_deviations: BTreeMap<String, Option<f64>>,
    #[serde(default)]
    intervals_90: BTreeMap<String, [Option<f64>; 2]>,
}

/// A member of a tie: one effect stands for itself; several are a list.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum RivalTopic {
    Several { effects: Vec<EffectTopic> },
    One(Box<EffectTopic>),
}

/// What a free law at a place explains.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct PortTopic {
    port: String,
    chi2_after: Option<f64>,
    score_above_best: Option<f64>,
    words: String,
}

/// A measurement that would separate the members of a tie.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct ProposalTopic {
    measurement: String,
    separation_chi2: Option<f64>,
}

/// The smallest size of an effect that the data would show.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct DetectableTopic {
    effect: String,
    #[serde(rename = "where")]
    place: PlaceTopic,
    words: String,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct RankedTopic {
    effect: String,
    #[serde(rename = "where")]
    place: PlaceTopic,
    score_above_best: Option<f64>,
}

/// What stands in for a name when the verdict is unexplained.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct CorrectionTopic {
    port: String,
    #[serde(flatten)]
    gaps: GapsOfParts,
}

impl DiagnosisTopic {
    /// The effects whose parameters are shown: all members of a tie, or what was named.
    fn shown_effects(&self) -> Vec<&EffectTopic> {
        let members = self.tie.iter().flat_map(|rival| match rival {
            RivalTopic::One(effect) => std::slice::from_ref(effect.as_ref()),
            RivalTopic::Several { effects } => effects.as_slice(),
        });
        let tied: Vec<&EffectTopic> = members.collect();
        if tied.is_empty() { self.effects.iter().collect() } else { tied }
    }
}

/// Keys below `diagnosis` that the tables show.
pub(crate) const SHOWN: [&str; 17] = [
    "sentence",
    "effects",
    "tie",
    "held_out",
    "gap_before",
    "gap_after",
    "gap_before_used",
    "gap_after_used",
    "gap_before_held_out",
    "gap_after_held_out",
    "localisation",
    "ranking",
    "correction",
    "detectable",
    "worst_block",
    "verdict",
    "menu",
];

/// All tables that the summary has figures for.
pub(crate) fn tables(diagnosis: &DiagnosisTopic) -> Vec<Grid> {
    let parts = [
        gap(diagnosis),
        parameters(diagnosis),
        menu(diagnosis),
        ranking(diagnosis),
        places(diagnosis),
        detectable(diagnosis),
    ];
    parts.into_iter().flatten().collect()
}

fn gap(d: &DiagnosisTopic) -> Option<Grid> {
    let held = d.held_out.as_str().unwrap_or_default();
    let row = |name: String, before: Option<f64>, after: Option<f64>| -> Option<Vec<String>> {
        let (b, a) = (before?, after?);
        let shrunk = if b > 0.0 { format!("{:.0} %", 100.0 * (1.0 - a / b)) } else { "–".to_owned() };
        Some(vec![name, format!("{b:.2}"), format!("{a:.2}"), shrunk])
    };
    let mut rows = vec![
        row("used".to_owned(), d.parts.gap_before_used, d.parts.gap_after_used),
        row(format!("held out: {held}"), d.parts.gap_before_held_out, d.parts.gap_after_held_out),
        row("all records, fitted to all".to_owned(), d.gap_before, d.gap_after),
    ];
    if let Some(c) = &d.correction {
        let port = &c.port;
        rows.push(row(format!("used, with the correction at: {port}"), c.gaps.gap_before_used, c.gaps.gap_after_used));
        rows.push(row(
            format!("held out ({held}), with the correction at: {port}"),
            c.gaps.gap_before_held_out,
            c.gaps.gap_after_held_out,
        ));
    }
    Grid::of(
        "Gap between model and measurement, σ",
        &["data", "before", "after", "smaller by"],
        rows.into_iter().flatten().collect(),
    )
}

fn parameters(d: &DiagnosisTopic) -> Option<Grid> {
    let mut rows = vec![];
    for effect in d.shown_effects() {
        for (name, value) in &effect.parameters {
            let shown = |v: Option<f64>| show_known(v, |x| figure(name, x));
            let deviation = effect.standard_deviations.get(name).copied().flatten();
            let interval = effect.intervals_90.get(name);
            rows.push(vec![
                words(&effect.effect),
                effect.place.words(),
                words(name),
                shown(value.as_f64()),
                shown(deviation),
                interval.map_or_else(|| "–".to_owned(), |ends| ends.map(shown).join(" … ")),
            ]);
        }
    }
    Grid::of(
        "Parameters with their intervals",
        &["effect", "where", "parameter", "value", "standard deviation", "90 % interval"],
        rows,
    )
}

fn menu(d: &DiagnosisTopic) -> Option<Grid> {
    let row = d.menu.iter().map(|m| vec![m.measurement.clone(), show_known(m.separation_chi2, four_digits)]);
    Grid::of(
        "Measurements that would separate the members of the tie",
        &["measurement", "expected separation, χ²"],
        row.collect(),
    )
}

fn ranking(d: &DiagnosisTopic) -> Option<Grid> {
    let row =
        d.ranking.iter().map(|r| vec![words(&r.effect), r.place.words(), show_known(r.score_above_best, four_digits)]);
    Grid::of("Hypotheses, best first", &["effect", "where", "score above the best"], row.collect())
}

fn places(d: &DiagnosisTopic) -> Option<Grid> {
    let row = d.localisation.iter().map(|p| {
        vec![
            p.port.clone(),
            p.words.clone(),
            show_known(p.chi2_after, four_digits),
            show_known(p.score_above_best, four_digits),
        ]
    });
    Grid::of(
        "Places, best first, each with a free law",
        &["place", "the law recovered there", "χ² per degree of freedom that remains", "score above the best"],
        row.collect(),
    )
}

fn detectable(d: &DiagnosisTopic) -> Option<Grid> {
    let row = d.detectable.iter().map(|c| vec![words(&c.effect), c.place.words(), c.words.clone()]);
    Grid::of("Smallest sizes that these data would show", &["effect", "where", "smallest size"], row.collect())
}
