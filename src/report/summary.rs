//! `summary.json`: figures under dotted keys, in the order they are added, numbers in shortest round-trip form.
//!
//! A number that is not finite is written as `null`: JSON has no other word for it. Integers stay integers.

use serde_json::{Map, Value};

/// A summary under construction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    root: Map<String, Value>,
}

impl Summary {
    /// An empty summary.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the value at a dotted key (`stiffness.mu.minimum_n_per_m`); objects on the way are made.
    /// A key that runs through a value that is not an object replaces it.
    pub fn set(&mut self, key: &str, value: impl Into<Value>) {
        let mut place = &mut self.root;
        let mut parts = key.split('.').peekable();
        while let Some(part) = parts.next() {
            if parts.peek().is_none() {
                place.insert(part.to_owned(), value.into());
                return;
            }
            let next = place
                .entry(part)
                .or_insert_with(|| Value::Object(Map::new()));
            if !next.is_object() {
                *next = Value::Object(Map::new());
            }
            match next {
                Value::Object(map) => place = map,
                _ => return,
            }
        }
    }

    /// Sets a number; `null` if it is not finite.
    pub fn number(&mut self, key: &str, value: f64) {
        self.set(key, number(value));
    }

    /// Sets a list of numbers.
    pub fn numbers(&mut self, key: &str, values: &[f64]) {
        self.set(key, numbers(values));
    }

    /// The value at a dotted key.
    pub fn get(&self, key: &str) -> Option<&Value> {
        let (first, rest) = key
            .split_once('.')
            .map_or((key, None), |(f, r)| (f, Some(r)));
        let value = self.root.get(first)?;
        rest.map_or(Some(value), |rest| {
            value.pointer(&format!("/{}", rest.replace('.', "/")))
        })
    }

    /// The whole as a JSON value.
    pub fn value(&self) -> Value {
        Value::Object(self.root.clone())
    }

    /// The text of the file.
    pub fn to_json(&self) -> String {
        json_text(&self.value())
    }
}

impl From<Map<String, Value>> for Summary {
    fn from(root: Map<String, Value>) -> Self {
        Self { root }
    }
}

/// A JSON number; `null` if it is not finite.
pub fn number(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number)
}

/// A JSON list of numbers.
pub fn numbers(values: &[f64]) -> Value {
    Value::Array(values.iter().map(|v| number(*v)).collect())
}

/// Indented JSON with a final line end; lists of plain values stay on one line.
pub fn json_text(value: &Value) -> String {
    let mut text = String::new();
    write(value, 0, &mut text);
    text.push('\n');
    text
}

fn write(value: &Value, depth: usize, out: &mut String) {
    let indent = |depth: usize| "  ".repeat(depth);
    match value {
        Value::Object(map) if !map.is_empty() => {
            out.push_str("{\n");
            for (k, (key, item)) in map.iter().enumerate() {
                out.push_str(&indent(depth + 1));
                out.push_str(&format!("{}: ", Value::String(key.clone())));
                write(item, depth + 1, out);
                out.push_str(if k + 1 < map.len() { ",\n" } else { "\n" });
            }
            out.push_str(&indent(depth));
            out.push('}');
        }
        Value::Array(items) if items.iter().any(|i| i.is_object() || i.is_array()) => {
            out.push_str("[\n");
            for (k, item) in items.iter().enumerate() {
                out.push_str(&indent(depth + 1));
                write(item, depth + 1, out);
                out.push_str(if k + 1 < items.len() { ",\n" } else { "\n" });
            }
            out.push_str(&indent(depth));
            out.push(']');
        }
        Value::Array(items) => {
            let cells: Vec<String> = items.iter().map(Value::to_string).collect();
            out.push_str(&format!("[{}]", cells.join(", ")));
        }
        plain => out.push_str(&plain.to_string()),
    }
}
