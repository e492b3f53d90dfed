//! A table of a ROSS file: typed values, with the table and the key in every error.

use super::error::InputError;
use serde_json::{Map, Value};

pub(super) struct RossTable<'a> {
    pub file: &'a str,
    pub name: &'a str,
    pub table: &'a Map<String, Value>,
}

impl RossTable<'_> {
    pub(super) fn wrong(&self, rule: impl std::fmt::Display) -> InputError {
        InputError::new(self.file, format!("{}: {rule}", self.name))
    }

    /// The class of the element: its name up to the first underscore.
    pub(super) fn class(&self) -> &str {
        self.name.split('_').next().unwrap_or_default()
    }

    /// The tag of the element, its name without one.
    pub(super) fn tag(&self) -> &str {
        self.table.get("tag").and_then(Value::as_str).unwrap_or(self.name)
    }

    /// Whether the key is there and not null.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some_and(|v| !v.is_null())
    }

    pub(super) fn number(&self, key: &str) -> Result<f64, InputError> {
        match self.table.get(key).and_then(Value::as_f64) {
            Some(x) if x.is_finite() => Ok(x),
            _ => Err(self
                .wrong(format!("{key}: expected a number"))
                .with_hint("save the rotor again with a current version of ROSS")),
        }
    }

    /// A number for both axes, or a list with one for x and one for y; `left_out` stands where the key is missing.
    pub(super) fn pair(&self, key: &str, left_out: f64) -> Result<[f64; 2], InputError> {
        let Some(Value::Array(list)) = self.table.get(key) else {
            let both = if self.has(key) { self.number(key)? } else { left_out };
            return Ok([both; 2]);
        };
        let values: Option<Vec<f64>> = list.iter().map(|v| v.as_f64().filter(|x| x.is_finite())).collect();
        match values.as_deref() {
            Some([both]) => Ok([*both; 2]),
            Some([x, y]) => Ok([*x, *y]),
            _ => Err(self
                .wrong(format!("{key}: expected a number, or one for x and one for y"))
                .with_hint("save the rotor again with a current version of ROSS")),
        }
    }

    pub(super) fn node(&self) -> Result<usize, InputError> {
        let n = self.number("n")?;
        if n >= 0.0 && n.fract() == 0.0 && n < 1e6 {
            Ok(n as usize)
        } else {
            Err(self.wrong(format!("n: {n} is no number of a node")))
        }
    }

    /// A switch, on where the key is missing.
    pub(super) fn flag(&self, key: &str) -> bool {
        self.table.get(key).and_then(Value::as_bool).unwrap_or(true)
    }

    /// Whether a number, or one of a list, differs from zero.
    pub(super) fn is_nonzero(&self, key: &str) -> bool {
        let nonzero = |v: &Value| v.as_f64().is_some_and(|x| x != 0.0);
        match self.table.get(key) {
            Some(Value::Array(list)) => list.iter().any(nonzero),
            Some(value) => nonzero(value),
            None => false,
        }
    }
}
