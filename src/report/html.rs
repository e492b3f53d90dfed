//! `report.html`: one self-contained page from the summary and the pictures of a run.
//!
//! Everything comes from `summary.json` and `plots/*.svg`, so that the page can be rebuilt from a results folder.
//! Verdict first, then plain words, key figures, a section a stage (absent stages are left out), certificates, all
//! figures.
//! No script, no font, no style from elsewhere; the own script shows values at the pointer and zooms, and the page is
//! whole without it.

use super::diagnosis_tables;
use super::frequency_table;
use super::html_stages::STAGES;
use super::readable::{self, Grid, Row, words};
use serde_json::Value;

const TEMPLATE: &str = include_str!("templates/report.html");
/// Values at the pointer and zoom, over the axes that every picture has as metadata.
const SCRIPT: &str = include_str!("templates/figures.js");

/// Why the page could not be made.
#[derive(Debug, thiserror::Error)]
pub enum HtmlError {
    /// The template failed on its values.
    #[error("report template: {0}")]
    Template(#[from] minijinja::Error),
}

#[derive(serde::Serialize)]
struct Section {
    anchor: String,
    title: String,
    lead: String,
    /// The tables a reader looks at first.
    tables: Vec<Grid>,
    rows: Vec<Row>,
    grids: Vec<Grid>,
    /// Whether rows and grids are folded away until asked for.
    long: bool,
    pictures: Vec<Picture>,
}

#[derive(serde::Serialize)]
struct Picture {
    stem: String,
    svg: String,
}

/// The page for a summary and its pictures (stem, SVG).
///
/// # Errors
/// [`HtmlError::Template`] if the template cannot be filled.
pub fn report(summary: &Value, pictures: &[(String, String)]) -> Result<String, HtmlError> {
    let mut left: Vec<&(String, String)> = pictures.iter().collect();
    let mut sections: Vec<Section> = Vec::new();
    for stage in &STAGES {
        let rank = |stem: &str| stage.stems.iter().position(|s| stem.starts_with(s));
        let (mut mine, others): (Vec<_>, Vec<_>) =
            left.into_iter().partition(|(stem, _)| rank(stem).is_some());
        mine.sort_by_key(|(stem, _)| rank(stem));
        left = others;
        let (tables, rows, grids) = figures(stage.key, summary.get(stage.key));
        if !(tables.is_empty() && rows.is_empty() && grids.is_empty() && mine.is_empty()) {
            sections.push(Section {
                tables,
                long: is_long(&rows, &grids),
                anchor: stage.key.to_owned(),
                title: stage.title.to_owned(),
                lead: stage.lead.to_owned(),
                rows,
                grids,
                pictures: inline(&mine),
            });
        }
    }
    sections.extend(further(summary, &left));
    let verdict = verdict(summary);
    let mut environment = minijinja::Environment::new();
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.add_template("report.html", TEMPLATE)?;
    let page = environment
        .get_template("report.html")?
        .render(minijinja::context! {
            title => title(summary),
            met => verdict.met,
            verdict => verdict.sentence,
            plain_words => plain_words(summary),
            tiles => tiles(summary),
            sections => sections,
            certificates => certificates(summary),
            script => SCRIPT,
        })?;
    // The template engine writes a slash as an entity, which only makes the source harder to read.
    Ok(page.replace("&#x2f;", "/"))
}

/// First tables, rows and grids of a stage.
fn figures(key: &str, stage: Option<&Value>) -> (Vec<Grid>, Vec<Row>, Vec<Grid>) {
    let Some(stage) = stage else {
        return (Vec::new(), Vec::new(), Vec::new());
    };
    let mut skip = vec!["certificates"];
    let tables = match key {
        "updating" => frequency_table::frequencies(stage).into_iter().collect(),
        "diagnosis" => diagnosis_tables::tables(stage),
        _ => Vec::new(),
    };
    if !tables.is_empty() {
        skip.extend(match key {
            "updating" => &frequency_table::SHOWN[..],
            _ => &diagnosis_tables::SHOWN[..],
        });
    }
    let (rows, grids) = readable::flatten(stage, &skip);
    (tables, rows, grids)
}

/// More than about half a page of figures.
fn is_long(rows: &[Row], grids: &[Grid]) -> bool {
    rows.len() + grids.iter().map(|g| g.rows.len()).sum::<usize>() > 14
}

fn inline(pictures: &[&(String, String)]) -> Vec<Picture> {
    pictures
        .iter()
        .map(|(stem, svg)| Picture {
            stem: stem.clone(),
            svg: svg.clone(),
        })
        .collect()
}

/// Keys of the summary that are shown elsewhere on the page.
const SHOWN: [&str; 6] = [
    "run",
    "spindle",
    "tool",
    "weights",
    "verdict",
    "plain_words",
];

/// Whatever no stage claims.
fn further(summary: &Value, pictures: &[&(String, String)]) -> Option<Section> {
    let staged = |key: &str| STAGES.iter().any(|s| s.key == key);
    let rest = summary.as_object().map(|map| {
        let kept = map
            .iter()
            .filter(|(k, _)| !staged(k) && !SHOWN.contains(&k.as_str()) && *k != "certificates");
        Value::Object(kept.map(|(k, v)| (k.clone(), v.clone())).collect())
    });
    let (rows, grids) = readable::flatten(&rest.unwrap_or(Value::Null), &["certificates"]);
    let rows: Vec<Row> = rows.into_iter().filter(|r| !r.label.is_empty()).collect();
    (!(rows.is_empty() && grids.is_empty() && pictures.is_empty())).then(|| Section {
        tables: Vec::new(),
        long: is_long(&rows, &grids),
        anchor: "further".to_owned(),
        title: "Further figures".to_owned(),
        lead: String::new(),
        rows,
        grids,
        pictures: inline(pictures),
    })
}

fn title(summary: &Value) -> String {
    let text = |key: &str| summary.get(key).and_then(Value::as_str).map(str::to_owned);
    match (text("spindle"), text("tool")) {
        (Some(spindle), Some(tool)) => format!("{spindle} with {tool}"),
        (Some(name), None) | (None, Some(name)) => name,
        (None, None) => text("run").unwrap_or_else(|| "muspin".to_owned()),
    }
}

/// The line at the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Whether every target is met; `None` when the run had none.
    pub met: Option<bool>,
    /// One sentence.
    pub sentence: String,
}

