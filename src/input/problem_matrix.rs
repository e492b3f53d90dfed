//! Entries of a real matrix in a problem file: rows, or a number or one list of numbers, as MATLAB's `jsonencode`
//! writes 1×1, 1×n and n×1. Such a list is a row or a column by the sizes that the other fields give.

use crate::linalg::Mat;
use serde_json::Value;

/// Most rows or columns of a matrix: the solvers take the third power of it in time.
const MOST_ROWS: usize = 1000;
/// Most entries of a list, and the largest whole number: frequencies, orders and sizes of blocks.
pub(super) const MOST_ENTRIES: usize = 10_000;

/// What is wrong with a value, and where in the field.
pub(super) struct Fault {
    pub path: String,
    pub message: String,
    pub hint: Option<&'static str>,
}

impl Fault {
    fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self { path: path.into(), message: message.into(), hint: None }
    }
}

/// What to write where a list of numbers does not tell a row from a column.
pub(super) const ROW_OR_COLUMN: &str = "write a row as [[1, 2]] and a column as [[1], [2]]";

/// Entries as the file holds them.
pub(super) enum Entries {
    /// A number, or one list of numbers.
    Listed(Vec<f64>),
    /// A list of rows.
    Rows(Mat<f64>),
}

impl Entries {
    pub(super) fn of(value: &Value, path: &str) -> Result<Self, Fault> {
        match value {
            Value::Number(_) => Ok(Self::Listed(vec![finite(value, path)?])),
            Value::Array(list) if list.first().is_some_and(|first| !first.is_array()) => numbers(list, path),
            Value::Array(list) => rows(list, path).map(Self::Rows),
            other => Err(Fault::new(path, format!("expected a matrix (list of rows), found {}", kind(other)))),
        }
    }

    /// The matrix of this size, if the entries can be one.
    pub(super) fn with_size(&self, rows: usize, cols: usize) -> Option<Mat<f64>> {
        match self {
            // An empty list carries no other size.
            Self::Rows(m) if m.nrows() == 0 && rows * cols == 0 => Some(Mat::zeros(rows, cols)),
            Self::Rows(m) => ((m.nrows(), m.ncols()) == (rows, cols)).then(|| m.clone()),
            Self::Listed(list) => {
                let is_vector = rows.min(cols) == 1 && rows.max(cols) == list.len();
                is_vector.then(|| Mat::from_fn(rows, cols, |i, j| list[i.max(j)]))
            }
        }
    }

    /// Sizes that the entries can have.
    pub(super) fn sizes(&self) -> Vec<[usize; 2]> {
        match self {
            Self::Rows(m) => vec![[m.nrows(), m.ncols()]],
            Self::Listed(list) if list.len() == 1 => vec![[1, 1]],
            Self::Listed(list) => vec![[1, list.len()], [list.len(), 1]],
        }
    }

    pub(super) fn words(&self) -> String {
        match self {
            Self::Rows(m) => format!("{} x {}", m.nrows(), m.ncols()),
            Self::Listed(list) if list.len() == 1 => "1 x 1".to_owned(),
            Self::Listed(list) => format!("a list of {} numbers", list.len()),
        }
    }
}

fn numbers(list: &[Value], path: &str) -> Result<Entries, Fault> {
    if let Some(i) = list.iter().position(Value::is_array) {
        let mut fault = Fault::new(format!("{path}[{i}]"), "expected a number as before it, found a list");
        fault.hint = Some(ROW_OR_COLUMN);
        return Err(fault);
    }
    if list.len() > MOST_ENTRIES {
        let rule = format!("has {} entries; at most {MOST_ENTRIES} are possible", list.len());
        return Err(Fault::new(path, rule));
    }
    let entry = |(i, v): (usize, &Value)| finite(v, &format!("{path}[{i}]"));
    list.iter().enumerate().map(entry).collect::<Result<_, _>>().map(Entries::Listed)
}

fn rows(list: &[Value], path: &str) -> Result<Mat<f64>, Fault> {
    let columns = list.first().and_then(Value::as_array).map_or(0, Vec::len);
    if list.len().max(columns) > MOST_ROWS {
        let rule = format!("is {} x {columns}; at most {MOST_ROWS} rows and columns are possible", list.len());
        return Err(Fault { hint: Some("reduce the order first"), ..Fault::new(path, rule) });
    }
    let mut entries: Vec<Vec<f64>> = Vec::with_capacity(list.len());
    for (i, row) in list.iter().enumerate() {
        let Value::Array(row) = row else {
            return Err(Fault {
                hint: Some("real matrices are row-major nested lists, also 1 x n and n x 1"),
                ..Fault::new(format!("{path}[{i}]"), format!("expected a row (list of numbers), found {}", kind(row)))
            });
        };
        let row: Vec<f64> =
            row.iter().enumerate().map(|(j, v)| finite(v, &format!("{path}[{i}][{j}]"))).collect::<Result<_, _>>()?;
        if let Some(first) = entries.first()
            && first.len() != row.len()
        {
            let message = format!("has {} entries, the first row has {}", row.len(), first.len());
            return Err(Fault::new(format!("{path}[{i}]"), message));
        }
        entries.push(row);
    }
    let cols = entries.first().map_or(0, Vec::len);
    Ok(Mat::from_fn(entries.len(), cols, |i, j| entries[i][j]))
}

pub(super) fn finite(value: &Value, path: &str) -> Result<f64, Fault> {
    match value.as_f64() {
        Some(x) if x.is_finite() => Ok(x),
        _ => Err(Fault::new(path, format!("expected a finite number, found {}", kind(value)))),
    }
}

pub(super) fn whole(value: &Value, path: &str) -> Result<usize, Fault> {
    match value.as_f64() {
        Some(x) if (0.0..=MOST_ENTRIES as f64).contains(&x) && x.fract() == 0.0 => Ok(x as usize),
        _ => {
            let rule = format!("expected a whole number >= 0 and at most {MOST_ENTRIES}, found {}", kind(value));
            Err(Fault::new(path, rule))
        }
    }
}

pub(super) fn kind(value: &Value) -> String {
    match value {
        Value::Null => "null".into(),
        Value::Bool(b) => b.to_string(),
        Value::Number(n) => n.to_string(),
        Value::String(s) => format!("the text {s:?}"),
        Value::Array(_) => "a list".into(),
        Value::Object(_) => "an object".into(),
    }
}
