//! `summary.json`: figures under dotted keys, in the order they are added, numbers in shortest round-trip form.
//!
//! A number that is not finite is written as `null`: JSON has no other word for it. Integers stay integers.
//! A topic is one `json!` literal of the domain's results, in the order of the file; page and tables read what they
//! show of it into a struct.

use serde::Serialize;
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
    pub fn set(&mut self, key: &str, value: impl Serialize) {
        self.insert(key, json(value));
    }

    fn insert(&mut self, key: &str, value: Value) {
        let mut place = &mut self.root;
        let mut parts = key.split('.').peekable();
        while let Some(part) = parts.next() {
            if parts.peek().is_none() {
                place.insert(part.to_owned(), value);
                return;
            }
            let next = place.entry(part).or_insert_with(|| Value::Object(Map::new()));
            if !next.is_object() {
                *next = Value::Object(Map::new());
            }
            match next {
                Value::Object(map) => place = map,
                _ => return,
            }
        }
    }

    /// The value at a dotted key.
    pub fn get(&self, key: &str) -> Option<&Value> {
        let (first, rest) = key.split_once('.').map_or((key, None), |(f, r)| (f, Some(r)));
        let value = self.root.get(first)?;
        rest.map_or(Some(value), |rest| value.pointer(&format!("/{}", rest.replace('.', "/"))))
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

/// A topic as a JSON value; numbers that are not finite become `null`.
pub fn json(value: impl Serialize) -> Value {
    // Fails only for maps whose keys are no strings, and no topic has one.
    serde_json::to_value(value).unwrap_or_default()
}

/// The topic without those of `keys` whose value is `null`.
pub(crate) fn omit_absent(mut topic: Value, keys: &[&str]) -> Value {
    if let Value::Object(map) = &mut topic {
        map.retain(|key, value| !(value.is_null() && keys.contains(&key.as_str())));
    }
    topic
}

/// Indented JSON with a final line end; lists of plain values stay on one line.
pub(crate) fn json_text(value: &Value) -> String {
    let mut text = String::new();
    write(value, 0, &mut text);
    text.push('\n');
    text
}

fn write(value: &Value, depth: usize, out: &mut String) {
    match value {
        Value::Object(map) if !map.is_empty() => {
            let entries = map.iter().map(|(key, item)| (format!("{}: ", Value::String(key.clone())), item));
            write_lines(['{', '}'], entries, depth, out);
        }
        Value::Array(items) if items.iter().any(|i| i.is_object() || i.is_array()) => {
            write_lines(['[', ']'], items.iter().map(|item| (String::new(), item)), depth, out);
        }
        Value::Array(items) => {
            let cells: Vec<String> = items.iter().map(Value::to_string).collect();
            out.push_str(&format!("[{}]", cells.join(", ")));
        }
        plain => out.push_str(&plain.to_string()),
    }
}

/// Entries with what stands before each, a line each, in brackets.
fn write_lines<'a>(
    [open, close]: [char; 2],
    entries: impl Iterator<Item = (String, &'a Value)>,
    depth: usize,
    out: &mut String,
) {
    let mut before = open;
    for (head, item) in entries {
        out.push(before);
        out.push_str(&format!("\n{}{head}", "  ".repeat(depth + 1)));
        write(item, depth + 1, out);
        before = ',';
    }
    out.push_str(&format!("\n{}{close}", "  ".repeat(depth)));
}