fn at<'a>(summary: &'a Value, path: &str) -> Option<&'a Value> {
    summary
        .pointer(&format!("/{}", path.replace('.', "/")))
        .filter(|v| !v.is_null())
}

fn figure(summary: &Value, path: &str) -> Option<f64> {
    at(summary, path).and_then(Value::as_f64)
}

fn word<'a>(summary: &'a Value, path: &str) -> Option<&'a str> {
    at(summary, path).and_then(Value::as_str)
}

/// μ of what is delivered: of the sampled controller if there is one.
fn final_mu(summary: &Value) -> Option<f64> {
    [
        "design.largest_mu",
        "design.mu_peak_discrete",
        "design.mu_peak_reduced",
        "design.mu_peak",
    ]
    .into_iter()
    .find_map(|path| figure(summary, path))
}

/// The verdict a run states (`verdict.met`, `verdict.sentence`), or the one its figures imply.
pub fn verdict(summary: &Value) -> Verdict {
    if let Some(sentence) = word(summary, "verdict.sentence") {
        return Verdict {
            met: at(summary, "verdict.met").and_then(Value::as_bool),
            sentence: sentence.to_owned(),
        };
    }
    let (mut met, mut parts) = (None, Vec::new());
    let mut note = |good: bool, text: String| {
        met = Some(met.unwrap_or(true) && good);
        parts.push(text);
    };
    if let Some(mu) = final_mu(summary) {
        let relation = if mu <= 1.0 { "≤" } else { ">" };
        note(
            mu <= 1.0,
            format!("µ = {mu:.3} {relation} 1 for the controller as delivered"),
        );
    }
    if let Some(stable) = at(summary, "design.stable").and_then(Value::as_bool) {
        let text = if stable {
            "stable over the whole speed range"
        } else {
            "not stable at every speed"
        };
        note(stable, text.to_owned());
    }
    match word(summary, "diagnosis.verdict") {
        Some("adequate") => note(true, "the model agrees with the measurement".to_owned()),
        Some("named") => note(true, format!("missing effect found: {}", effects(summary))),
        Some("tie") => note(
            true,
            "missing effects found that these data cannot tell apart".to_owned(),
        ),
        Some("unexplained") => note(
            false,
            "a discrepancy remains that no known effect explains".to_owned(),
        ),
        _ => {}
    }
    let sentence = parts.join("; ");
    Verdict {
        met,
        sentence: if sentence.is_empty() {
            "No targets in this run.".to_owned()
        } else {
            sentence
        },
    }
}

