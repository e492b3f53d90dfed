//! `summary.json`: figures under dotted keys, in the order they are added, numbers in shortest round-trip form.
//!
//! A number that is not finite is written as `null`: JSON has no other word for it. Integers stay integers.
//! A topic is a struct whose fields are the keys; pages and tables read the struct, not the keys.

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use serde_json::{Map, Value};
use std::fmt;
use std::marker::PhantomData;

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

/// A number of a topic; `None`, hence `null` in the file, if it is not finite.
pub(crate) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// Numbers of a topic.
pub(crate) fn finite_all(values: &[f64]) -> Vec<Option<f64>> {
    values.iter().copied().map(finite).collect()
}

/// Values under names that are data, not fields; an object in the order given.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Named<T>(pub(crate) Vec<(String, T)>);

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self(vec![])
    }
}

impl<T> FromIterator<(String, T)> for Named<T> {
    fn from_iter<I: IntoIterator<Item = (String, T)>>(all: I) -> Self {
        Self(all.into_iter().collect())
    }
}

impl<T> Named<T> {
    pub(crate) fn get(&self, name: &str) -> Option<&T> {
        let found = self.0.iter().find(|(known, _)| known == name);
        found.map(|(_, value)| value)
    }
}

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(NamedVisitor(PhantomData))
    }
}

struct NamedVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for NamedVisitor<T> {
    type Value = Named<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut all = vec![];
        while let Some(entry) = map.next_entry()? {
            all.push(entry);
        }
        Ok(Named(all))
    }
}

/// Indented JSON with a final line end; lists of plain values stay on one line.
pub(crate) fn json_text(value: &Value) -> String {
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
