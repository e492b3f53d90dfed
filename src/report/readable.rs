//! Keys and numbers of a summary as a reader wants them: words, four digits, a unit that fits the size.
//!
//! `minimum_n_per_m: 2.3e6` reads "minimum 2.3 N/µm". Values in `summary.json` stay as they are, in SI.

use serde_json::Value;

/// A figure in words.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub(crate) struct ReadableFigure {
    pub label: String,
    pub value: String,
}

/// A table of a list of records.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub(crate) struct Grid {
    pub label: String,
    /// Column headings with units.
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Grid {
    /// The table; none without rows.
    pub(super) fn of(label: &str, columns: &[&str], rows: Vec<Vec<String>>) -> Option<Self> {
        let columns = columns.iter().map(|c| (*c).to_owned()).collect();
        (!rows.is_empty()).then(|| Self { label: label.to_owned(), columns, rows })
    }
}

/// A unit as it ends a key, as it is printed, and the factor from one to the other.
struct Unit {
    suffix: &'static str,
    printed: &'static str,
    factor: f64,
}

const fn unit(suffix: &'static str, printed: &'static str, factor: f64) -> Unit {
    Unit { suffix, printed, factor }
}

/// Longer suffixes first: `_n_per_m` also ends in `_m`.
const UNITS: [Unit; 24] = [
    unit("_per_s", "1/s", 1.0),
    unit("_n_m_s_per_rad", "N·m·s/rad", 1.0),
    unit("_n_m_per_rad", "N·m/rad", 1.0),
    unit("_n_per_m", "N/µm", 1e-6),
    unit("_n_per_a", "N/A", 1.0),
    unit("_m_per_n", "µm/N", 1e6),
    unit("_a_per_m", "A/µm", 1e-6),
    unit("_kg_m2", "kg·m²", 1.0),
    unit("_rad_s", "rad/s", 1.0),
    unit("_percent", "%", 1.0),
    unit("_sigma", "σ", 1.0),
    unit("_bytes", "bytes", 1.0),
    unit("_rpm", "rpm", 1.0),
    unit("_deg", "°", 1.0),
    unit("_mm", "mm", 1.0),
    unit("_hz", "Hz", 1.0),
    unit("_db", "dB", 1.0),
    unit("_kg", "kg", 1.0),
    unit("_pa", "Pa", 1.0),
    unit("_m", "µm", 1e6),
    unit("_s", "µs", 1e6),
    unit("_n", "N", 1.0),
    unit("_a", "A", 1.0),
    unit("_v", "V", 1.0),
];

/// Unlike delays, in the unit of which other times are printed.
static SETTLING: Unit = unit("_s", "ms", 1e3);

fn split(key: &str) -> (String, Option<&'static Unit>) {
    if let Some(name) = key.strip_suffix("_s").filter(|name| name.ends_with("settling")) {
        return (words(name), Some(&SETTLING));
    }
    let unit = UNITS.iter().find(|u| key.len() > u.suffix.len() && key.ends_with(u.suffix));
    let name = unit.map_or(key, |u| key.strip_suffix(u.suffix).unwrap_or(key));
    (words(name), unit)
}

/// A key in words, with the symbols engineers use.
pub(crate) fn words(key: &str) -> String {
    match key {
        "nelder_mead" => return "by the search of Nelder and Mead".to_owned(),
        "determined_combinations" => return "combinations of moduli that the measurement determines".to_owned(),
        _ => {}
    }
    let parts: Vec<&str> = key
        .split('_')
        .map(|w| match w {
            "mu" => "µ",
            "pid" => "PID",
            "gamma" => "γ",
            "iso" => "ISO",
            "mac" => "MAC",
            "frf" => "FRF",
            w => w,
        })
        .collect();
    parts.join(" ")
}

/// A number with four significant digits, in plain form between 10⁻⁴ and 10⁶.
pub(crate) fn four_digits(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !x.is_finite() {
        return "–".to_owned();
    }
    let size = x.abs().log10().floor() as i32;
    if x.fract() == 0.0 && x.abs() < 1e6 {
        return format!("{x}");
    }
    if !(-4..6).contains(&size) {
        return format!("{x:.3e}");
    }
    let text = format!("{x:.*}", (3 - size).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A number, or a dash where there is none.
pub(super) fn show_known(value: Option<f64>, shown: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), shown)
}

