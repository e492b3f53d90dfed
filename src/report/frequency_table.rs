//! The table of Table 1 of the paper: every resonance and antiresonance measured, before and after updating.

use super::readable::{Grid, four_digits, show_known};
use serde::Deserialize;
use std::collections::BTreeMap;

/// `updating`, as far as the table shows it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct UpdatingTopic {
    errors_hz: PeakLists,
    errors_percent: PeakLists,
    model_hz: PeakLists,
    model_before_hz: PeakLists,
    measured_hz: PeakLists,
}

/// Keys below `updating` that the table shows.
pub(crate) const SHOWN: [&str; 5] = ["measured_hz", "model_before_hz", "model_hz", "errors_hz", "errors_percent"];

/// One figure per measured peak; antiresonances by the name of the FRF.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct PeakLists {
    resonances: Vec<Option<f64>>,
    antiresonances: BTreeMap<String, Vec<Option<f64>>>,
}

/// A list of figures of one kind of peak.
type Pick = fn(&PeakLists) -> &[Option<f64>];

/// Kinds of peaks: words and list.
const KINDS: [(&str, Pick); 3] = [
    ("resonance", |l| &l.resonances),
    ("antiresonance, front", |l| antiresonances(l, "front")),
    ("antiresonance, rear", |l| antiresonances(l, "rear")),
];

fn antiresonances<'a>(lists: &'a PeakLists, frf: &str) -> &'a [Option<f64>] {
    let found = lists.antiresonances.get(frf);
    found.map_or(&[], Vec::as_slice)
}

/// The table, or `None` if the summary has no measured and updated frequencies that belong together.
pub(crate) fn frequencies(updating: &UpdatingTopic) -> Option<Grid> {
    let cell = |values: &[Option<f64>], k: usize, shown: fn(f64) -> String| {
        show_known(values.get(k).copied().flatten(), shown)
    };
    let tenths: fn(f64) -> String = |x| format!("{x:.1}");
    let mut rows = Vec::new();
    for (name, pick) in KINDS {
        let (measured, after) = (pick(&updating.measured_hz), pick(&updating.model_hz));
        if measured.len() != after.len() {
            return None;
        }
        let before = pick(&updating.model_before_hz);
        let (error, percent) = (pick(&updating.errors_hz), pick(&updating.errors_percent));
        for k in 0..measured.len() {
            rows.push(vec![
                format!("{name} {}", k + 1),
                cell(measured, k, tenths),
                cell(before, k, tenths),
                cell(after, k, tenths),
                cell(error, k, four_digits),
                cell(percent, k, four_digits),
            ]);
        }
    }
    let columns = ["", "measured, Hz", "before, Hz", "after, Hz", "error, Hz", "error, %"];
    Grid::of("Frequencies before and after updating", &columns, rows)
}