fn effects(summary: &Value) -> String {
    let list = at(summary, "diagnosis.effects").and_then(Value::as_array);
    let names = list
        .into_iter()
        .flatten()
        .filter_map(|e| e.get("effect").and_then(Value::as_str))
        .map(words);
    names.collect::<Vec<String>>().join(", ")
}

/// The run in sentences: those it wrote itself, and those its figures give.
fn plain_words(summary: &Value) -> Vec<String> {
    let own = at(summary, "plain_words");
    let listed = own.and_then(Value::as_array).into_iter().flatten();
    let mut sentences: Vec<String> = listed
        .chain(own)
        .filter_map(Value::as_str)
        .map(str::to_owned)
        .collect();
    let proven = [
        "design.speed_proof.sentence",
        "design.controller_stability",
        "tightening.sentence",
    ]
    .into_iter()
    .filter_map(|path| word(summary, path).map(str::to_owned));
    if !sentences.is_empty() {
        sentences.extend(proven);
        return sentences;
    }
    sentences.extend(proven);
    if let Some(order) = figure(summary, "design.controller_order")
        && let Some(mu) = final_mu(summary)
    {
        let meaning = if mu <= 1.0 {
            "every specification holds for every plant within the uncertainty"
        } else {
            "some plant within the uncertainty misses a specification"
        };
        sentences.push(format!(
            "The delivered controller has {order} states and µ = {mu:.3}: {meaning}."
        ));
    }
    let minimum = |who: &str| figure(summary, &format!("stiffness.{who}.minimum_n_per_m"));
    if let (Some(mu), Some(pid)) = (minimum("mu"), minimum("pid")) {
        let (softest, rival) = (
            readable::four_digits(mu * 1e-6),
            readable::four_digits(pid * 1e-6),
        );
        sentences.push(format!(
            "At its softest the tool plane has {softest} N/µm with the µ controller and {rival} N/µm with the PID, a \
             factor of {:.2}.",
            mu / pid
        ));
    }
    let zone = |who: &str| word(summary, &format!("sensitivity.{who}.zone"));
    if let (Some(mu), Some(pid)) = (zone("mu"), zone("pid")) {
        sentences.push(format!(
            "ISO 14839-3 zone {mu} with the µ controller, zone {pid} with the PID."
        ));
    }
    if let Some(sentence) = word(summary, "diagnosis.sentence") {
        sentences.push(sentence.to_owned());
    }
    if let (Some(before), Some(after)) = (
        figure(summary, "diagnosis.gap_before"),
        figure(summary, "diagnosis.gap_after"),
    ) {
        sentences.push(format!(
            "The gap between model and measurement goes from {before:.2} σ to {after:.2} σ."
        ));
    }
    sentences
}

/// The figures a reader asks for first.
fn tiles(summary: &Value) -> Vec<Row> {
    const WANTED: [(&str, &str); 8] = [
        (
            "largest µ from rest to 1.2 × top speed",
            "design.largest_mu",
        ),
        (
            "µ at rest, certified",
            "design.table_as_written.mu_peak_discrete",
        ),
        ("states of the controller", "design.controller_order"),
        ("softest point, µ", "stiffness.mu.minimum_n_per_m"),
        ("softest point, PID", "stiffness.pid.minimum_n_per_m"),
        ("ISO zone, µ", "sensitivity.mu.zone"),
        ("ISO zone, PID", "sensitivity.pid.zone"),
        (
            "gap on held-out data, after",
            "diagnosis.gap_after_held_out",
        ),
    ];
    let row = |(label, path): (&str, &str)| {
        let key = path.rsplit('.').next().unwrap_or(path);
        at(summary, path).map(|v| Row {
            label: label.to_owned(),
            value: readable::text(key, v),
        })
    };
    WANTED.into_iter().filter_map(row).collect()
}

/// `certificates` of the whole and of each stage.
fn certificates(summary: &Value) -> Vec<Row> {
    let mut all = Vec::new();
    let stages = summary.as_object().into_iter().flatten();
    let nested = stages.filter_map(|(key, stage)| Some((words(key), stage.get("certificates")?)));
    let own = summary.get("certificates").map(|c| (String::new(), c));
    for (stage, found) in own.into_iter().chain(nested) {
        let (rows, _) = readable::flatten(found, &[]);
        all.extend(rows.into_iter().map(|r| Row {
            label: if stage.is_empty() {
                r.label.clone()
            } else {
                format!("{stage}: {}", r.label)
            },
            value: r.value,
        }));
    }
    all
}