fn scale_to_unit(x: f64, unit: Option<&Unit>) -> (f64, &'static str) {
    let Some(u) = unit else { return (x, "") };
    let y = x * u.factor;
    // Lengths and times stand in micro units unless they are large.
    match u.printed {
        "µm" if y.abs() >= 1e3 => (x * 1e3, "mm"),
        "µs" if y.abs() >= 1e6 => (x, "s"),
        "µs" if y.abs() >= 1e3 => (x * 1e3, "ms"),
        printed => (y, printed),
    }
}

fn with_unit(x: f64, unit: Option<&Unit>) -> String {
    let (y, printed) = scale_to_unit(x, unit);
    let gap = if printed.is_empty() || printed == "°" { "" } else { " " };
    format!("{}{gap}{printed}", four_digits(y))
}

/// A number as text with the unit that its name ends with.
pub(crate) fn figure(name: &str, value: f64) -> String {
    with_unit(value, split(name).1)
}

/// A value under its key as text.
fn text(key: &str, value: &Value) -> String {
    let (_, unit) = split(key);
    plain(value, unit)
}

fn plain(value: &Value, unit: Option<&Unit>) -> String {
    match value {
        Value::Null => "–".to_owned(),
        Value::Bool(true) => "yes".to_owned(),
        Value::Bool(false) => "no".to_owned(),
        Value::Number(n) => n.as_f64().map_or_else(|| n.to_string(), |x| with_unit(x, unit)),
        Value::String(s) => s.clone(),
        Value::Array(items) => items.iter().map(|i| plain(i, unit)).collect::<Vec<_>>().join(", "),
        Value::Object(map) => {
            map.iter().map(|(k, v)| format!("{} {}", split(k).0, text(k, v))).collect::<Vec<_>>().join(", ")
        }
    }
}

/// Everything below a value as rows and grids, in the order of the file. Keys in `skip` are left out.
pub(crate) fn flatten_value(value: &Value, skip: &[&str]) -> (Vec<ReadableFigure>, Vec<Grid>) {
    let (mut rows, mut grids) = (Vec::new(), Vec::new());
    walk(("", None), "", value, skip, &mut rows, &mut grids);
    (rows, grids)
}

fn walk(
    (label, inherited): (&str, Option<&'static Unit>),
    key: &str,
    value: &Value,
    skip: &[&str],
    rows: &mut Vec<ReadableFigure>,
    grids: &mut Vec<Grid>,
) {
    let (own, unit) = split(key);
    // `antiresonances_hz: {front: [..]}`: the unit of the outer key serves the inner ones.
    let unit = unit.or(inherited);
    let label = match (label.is_empty(), own.is_empty()) {
        (true, _) => own,
        (false, true) => label.to_owned(),
        (false, false) => format!("{label}: {own}"),
    };
    match value {
        // A list under names (a factor a region) reads better as one line.
        Value::Object(map) if map.len() > 2 && map.values().all(Value::is_number) && inherited_only(map, unit) => {
            let cells = map.iter().map(|(k, v)| format!("{} {}", words(k), plain(v, unit)));
            let value = cells.collect::<Vec<_>>().join(", ");
            rows.push(ReadableFigure { label, value });
        }
        Value::Object(map) => {
            for (k, v) in map.iter().filter(|(k, _)| !skip.contains(&k.as_str())) {
                walk((&label, unit), k, v, skip, rows, grids);
            }
        }
        Value::Array(items) if !items.is_empty() && items.iter().all(Value::is_object) => {
            grids.push(grid(&label, items));
        }
        Value::Array(items) if items.is_empty() => rows.push(ReadableFigure { label, value: "none".to_owned() }),
        scalar => rows.push(ReadableFigure { label, value: plain(scalar, unit) }),
    }
}

/// True when no key below has a unit of its own, and none is a word of several parts: names, not quantities.
fn inherited_only(map: &serde_json::Map<String, Value>, unit: Option<&Unit>) -> bool {
    unit.is_some() || map.keys().all(|k| split(k).1.is_none() && !k.contains('_'))
}

fn grid(label: &str, records: &[Value]) -> Grid {
    let mut keys: Vec<&String> = Vec::new();
    for key in records.iter().filter_map(Value::as_object).flat_map(|r| r.keys()) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let cell = |record: &Value, key: &str| record.get(key).map_or_else(String::new, |v| text(key, v));
    Grid {
        label: label.to_owned(),
        columns: keys.iter().map(|k| split(k).0).collect(),
        rows: records.iter().map(|r| keys.iter().map(|k| cell(r, k)).collect()).collect(),
    }
}
