//! The problem file of `muspin solve`: JSON fields in `data` (or at the top level), read with shape checks.
//! Real matrices are lists of rows; complex ones `{"re": rows, "im": rows}`. Every error names file and field.

use super::error::InputError;
use super::shipped::utf8;
use crate::augment::{Block, GeneralizedPlant};
use crate::linalg::{Mat, c64};
use crate::lti::{Continuous, StateSpace};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Fields of one problem file.
pub struct Problem {
    file: PathBuf,
    fields: Map<String, Value>,
}

impl Problem {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, is not JSON, or is not an object.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        let bytes = std::fs::read(file).map_err(|e| InputError::new(&file.display().to_string(), e.to_string()))?;
        Self::parse(file, &utf8(&file.display().to_string(), bytes)?)
    }

    /// Reads the text of a file; `file` names it in messages.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(file: &Path, text: &str) -> Result<Self, InputError> {
        let value: Value = serde_json::from_str(text).map_err(|e| {
            InputError::new(&file.display().to_string(), format!("not valid JSON: {e}"))
                .with_hint("JSON has no NaN and no Infinity; every number must be finite")
        })?;
        let Value::Object(mut top) = value else {
            return Err(InputError::new(&file.display().to_string(), "expected a JSON object")
                .with_hint("put the matrices into {\"data\": {\"A\": [[..]], ..}}"));
        };
        let fields = match top.remove("data") {
            None => top,
            Some(Value::Object(data)) => data,
            Some(other) => {
                return Err(InputError::new(
                    &file.display().to_string(),
                    format!("data: expected an object, found {}", kind(&other)),
                ));
            }
        };
        Ok(Self { file: file.to_path_buf(), fields })
    }

    /// An error about a field of this file.
    pub(crate) fn failure(&self, field: &str, message: impl std::fmt::Display) -> InputError {
        InputError::new(&self.file.display().to_string(), format!("{field}: {message}"))
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

    /// A finite number.
    ///
    /// # Errors
    /// A missing field or something else than a finite number.
    pub(crate) fn number(&self, field: &str) -> Result<f64, InputError> {
        self.finite(self.value(field)?, field)
    }

    /// True or false.
    ///
    /// # Errors
    /// A missing field or something else.
    pub(crate) fn flag(&self, field: &str) -> Result<bool, InputError> {
        let value = self.value(field)?;
        value.as_bool().ok_or_else(|| self.failure(field, format!("must be true or false, found {value}")))
    }

    /// A non-negative whole number.
    ///
    /// # Errors
    /// A missing field or something else.
    pub(crate) fn count(&self, field: &str) -> Result<usize, InputError> {
        let value = self.value(field)?;
        self.whole(value, field)
    }

    /// A list of non-negative whole numbers.
    ///
    /// # Errors
    /// A missing field or something else.
    pub(crate) fn counts(&self, field: &str) -> Result<Vec<usize>, InputError> {
        self.list(field)?.iter().enumerate().map(|(i, v)| self.whole(v, &format!("{field}[{i}]"))).collect()
    }

    /// A list of finite numbers.
    ///
    /// # Errors
    /// A missing field or something else.
    pub(crate) fn numbers(&self, field: &str) -> Result<Vec<f64>, InputError> {
        self.list(field)?.iter().enumerate().map(|(i, v)| self.finite(v, &format!("{field}[{i}]"))).collect()
    }

    /// A real matrix of any shape.
    ///
    /// # Errors
    /// A missing field, ragged rows, or an entry that is not a finite number.
    pub(crate) fn matrix(&self, field: &str) -> Result<Mat<f64>, InputError> {
        self.rows(self.value(field)?, field)
    }

    /// A real matrix of a given shape.
    ///
    /// # Errors
    /// As [`Self::matrix`], and another shape.
    pub(crate) fn matrix_of(&self, field: &str, rows: usize, cols: usize) -> Result<Mat<f64>, InputError> {
        let m = self.matrix(field)?;
        // An empty list of rows carries no column count.
        if m.nrows() == 0 && rows == 0 {
            return Ok(Mat::zeros(0, cols));
        }
        if (m.nrows(), m.ncols()) == (rows, cols) {
            return Ok(m);
        }
        Err(self.failure(field, format!("expected a {rows} x {cols} matrix, found {} x {}", m.nrows(), m.ncols())))
    }

    /// A square real matrix.
    ///
    /// # Errors
    /// As [`Self::matrix`], and a matrix that is not square.
    pub(crate) fn square(&self, field: &str) -> Result<Mat<f64>, InputError> {
        let m = self.matrix(field)?;
        if m.nrows() == m.ncols() {
            return Ok(m);
        }
        Err(self.failure(field, format!("expected a square matrix, found {} x {}", m.nrows(), m.ncols())))
    }

    /// A complex matrix `{"re": rows, "im": rows}`, or a real one.
    ///
    /// # Errors
    /// As [`Self::matrix`], and parts of different shape.
    pub(crate) fn complex_matrix(&self, field: &str) -> Result<Mat<c64>, InputError> {
        let value = self.value(field)?;
        let Value::Object(parts) = value else {
            let re = self.rows(value, field)?;
            return Ok(Mat::from_fn(re.nrows(), re.ncols(), |i, j| c64::new(re[(i, j)], 0.0)));
        };
        let part = |name: &str| match parts.get(name) {
            Some(v) => self.rows(v, &format!("{field}.{name}")),
            None => Err(self.failure(&format!("{field}.{name}"), "missing")),
        };
        let (re, im) = (part("re")?, part("im")?);
        if (re.nrows(), re.ncols()) != (im.nrows(), im.ncols()) {
            return Err(self.failure(field, "re and im differ in shape"));
        }
        Ok(Mat::from_fn(re.nrows(), re.ncols(), |i, j| c64::new(re[(i, j)], im[(i, j)])))
    }

    /// The continuous system A, B, C, D.
    ///
    /// # Errors
    /// Missing fields and shapes that do not fit.
    pub fn system(&self) -> Result<StateSpace<Continuous>, InputError> {
        let a = self.square("A")?;
        let n = a.nrows();
        let d = self.matrix("D")?;
        let (p, m) = (d.nrows(), d.ncols());
        let b = self.matrix_of("B", n, m)?;
        let c = self.matrix_of("C", p, n)?;
        for (field, expected) in [("n", n), ("m", m), ("p", p)] {
            self.agrees(field, expected)?;
        }
        StateSpace::new(a, b, c, d, Continuous).map_err(|e| self.failure("A, B, C, D", e))
    }

    /// The generalized plant A, B = [B1 B2], C = [C1; C2], D with m1, m2, p1, p2, and its blocks if given.
    ///
    /// # Errors
    /// Missing fields, shapes and block sizes that do not fit.
    pub fn generalized_plant(&self) -> Result<GeneralizedPlant, InputError> {
        let (m1, m2) = (self.count("m1")?, self.count("m2")?);
        let (p1, p2) = (self.count("p1")?, self.count("p2")?);
        for (field, value) in [("m2", m2), ("p2", p2)] {
            if value == 0 {
                return Err(self.failure(field, "must be at least 1"));
            }
        }
        let a = self.square("A")?;
        let n = a.nrows();
        self.agrees("n", n)?;
        let b = self.matrix_of("B", n, m1 + m2)?;
        let c = self.matrix_of("C", p1 + p2, n)?;
        let d = self.matrix_of("D", p1 + p2, m1 + m2)?;
        let blocks = if self.has("blocks") {
            let blocks = self.blocks()?;
            let rows: usize = blocks.iter().map(Block::rows).sum();
            let cols: usize = blocks.iter().map(Block::cols).sum();
            if (rows, cols) != (m1, p1) {
                return Err(self.failure(
                    "blocks",
                    format!("rows and cols sum to {rows} and {cols}, expected m1 = {m1} and p1 = {p1}"),
                ));
            }
            blocks
        } else {
            vec![]
        };
        Ok(GeneralizedPlant {
            system: StateSpace::new(a, b, c, d, Continuous).map_err(|e| self.failure("A, B, C, D", e))?,
            controls: m2,
            measurements: p2,
            blocks,
        })
    }

    /// The uncertainty structure `blocks`.
    ///
    /// # Errors
    /// An unknown type, a missing or zero size, an empty list.
    pub(crate) fn blocks(&self) -> Result<Vec<Block>, InputError> {
        let list = self.list("blocks")?;
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
                Some(v) => match self.whole(v, &path)? {
                    0 => Err(self.failure(&path, "must be at least 1")),
                    k => Ok(k),
                },
            }
        };
        match value.get("type").and_then(Value::as_str) {
            Some("complex_full") => Ok(Block::ComplexFull { rows: size("rows")?, cols: size("cols")? }),
            Some("complex_scalar") => Ok(Block::ComplexScalar { n: size("n")? }),
            Some("real_scalar") => Ok(Block::RealScalar { n: size("n")? }),
            other => Err(self
                .failure(&format!("{path}.type"), format!("unknown block type {}", other.unwrap_or("(none)")))
                .with_hint("complex_full with rows and cols, complex_scalar or real_scalar with n")),
        }
    }

    /// Checks an optional count of the file against the matrices.
    fn agrees(&self, field: &str, expected: usize) -> Result<(), InputError> {
        if !self.has(field) {
            return Ok(());
        }
        match self.count(field)? {
            found if found == expected => Ok(()),
            found => Err(self.failure(field, format!("is {found}, but the matrices say {expected}"))),
        }
    }

    fn list(&self, field: &str) -> Result<&Vec<Value>, InputError> {
        match self.value(field)? {
            Value::Array(list) => Ok(list),
            other => Err(self.failure(field, format!("expected a list, found {}", kind(other)))),
        }
    }

    fn rows(&self, value: &Value, path: &str) -> Result<Mat<f64>, InputError> {
        let Value::Array(rows) = value else {
            return Err(self.failure(path, format!("expected a matrix (list of rows), found {}", kind(value))));
        };
        let mut entries: Vec<Vec<f64>> = Vec::with_capacity(rows.len());
        for (i, row) in rows.iter().enumerate() {
            let Value::Array(row) = row else {
                return Err(self
                    .failure(&format!("{path}[{i}]"), format!("expected a row (list of numbers), found {}", kind(row)))
                    .with_hint("real matrices are row-major nested lists, also 1 x n and n x 1"));
            };
            let row: Vec<f64> = row
                .iter()
                .enumerate()
                .map(|(j, v)| self.finite(v, &format!("{path}[{i}][{j}]")))
                .collect::<Result<_, _>>()?;
            if let Some(first) = entries.first()
                && first.len() != row.len()
            {
                return Err(self.failure(
                    &format!("{path}[{i}]"),
                    format!("has {} entries, the first row has {}", row.len(), first.len()),
                ));
            }
            entries.push(row);
        }
        let cols = entries.first().map_or(0, Vec::len);
        Ok(Mat::from_fn(entries.len(), cols, |i, j| entries[i][j]))
    }

    fn finite(&self, value: &Value, path: &str) -> Result<f64, InputError> {
        match value.as_f64() {
            Some(x) if x.is_finite() => Ok(x),
            _ => Err(self.failure(path, format!("expected a finite number, found {}", kind(value)))),
        }
    }

    fn whole(&self, value: &Value, path: &str) -> Result<usize, InputError> {
        // 2^53: beyond it a JSON number is no longer a whole number everywhere; no dimension comes near.
        match value.as_f64() {
            Some(x) if x >= 0.0 && x.fract() == 0.0 && x < 9.0e15 => Ok(x as usize),
            _ => Err(self.failure(path, format!("expected a whole number >= 0, found {}", kind(value)))),
        }
    }
}

fn kind(value: &Value) -> String {
    match value {
        Value::Null => "null".into(),
        Value::Bool(b) => b.to_string(),
        Value::Number(n) => n.to_string(),
        Value::String(s) => format!("the text \"{s}\""),
        Value::Array(_) => "a list".into(),
        Value::Object(_) => "an object".into(),
    }
}
