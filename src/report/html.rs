//! `report.html`: one self-contained page from the summary and the pictures of a run.
//!
//! Everything comes from `summary.json` and `plots/*.svg`, so that the page can be rebuilt from a results folder: the
//! summary is read back as far as tables and sentences show it.
//! Verdict first, then plain words, key figures, a section a stage (absent stages are left out), certificates, all
//! figures.
//! No script, no font, no style from elsewhere; the own script shows values at the pointer and zooms, and the page is
//! whole without it.

use super::content_policy::with_policy;
use super::diagnosis_tables;
use super::frequency_table;
use super::page_summary::{PageSummary, SensitivityTopic, StiffnessTopic, TopicError};
use super::pictures::PictureName;
use super::readable::{self, Grid, ReadableFigure, figure, words};
use super::sections::PageSection as Stage;
use crate::input::quote::without_direction_marks;
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
    /// A topic of the summary is not as muspin writes it.
    #[error(transparent)]
    Topic(#[from] TopicError),
}

/// What a section shows of the summary.
#[derive(Default, serde::Serialize)]
struct SectionFigures {
    /// The tables a reader looks at first.
    tables: Vec<Grid>,
    rows: Vec<ReadableFigure>,
    grids: Vec<Grid>,
}

#[derive(serde::Serialize)]
struct HtmlSection {
    anchor: String,
    title: String,
    lead: String,
    #[serde(flatten)]
    figures: SectionFigures,
    /// Whether rows and grids are folded away until asked for: more than about half a page.
    long: bool,
    groups: Vec<PictureGroup>,
}

impl HtmlSection {
    /// The section by its anchor, title and lead; none where there is nothing to show.
    fn of([anchor, title, lead]: [&str; 3], figures: SectionFigures, groups: Vec<PictureGroup>) -> Option<Self> {
        let SectionFigures { tables, rows, grids } = &figures;
        let is_empty = tables.is_empty() && rows.is_empty() && grids.is_empty();
        let has_pictures = groups.iter().any(|group| !group.pictures.is_empty());
        let long = rows.len() + grids.iter().map(|g| g.rows.len()).sum::<usize>() > 14;
        let [anchor, title, lead] = [anchor, title, lead].map(str::to_owned);
        (!is_empty || has_pictures).then_some(Self { anchor, title, lead, figures, long, groups })
    }
}

/// Pictures that are shown, or folded away until asked for.
#[derive(serde::Serialize)]
struct PictureGroup {
    folded: bool,
    pictures: Vec<Picture>,
}

#[derive(Clone, serde::Serialize)]
struct Picture {
    stem: String,
    svg: String,
}

/// The page for a summary and its pictures (stem, SVG).
///
/// # Errors
/// [`HtmlError::Topic`] for a summary that muspin did not write, [`HtmlError::Template`] if the template cannot be
/// filled.
pub fn report(summary: &Value, pictures: &[(String, String)]) -> Result<String, HtmlError> {
    let read = PageSummary::of(summary)?;
    let (own, others) = sort_pictures(pictures);
    let mut sections: Vec<HtmlSection> = Vec::new();
    for stage in Stage::ALL {
        let shown = own.iter().filter(|(name, _)| name.section() == stage);
        let (folded, open): (Vec<_>, Vec<_>) = shown.partition(|(name, picture)| is_folded(name, picture));
        let group = |folded: bool, list: Vec<&(PictureName, Picture)>| PictureGroup {
            folded,
            pictures: list.into_iter().map(|(_, picture)| picture.clone()).collect(),
        };
        let mut groups = vec![group(false, open), group(true, folded)];
        groups.retain(|group| !group.pictures.is_empty());
        let shown = figures(stage, summary.get(stage.name()), &read);
        sections.extend(HtmlSection::of([stage.name(), stage.title(), lead(stage, &read)], shown, groups));
    }
    sections.extend(further(summary, others));
    let verdict = read.verdict();
    let (standing, label) = read.label(verdict.met);
    let mut environment = minijinja::Environment::new();
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.add_template("report.html", TEMPLATE)?;
    let page = environment.get_template("report.html")?.render(minijinja::context! {
        title => read.title(),
        standing => standing,
        label => label,
        verdict => verdict.sentence,
        plain_words => read.sentences(),
        outcome => summary.get("outcome").and_then(|rows| readable::flatten_value(rows, &[]).1.pop()),
        // The table of the outcome has them beside their targets.
        tiles => if summary.get("outcome").is_some() { vec![] } else { tiles(&read) },
        sections => sections,
        certificates => certificates(summary),
        script => SCRIPT,
    })?;
    // The template engine writes a slash as an entity, which only makes the source harder to read.
    let page = page.replace("&#x2f;", "/");
    Ok(with_policy(&without_direction_marks(&page)))
}

/// A channel across the planes at rest, where a symmetric rotor has none.
fn is_folded(name: &PictureName, picture: &Picture) -> bool {
    name.is_cross_channel() && picture.svg.contains(", 0 rpm (")
}

