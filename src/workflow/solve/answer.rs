//! The answer of `muspin solve`: one JSON object, one field a line, in a fixed order.

use crate::linalg::{Mat, c64};
use crate::lti::{StateSpace, TimeBase};
use serde_json::{Map, Value, json};

/// JSON object under construction.
#[derive(Default)]
pub(crate) struct Answer {
    fields: Map<String, Value>,
    remarks: Vec<String>,
    notes: Vec<String>,
}

impl Answer {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Adds a field; a second one of the same name replaces the first.
    pub(crate) fn with(mut self, field: &str, value: impl Into<Value>) -> Self {
        self.fields.insert(field.to_string(), value.into());
        self
    }

    /// Adds a number that must be finite; infinity and NaN become `null`.
    pub(crate) fn with_number(self, field: &str, value: f64) -> Self {
        self.with(field, number(value))
    }

    pub(crate) fn with_matrix(self, field: &str, value: &Mat<f64>) -> Self {
        self.with(field, matrix(value))
    }

    /// Adds a sentence for the person who reads the answer on a terminal.
    pub(crate) fn with_remark(mut self, words: impl Into<String>) -> Self {
        self.remarks.push(words.into());
        self
    }

    /// What is to be said besides the numbers.
    pub(crate) fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Adds sentences on what the answer lacks, as its field `notes` too.
    pub(crate) fn with_notes(mut self, notes: Vec<String>) -> Self {
        if notes.is_empty() {
            return self;
        }
        self.notes.extend(notes);
        let all = self.notes.clone();
        self.with("notes", all)
    }

    /// What the answer lacks.
    pub(crate) fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The object as text, one field a line.
    pub(crate) fn text(&self) -> String {
        let mut text = String::from("{\n");
        for (k, (name, value)) in self.fields.iter().enumerate() {
            let comma = if k + 1 < self.fields.len() { "," } else { "" };
            text.push_str(&format!("{}: {value}{comma}\n", json!(name)));
        }
        text.push_str("}\n");
        text
    }

    /// The fields that are single numbers, as rows of a table.
    pub(crate) fn numbers(&self) -> Vec<Vec<String>> {
        let single = self.fields.iter().filter(|(_, value)| value.is_number());
        single.map(|(name, value)| vec![name.clone(), value.to_string()]).collect()
    }
}

impl From<Answer> for Value {
    fn from(answer: Answer) -> Self {
        Self::Object(answer.fields)
    }
}

/// A finite number, else `null`.
pub(super) fn number(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number)
}

/// A real matrix as a list of rows.
pub(super) fn matrix(m: &Mat<f64>) -> Value {
    rows(m.nrows(), m.ncols(), |i, j| m[(i, j)])
}

/// A complex matrix as `{"re": rows, "im": rows}`.
pub(super) fn complex_matrix(m: &Mat<c64>) -> Value {
    json!({
        "re": rows(m.nrows(), m.ncols(), |i, j| m[(i, j)].re),
        "im": rows(m.nrows(), m.ncols(), |i, j| m[(i, j)].im),
    })
}

/// A system as `{A, B, C, D}`; more fields can be added.
pub(super) fn system<T: TimeBase>(s: &StateSpace<T>) -> Answer {
    Answer::new().with_matrix("A", &s.a).with_matrix("B", &s.b).with_matrix("C", &s.c).with_matrix("D", &s.d)
}

fn rows(n: usize, m: usize, entry: impl Fn(usize, usize) -> f64) -> Value {
    Value::Array((0..n).map(|i| Value::Array((0..m).map(|j| number(entry(i, j))).collect())).collect())
}
