//! Tables of a diagnosis in the report, from its part of `summary.json`: the gap, the parameters with their intervals,
//! the hypotheses, the places, the smallest sizes that the data could show.

use super::readable::{Grid, four_digits, text, words};
use serde_json::Value;

/// Keys below `diagnosis` that the tables show.
pub const SHOWN: [&str; 17] = [
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
pub fn tables(diagnosis: &Value) -> Vec<Grid> {
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

fn items<'a>(value: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    value
        .get(key)
        .and_then(Value::as_array)
        .into_iter()
        .flatten()
}

fn string(value: &Value, key: &str) -> String {
    value
        .get(key)
        .and_then(Value::as_str)
        .unwrap_or_default()
        .to_owned()
}

fn figure(value: &Value, key: &str) -> String {
    value
        .get(key)
        .and_then(Value::as_f64)
        .map_or_else(|| "–".to_owned(), four_digits)
}

fn gap(d: &Value) -> Option<Grid> {
    let held = string(d, "held_out");
    let row = |name: String, of: &Value, before: &str, after: &str| -> Option<Vec<String>> {
        let b = of.get(before).and_then(Value::as_f64)?;
        let a = of.get(after).and_then(Value::as_f64)?;
        let shrunk = if b > 0.0 {
            format!("{:.0} %", 100.0 * (1.0 - a / b))
        } else {
            "–".to_owned()
        };
        Some(vec![name, format!("{b:.2}"), format!("{a:.2}"), shrunk])
    };
    let mut rows: Vec<Vec<String>> = [
        row("used".into(), d, "gap_before_used", "gap_after_used"),
        row(
            format!("held out: {held}"),
            d,
            "gap_before_held_out",
            "gap_after_held_out",
        ),
        row(
            "all records, fitted to all".into(),
            d,
            "gap_before",
            "gap_after",
        ),
    ]
    .into_iter()
    .flatten()
    .collect();
    if let Some(c) = d.get("correction") {
        let port = string(c, "port");
        rows.extend(row(
            format!("used, with the correction at: {port}"),
            c,
            "gap_before_used",
            "gap_after_used",
        ));
        rows.extend(row(
            format!("held out ({held}), with the correction at: {port}"),
            c,
            "gap_before_held_out",
            "gap_after_held_out",
        ));
    }
    grid(
        "Gap between model and measurement, σ",
        &["data", "before", "after", "smaller by"],
        rows,
    )
}

/// `{"bearing": "front"}` as words.
fn spot(value: &Value) -> String {
    let Some(map) = value.get("where").and_then(Value::as_object) else {
        return String::new();
    };
    let cells: Vec<String> = map.iter().map(|(k, v)| text(k, v)).collect();
    cells.join(", ")
}

fn parameters(d: &Value) -> Option<Grid> {
    let tied: Vec<&Value> = items(d, "tie")
        .flat_map(|rival| match rival.get("effects") {
            Some(Value::Array(several)) => several.iter().collect::<Vec<_>>(),
            _ => vec![rival],
        })
        .collect();
    let effects: Vec<&Value> = if tied.is_empty() {
        items(d, "effects").collect()
    } else {
        tied
    };
    let mut rows = vec![];
    for effect in effects {
        let pick = |part: &str, key: &str| effect.get(part).and_then(|p| p.get(key)).cloned();
        let names = effect.get("parameters").and_then(Value::as_object);
        for (name, value) in names.into_iter().flatten() {
            let shown = |v: Option<Value>| v.map_or_else(|| "–".to_owned(), |v| text(name, &v));
            let interval = match pick("intervals_90", name) {
                Some(Value::Array(ends)) => {
                    let ends: Vec<String> = ends.iter().map(|v| text(name, v)).collect();
                    ends.join(" … ")
                }
                _ => "–".to_owned(),
            };
            rows.push(vec![
                words(&string(effect, "effect")),
                spot(effect),
                words(name),
                text(name, value),
                shown(pick("standard_deviations", name)),
                interval,
            ]);
        }
    }
    grid(
        "Parameters with their intervals",
        &[
            "effect",
            "where",
            "parameter",
            "value",
            "standard deviation",
            "90 % interval",
        ],
        rows,
    )
}

fn menu(d: &Value) -> Option<Grid> {
    let rows = items(d, "menu")
        .map(|m| vec![string(m, "measurement"), figure(m, "separation_chi2")])
        .collect();
    grid(
        "Measurements that would separate the members of the tie",
        &["measurement", "expected separation, χ²"],
        rows,
    )
}

fn ranking(d: &Value) -> Option<Grid> {
    let rows = items(d, "ranking")
        .map(|r| {
            vec![
                words(&string(r, "effect")),
                spot(r),
                figure(r, "score_above_best"),
            ]
        })
        .collect();
    grid(
        "Hypotheses, best first",
        &["effect", "where", "score above the best"],
        rows,
    )
}

fn places(d: &Value) -> Option<Grid> {
    let rows = items(d, "localisation")
        .map(|p| {
            vec![
                string(p, "port"),
                string(p, "words"),
                figure(p, "chi2_after"),
                figure(p, "score_above_best"),
            ]
        })
        .collect();
    grid(
        "Places, best first, each with a free law",
        &[
            "place",
            "the law recovered there",
            "χ² per degree of freedom that remains",
            "score above the best",
        ],
        rows,
    )
}

fn detectable(d: &Value) -> Option<Grid> {
    let rows = items(d, "detectable")
        .map(|c| vec![words(&string(c, "effect")), spot(c), string(c, "words")])
        .collect();
    grid(
        "Smallest sizes that these data would show",
        &["effect", "where", "smallest size"],
        rows,
    )
}
