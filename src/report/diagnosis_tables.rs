//! Tables of a diagnosis in the report: the gap, the parameters with their intervals, the hypotheses, the places, the
//! smallest sizes that the data could show.

use super::diagnosis_summary::DiagnosisSummary;
use super::readable::{Grid, figure, four_digits, words};

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
pub(crate) fn tables(diagnosis: &DiagnosisSummary) -> Vec<Grid> {
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

fn grid(label: &str, columns: &[&str], rows: Vec<Vec<String>>) -> Option<Grid> {
    (!rows.is_empty()).then(|| Grid {
        label: label.to_owned(),
        columns: columns.iter().map(|c| (*c).to_owned()).collect(),
        rows,
    })
}

/// A number, or a dash where there is none.
fn show_known(value: Option<f64>, shown: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), shown)
}

fn gap(d: &DiagnosisSummary) -> Option<Grid> {
    let held = &d.held_out;
    let row = |name: String, before: Option<f64>, after: Option<f64>| -> Option<Vec<String>> {
        let (b, a) = (before?, after?);
        let shrunk = if b > 0.0 { format!("{:.0} %", 100.0 * (1.0 - a / b)) } else { "–".to_owned() };
        Some(vec![name, format!("{b:.2}"), format!("{a:.2}"), shrunk])
    };
    let mut rows = vec![
        row("used".to_owned(), d.parts.gap_before_used, d.parts.gap_after_used),
        row(format!("held out: {held}"), d.parts.gap_before_held_out, d.parts.gap_after_held_out),
        row("all records, fitted to all".to_owned(), d.all.gap_before, d.all.gap_after),
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
    grid(
        "Gap between model and measurement, σ",
        &["data", "before", "after", "smaller by"],
        rows.into_iter().flatten().collect(),
    )
}

fn parameters(d: &DiagnosisSummary) -> Option<Grid> {
    let mut rows = vec![];
    for effect in d.shown_effects() {
        for (name, value) in &effect.parameters.0 {
            let shown = |v: Option<f64>| show_known(v, |x| figure(name, x));
            let deviation = effect.standard_deviations.get(name).copied().flatten();
            let interval = effect.intervals_90.get(name);
            rows.push(vec![
                words(&effect.effect),
                effect.place.words(),
                words(name),
                shown(*value),
                shown(deviation),
                interval.map_or_else(|| "–".to_owned(), |ends| ends.map(shown).join(" … ")),
            ]);
        }
    }
    grid(
        "Parameters with their intervals",
        &["effect", "where", "parameter", "value", "standard deviation", "90 % interval"],
        rows,
    )
}

fn menu(d: &DiagnosisSummary) -> Option<Grid> {
    let row = d.menu.iter().map(|m| vec![m.measurement.clone(), show_known(m.separation_chi2, four_digits)]);
    grid(
        "Measurements that would separate the members of the tie",
        &["measurement", "expected separation, χ²"],
        row.collect(),
    )
}

fn ranking(d: &DiagnosisSummary) -> Option<Grid> {
    let row =
        d.ranking.iter().map(|r| vec![words(&r.effect), r.place.words(), show_known(r.score_above_best, four_digits)]);
    grid("Hypotheses, best first", &["effect", "where", "score above the best"], row.collect())
}

fn places(d: &DiagnosisSummary) -> Option<Grid> {
    let row = d.localisation.iter().map(|p| {
        vec![
            p.port.clone(),
            p.words.clone(),
            show_known(p.chi2_after, four_digits),
            show_known(p.score_above_best, four_digits),
        ]
    });
    grid(
        "Places, best first, each with a free law",
        &["place", "the law recovered there", "χ² per degree of freedom that remains", "score above the best"],
        row.collect(),
    )
}

fn detectable(d: &DiagnosisSummary) -> Option<Grid> {
    let row = d.detectable.iter().map(|c| vec![words(&c.effect), c.place.words(), c.words.clone()]);
    grid("Smallest sizes that these data would show", &["effect", "where", "smallest size"], row.collect())
}