/// What the reader of a stage looks at.
fn lead(stage: Stage, read: &PageSummary) -> &'static str {
    match stage {
        Stage::Design if read.is_unstable => "The loop is unstable: figures of a stable one are left out.",
        _ => stage.lead(),
    }
}

/// The pictures of muspin by name, in the order of the page, and those of another origin.
fn sort_pictures(pictures: &[(String, String)]) -> (Vec<(PictureName, Picture)>, Vec<Picture>) {
    let (mut own, mut others) = (Vec::new(), Vec::new());
    for (stem, svg) in pictures {
        let picture = Picture { stem: stem.clone(), svg: svg.clone() };
        match PictureName::of_stem(stem) {
            Some(name) => own.push((name, picture)),
            None => others.push(picture),
        }
    }
    own.sort_by(|a, b| a.0.cmp(&b.0));
    (own, others)
}

fn figures(stage: Stage, all: Option<&Value>, read: &PageSummary) -> SectionFigures {
    let Some(all) = all else {
        return SectionFigures::default();
    };
    let (tables, shown): (Vec<Grid>, &[&str]) = match stage {
        Stage::Updating => {
            let table = read.updating.as_ref().and_then(frequency_table::frequencies);
            (table.into_iter().collect(), &frequency_table::SHOWN)
        }
        Stage::Diagnosis => {
            let found = read.diagnosis.as_ref();
            let tables = found.map(diagnosis_tables::tables);
            (tables.unwrap_or_default(), &diagnosis_tables::SHOWN)
        }
        _ => (Vec::new(), &[]),
    };
    let mut skip = vec!["certificates"];
    if !tables.is_empty() {
        skip.extend(shown);
    }
    let (rows, grids) = readable::flatten_value(all, &skip);
    SectionFigures { tables, rows, grids }
}

/// Keys of the summary that are shown elsewhere on the page.
const SHOWN: [&str; 7] = ["run", "spindle", "tool", "weights", "verdict", "outcome", "plain_words"];

/// Whatever no stage claims.
fn further(summary: &Value, pictures: Vec<Picture>) -> Option<HtmlSection> {
    let staged = |key: &str| Stage::from_name(key).is_some();
    let rest = summary.as_object().map(|map| {
        let kept = map.iter().filter(|(k, _)| !staged(k) && !SHOWN.contains(&k.as_str()) && *k != "certificates");
        Value::Object(kept.map(|(k, v)| (k.clone(), v.clone())).collect())
    });
    let (rows, grids) = readable::flatten_value(&rest.unwrap_or(Value::Null), &["certificates"]);
    let rows: Vec<ReadableFigure> = rows.into_iter().filter(|r| !r.label.is_empty()).collect();
    let figures = SectionFigures { tables: vec![], rows, grids };
    HtmlSection::of(["further", "Further figures", ""], figures, vec![PictureGroup { folded: false, pictures }])
}

/// The figures a reader asks for first.
fn tiles(read: &PageSummary) -> Vec<ReadableFigure> {
    if read.is_unstable {
        return vec![];
    }
    let design = read.design.as_ref();
    let number = |x: Option<f64>| x.map(readable::four_digits);
    let softest = |s: &Option<StiffnessTopic>| {
        let least = s.as_ref().and_then(|s| s.minimum_n_per_m);
        least.map(|k| figure("minimum_n_per_m", k))
    };
    let zone = |s: &Option<SensitivityTopic>| s.as_ref().and_then(|s| s.zone.clone());
    let gap = read.diagnosis.as_ref().and_then(|d| d.parts.gap_after_held_out);
    let wanted = [
        ("largest µ from rest to 1.2 × top speed", number(design.and_then(|d| d.largest_mu))),
        ("µ at rest, certified", number(design.and_then(|d| d.table_as_written.mu_peak_discrete))),
        ("states of the controller", design.and_then(|d| d.controller_order).map(|n| n.to_string())),
        ("softest point, µ", softest(&read.stiffness.mu)),
        ("softest point, PID", softest(&read.stiffness.pid)),
        ("ISO zone, µ", zone(&read.sensitivity.mu)),
        ("ISO zone, PID", zone(&read.sensitivity.pid)),
        ("gap on held-out data, after", number(gap)),
    ];
    let row = |(label, value): (&str, Option<String>)| Some(ReadableFigure { label: label.to_owned(), value: value? });
    wanted.into_iter().filter_map(row).collect()
}

/// `certificates` of the whole and of each stage.
fn certificates(summary: &Value) -> Vec<ReadableFigure> {
    let mut all = Vec::new();
    let stages = summary.as_object().into_iter().flatten();
    let nested = stages.filter_map(|(key, stage)| Some((words(key), stage.get("certificates")?)));
    let own = summary.get("certificates").map(|c| (String::new(), c));
    for (stage, found) in own.into_iter().chain(nested) {
        let (rows, _) = readable::flatten_value(found, &[]);
        all.extend(rows.into_iter().map(|r| ReadableFigure {
            label: if stage.is_empty() { r.label.clone() } else { format!("{stage}: {}", r.label) },
            value: r.value,
        }));
    }
    all
}
