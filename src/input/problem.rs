//! The problem file of `muspin solve`: JSON fields in `data` (or at the top level), read with shape checks. Real
//! matrices are lists of rows, vectors also plain lists; complex ones `{"re": rows, "im": rows}`. Every error names
//! file and field.

use super::error::InputError;
use super::file as files;
use super::json;
use super::problem_matrix::{Entries, Fault, MOST_ENTRIES, finite, kind, whole};
use super::shipped::utf8;
use crate::augment::Block;
use crate::linalg::{Mat, c64};
use crate::lti::Discrete;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Fields of one problem file.
pub struct ProblemFields {
    file: PathBuf,
    text: String,
    /// Where the fields stand in the problem, with its dot; empty for its own.
    place: String,
    fields: Map<String, Value>,
    beside: Map<String, Value>,
}

impl ProblemFields {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, is not JSON, or is not an object.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        let name = file.display().to_string();
        let bytes = files::read(file, files::MATRICES).map_err(|e| e.of(&name))?;
        Self::parse(file, &utf8(&name, bytes)?)
    }

    /// Reads the text of a file; `file` names it in messages.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(file: &Path, text: &str) -> Result<Self, InputError> {
        let value: Value = json::parse(text).map_err(|e| {
            let file = file.display().to_string();
            if e.is_data() {
                return InputError::json(&file, &e);
            }
            InputError::new(&file, format!("not valid JSON: {e}"))
                .with_hint("JSON has no NaN and no Infinity; every number must be finite")
        })?;
        let Value::Object(mut top) = value else {
            return Err(InputError::new(&file.display().to_string(), "expected a JSON object")
                .with_hint("put the matrices into {\"data\": {\"A\": [[..]], ..}}"));
        };
        let (fields, beside) = match top.remove("data") {
            None => (top, Map::new()),
            Some(Value::Object(data)) => (data, top),
            Some(other) => {
                return Err(InputError::new(
                    &file.display().to_string(),
                    format!("data: expected an object, found {}", kind(&other)),
                ));
            }
        };
        Ok(Self { file: file.to_path_buf(), text: text.to_owned(), place: String::new(), fields, beside })
    }

    pub(super) fn fields(&self) -> &Map<String, Value> {
        &self.fields
    }

    /// The fields of an object that is a field, read as those of a problem.
    pub(super) fn part(&self, field: &str, fields: &Map<String, Value>) -> Self {
        let (file, text) = (self.file.clone(), self.text.clone());
        Self { file, text, place: format!("{}{field}.", self.place), fields: fields.clone(), beside: Map::new() }
    }

    pub(super) fn beside(&self) -> &Map<String, Value> {
        &self.beside
    }

    /// An error about a key, with the line on which it stands.
    pub(super) fn failure_at_key(&self, key: &str, message: impl std::fmt::Display) -> InputError {
        let quoted = Value::from(key).to_string();
        let line = self.text.lines().position(|line| line.contains(&quoted));
        InputError {
            line: line.map(|k| k + 1),
            ..InputError::new(&self.file.display().to_string(), message.to_string())
        }
    }

    /// An error about a field of this file.
    pub(crate) fn failure(&self, field: &str, message: impl std::fmt::Display) -> InputError {
        InputError::new(&self.file.display().to_string(), format!("{}{field}: {message}", self.place))
    }

    /// True when the field is there and not `null`.
    pub fn has(&self, field: &str) -> bool {
        self.fields.get(field).is_some_and(|v| !v.is_null())
    }

    /// A field as it stands.
    ///
    /// # Errors
    /// A missing field.
    pub fn value(&self, field: &str) -> Result<&Value, InputError> {
        self.fields.get(field).ok_or_else(|| {
            let known: Vec<&str> = self.fields.keys().map(String::as_str).collect();
            self.failure(field, "missing").with_hint(format!("fields found: {}", known.join(", ")))
        })
    }

    pub(super) fn locate_fault(&self, fault: Fault) -> InputError {
        let error = self.failure(&fault.path, fault.message);
        match fault.hint {
            Some(hint) => error.with_hint(hint),
            None => error,
        }
    }

    /// A finite number.
    pub(crate) fn number(&self, field: &str) -> Result<f64, InputError> {
        finite(self.value(field)?, field).map_err(|e| self.locate_fault(e))
    }

    /// True or false.
    pub(crate) fn flag(&self, field: &str) -> Result<bool, InputError> {
        let value = self.value(field)?;
        value.as_bool().ok_or_else(|| self.failure(field, format!("must be true or false, found {value}")))
    }

    /// A non-negative whole number.
    pub(crate) fn count(&self, field: &str) -> Result<usize, InputError> {
        whole(self.value(field)?, field).map_err(|e| self.locate_fault(e))
    }

    /// A list of non-negative whole numbers; one number is a list of one.
    pub(crate) fn counts(&self, field: &str) -> Result<Vec<usize>, InputError> {
        self.each(field, whole)
    }

    /// A list of finite numbers; one number is a list of one.
    pub(crate) fn numbers(&self, field: &str) -> Result<Vec<f64>, InputError> {
        self.each(field, finite)
    }

    fn each<T>(&self, field: &str, read: fn(&Value, &str) -> Result<T, Fault>) -> Result<Vec<T>, InputError> {
        let list = match self.value(field)? {
            one @ Value::Number(_) => return Ok(vec![read(one, field).map_err(|e| self.locate_fault(e))?]),
            Value::Array(list) if list.len() > MOST_ENTRIES => {
                let rule = format!("has {} entries; at most {MOST_ENTRIES} are possible", list.len());
                return Err(self.failure(field, rule));
            }
            Value::Array(list) => list,
            other => return Err(self.failure(field, format!("expected a list, found {}", kind(other)))),
        };
        let entry = |(i, v): (usize, &Value)| read(v, &format!("{field}[{i}]")).map_err(|e| self.locate_fault(e));
        list.iter().enumerate().map(entry).collect()
    }

    pub(super) fn entries(&self, field: &str) -> Result<Entries, InputError> {
        Entries::of(self.value(field)?, field).map_err(|e| self.locate_fault(e))
    }

    /// A real matrix of a given shape.
    pub(crate) fn matrix_of(&self, field: &str, rows: usize, cols: usize) -> Result<Mat<f64>, InputError> {
        let entries = self.entries(field)?;
        entries
            .with_size(rows, cols)
            .ok_or_else(|| self.failure(field, format!("expected a {rows} x {cols} matrix, found {}", entries.words())))
    }

    /// A real matrix with a given number of rows; a list of numbers is a row of it, or its only column.
    pub(crate) fn rows_of(&self, field: &str, rows: usize) -> Result<Mat<f64>, InputError> {
        let entries = self.entries(field)?;
        let fitting = entries.sizes().into_iter().find(|[r, _]| *r == rows);
        fitting.and_then(|[r, cols]| entries.with_size(r, cols)).ok_or_else(|| {
            self.failure(field, format!("expected a matrix with {rows} rows, found {}", entries.words()))
        })
    }

    /// A square real matrix.
    pub(crate) fn square(&self, field: &str) -> Result<Mat<f64>, InputError> {
        let entries = self.entries(field)?;
        let rows = entries.sizes().first().map_or(0, |[rows, _]| *rows);
        entries
            .with_size(rows, rows)
            .ok_or_else(|| self.failure(field, format!("expected a square matrix, found {}", entries.words())))
    }

    /// A complex matrix `{"re": rows, "im": rows}`, or a real one. A list of numbers is a row or a column as `rows` and
    /// `cols` say; a matrix of another shape is returned as it is.
    pub(crate) fn complex_matrix(&self, field: &str, rows: usize, cols: usize) -> Result<Mat<c64>, InputError> {
        let part = |value: &Value, path: &str| {
            let entries = Entries::of(value, path).map_err(|e| self.locate_fault(e))?;
            match (entries.with_size(rows, cols), entries) {
                (Some(found), _) | (None, Entries::Rows(found)) => Ok(found),
                (None, listed @ Entries::Listed(_)) => {
                    Err(self.failure(path, format!("expected a {rows} x {cols} matrix, found {}", listed.words())))
                }
            }
        };
        let value = self.value(field)?;
        let Value::Object(parts) = value else {
            let re = part(value, field)?;
            return Ok(Mat::from_fn(re.nrows(), re.ncols(), |i, j| c64::new(re[(i, j)], 0.0)));
        };
        if let Some(key) = parts.keys().find(|key| !["re", "im"].contains(&key.as_str())) {
            return Err(self
                .failure_at_key(key, format!("unknown key `{field}.{key}`"))
                .with_hint("a complex matrix has `re` and `im`"));
        }
        let named = |name: &str| match parts.get(name) {
            Some(v) => part(v, &format!("{field}.{name}")),
            None => Err(self.failure(&format!("{field}.{name}"), "missing")),
        };
        let (re, im) = (named("re")?, named("im")?);
        if (re.nrows(), re.ncols()) != (im.nrows(), im.ncols()) {
            return Err(self.failure(field, "re and im differ in shape"));
        }
        Ok(Mat::from_fn(re.nrows(), re.ncols(), |i, j| c64::new(re[(i, j)], im[(i, j)])))
    }

    /// The sample time `Ts` or `sample_time_s`; none in continuous time.
    ///
    /// # Errors
    /// A sample time that is negative, or two that differ.
    pub fn sample_time(&self) -> Result<Option<Discrete>, InputError> {
        let mut found: Option<(&str, f64)> = None;
        for field in ["Ts", "sample_time_s"].into_iter().filter(|field| self.has(field)) {
            let period = self.number(field)?;
            if period < 0.0 {
                let rule = format!("must be positive, or 0 for continuous time, found {period}");
                let hint = "a sample time that is not said (-1) gives no frequency; say it in s";
                return Err(self.failure(field, rule).with_hint(hint));
            }
            match found {
                Some((other, same)) if same != period => {
                    return Err(self.failure(field, format!("is {period}, but {other} is {same}: give one")));
                }
                _ => found = Some((field, period)),
            }
        }
        Ok(found.filter(|(_, period_s)| *period_s > 0.0).map(|(_, period_s)| Discrete { period_s }))
    }

    /// The uncertainty structure `blocks`.
    pub(crate) fn blocks(&self) -> Result<Vec<Block>, InputError> {
        let list = match self.value("blocks")? {
            Value::Array(list) => list.as_slice(),
            one @ Value::Object(_) => std::slice::from_ref(one),
            other => return Err(self.failure("blocks", format!("expected a list, found {}", kind(other)))),
        };
        if list.is_empty() {
            return Err(self.failure("blocks", "expected at least one block"));
        }
        list.iter().enumerate().map(|(i, v)| self.block(v, &format!("blocks[{i}]"))).collect()
    }

    fn block(&self, value: &Value, path: &str) -> Result<Block, InputError> {
        let size = |name: &str| {
            let path = format!("{path}.{name}");
            match value.get(name) {
                None => Err(self.failure(&path, "missing")),
                Some(v) => match whole(v, &path).map_err(|e| self.locate_fault(e))? {
                    0 => Err(self.failure(&path, "must be at least 1")),
                    k => Ok(k),
                },
            }
        };
        let (block, sizes): (_, &[&str]) = match value.get("type").and_then(Value::as_str) {
            Some("complex_full") => {
                (Block::ComplexFull { rows: size("rows")?, cols: size("cols")? }, &["rows", "cols"])
            }
            Some("complex_scalar") => (Block::ComplexScalar { n: size("n")? }, &["n"]),
            Some("real_scalar") => (Block::RealScalar { n: size("n")? }, &["n"]),
            other => {
                return Err(self
                    .failure(&format!("{path}.type"), format!("unknown block type {}", other.unwrap_or("(none)")))
                    .with_hint("complex_full with rows and cols, complex_scalar or real_scalar with n"));
            }
        };
        let foreign = |(key, v): &(&String, &Value)| {
            let is_empty = v.is_null() || v.as_array().is_some_and(Vec::is_empty);
            *key != "type" && !sizes.contains(&key.as_str()) && !is_empty
        };
        match value.as_object().and_then(|map| map.iter().find(foreign)) {
            None => Ok(block),
            Some((key, _)) => Err(self
                .failure_at_key(key, format!("unknown key `{path}.{key}`"))
                .with_hint(format!("a block of this type has `type`, `{}`", sizes.join("`, `")))),
        }
    }

    /// Checks an optional count of the file against the matrices.
    pub(crate) fn agrees(&self, field: &str, expected: usize) -> Result<(), InputError> {
        if !self.has(field) {
            return Ok(());
        }
        match self.count(field)? {
            found if found == expected => Ok(()),
            found => Err(self.failure(field, format!("is {found}, but the matrices say {expected}"))),
        }
    }
}
