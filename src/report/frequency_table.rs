//! The table of Table 1 of the paper from `updating`: every resonance and antiresonance measured, before and after
//! updating.

use super::readable::{Grid, four_digits};
use serde_json::Value;

/// Keys below `updating` that the table shows.
pub const SHOWN: [&str; 5] = [
    "measured_hz",
    "model_before_hz",
    "model_hz",
    "errors_hz",
    "errors_percent",
];

/// Groups of frequencies: words and place below each key.
const GROUPS: [(&str, &str); 3] = [
    ("resonance", "/resonances"),
    ("antiresonance, front", "/antiresonances/front"),
    ("antiresonance, rear", "/antiresonances/rear"),
];

/// The table, or `None` if the summary has no measured and updated frequencies that belong together.
pub fn frequencies(updating: &Value) -> Option<Grid> {
    let list = |key: &str, place: &str| -> Vec<Option<f64>> {
        let found = updating.get(key).and_then(|v| v.pointer(place));
        let items = found.and_then(Value::as_array).into_iter().flatten();
        items.map(Value::as_f64).collect()
    };
    let cell = |values: &[Option<f64>], k: usize, digits: usize| {
        let value = values.get(k).copied().flatten();
        value.map_or_else(|| "–".to_owned(), |x| format!("{x:.digits$}"))
    };
    let mut rows = Vec::new();
    for (name, place) in GROUPS {
        let (measured, after) = (list("measured_hz", place), list("model_hz", place));
        if measured.len() != after.len() {
            return None;
        }
        let (before, error) = (list("model_before_hz", place), list("errors_hz", place));
        let percent = list("errors_percent", place);
        for k in 0..measured.len() {
            let small = |values: &[Option<f64>]| {
                let value = values.get(k).copied().flatten();
                value.map_or_else(|| "–".to_owned(), four_digits)
            };
            rows.push(vec![
                format!("{name} {}", k + 1),
                cell(&measured, k, 1),
                cell(&before, k, 1),
                cell(&after, k, 1),
                small(&error),
                small(&percent),
            ]);
        }
    }
    let columns = [
        "",
        "measured, Hz",
        "before, Hz",
        "after, Hz",
        "error, Hz",
        "error, %",
    ];
    (!rows.is_empty()).then(|| Grid {
        label: "Frequencies before and after updating".to_owned(),
        columns: columns.map(str::to_owned).to_vec(),
        rows,
    })
}
