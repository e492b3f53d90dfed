//! JSON Schemas of the files that people and programs write, from the types that read them and the table of their keys.
//!
//! An editor with a YAML or JSON language server takes them for completion and for marks at wrong keys and impossible
//! values. A schema asks for no more than the reader does; rules that tie several values together are the reader's
//! alone.

use super::controller::ControllerFile;
use super::keys::{FREQUENCIES, Key, KeyGroup, MEASUREMENT, PID, ROTOR, SPINDLE, TOOL, WEIGHTS};
use super::measurement::{FrequenciesFile, MeasurementFile};
use super::pid::PidFile;
use super::rotor::RotorModelFile;
use super::spindle::SpindleFile;
use super::tool::ToolFile;
use super::weights::WeightsFile;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// The kinds in the order of the formats page: variant, name, its keys, the type that reads it.
macro_rules! kinds {
    ($($kind:ident $name:literal $keys:expr, $file:ty;)*) => {
        named! {
            /// A kind of file that has a schema, by its name on the command line and in file names; in the order of the
            /// formats page.
            pub enum SchemaKind { $($kind = $name,)* }
        }

        impl SchemaKind {
            fn groups(self) -> &'static [KeyGroup] {
                match self { $(Self::$kind => $keys,)* }
            }

            /// The schema of the reader without ranges.
            fn derive_schema(self) -> Value {
                match self { $(Self::$kind => derive_schema::<$file>(),)* }
            }
        }
    };
}

kinds! {
    Spindle "spindle" SPINDLE, SpindleFile;
    Rotor "rotor" ROTOR, RotorModelFile;
    Tool "tool" TOOL, ToolFile;
    Weights "weights" WEIGHTS, WeightsFile;
    Measurement "measurement" MEASUREMENT, MeasurementFile;
    Frequencies "frequencies" FREQUENCIES, FrequenciesFile;
    Controller "controller" &[], ControllerFile;
    Pid "pid" PID, PidFile;
}

/// The JSON Schema (draft 2020-12) of a kind of file. Beside the standard keywords a number has `x-unit`, `x-plausible`
/// (the range that real machines keep to) and `x-reason`.
pub fn schema(kind: SchemaKind) -> Value {
    let mut schema = kind.derive_schema();
    // The table has keys of effects too; their alternatives come from the table of effects, with its own rules of sign.
    for group in kind.groups().iter().filter(|g| g.at != "effects[]") {
        let steps: Vec<&str> = group.at.split('.').filter(|s| !s.is_empty()).collect();
        for key in group.keys {
            let path = [steps.as_slice(), &[key.name]].concat();
            at_every(&mut schema, &path, &mut |found| add_key(found, key));
        }
    }
    schema
}

fn derive_schema<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

/// Visits every schema at a path: `name[]` are the entries of a list, `*` is every name.
fn at_every(schema: &mut Value, path: &[&str], visit: &mut dyn FnMut(&mut Value)) {
    let Some((step, rest)) = path.split_first() else {
        return visit(schema);
    };
    if let Some(Value::Array(alternatives)) = schema.get_mut("anyOf") {
        alternatives.iter_mut().for_each(|own| at_every(own, path, visit));
    }
    if *step == "*" {
        let open = schema["additionalProperties"].is_object();
        let names = schema.get_mut(if open { "additionalProperties" } else { "properties" });
        match names {
            Some(any) if open => at_every(any, rest, visit),
            Some(Value::Object(listed)) => {
                listed.values_mut().for_each(|own| at_every(own, rest, visit));
            }
            _ => {}
        }
        return;
    }
    let name = step.trim_end_matches("[]");
    let mut found = schema.get_mut("properties").and_then(|all| all.get_mut(name));
    if step.ends_with("[]") {
        found = found.and_then(|list| list.get_mut("items"));
    }
    if let Some(found) = found {
        at_every(found, rest, visit);
    }
}

fn add_key(schema: &mut Value, key: &Key) {
    let Value::Object(map) = schema else { return };
    let [low, high] = key.possible;
    map.remove("format");
    map.insert("minimum".into(), json!(low));
    if high.is_finite() {
        map.insert("maximum".into(), json!(high));
    }
    if !key.unit.is_empty() {
        map.insert("x-unit".into(), json!(key.unit));
    }
    map.insert("x-plausible".into(), json!(key.plausible));
    map.insert("x-reason".into(), json!(key.reason));
}

/// The page of all keys in Markdown: one table for every group of keys, from the schemas.
pub fn page() -> String {
    let mut text = String::from(
        "# Keys of all files\n\nEvery key with its unit, whether it may be left out and what it is then, the range \
         that real machines keep to (outside it muspin warns) and the range outside which a value is refused. This \
         page is generated from the readers: `muspin schema --page`. [File formats](crate::guide::formats) has \
         examples and meaning.\n",
    );
    for kind in SchemaKind::ALL {
        let schema = schema(kind);
        let title = schema["description"].as_str().unwrap_or_default();
        text.push_str(&format!("\n## {}\n\n{title}\n", capital(kind.name())));
        object(&schema, "", &mut text);
    }
    text
}

fn capital(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |c| c.to_uppercase().chain(letters).collect())
}

/// The table of the keys of an object, then those of the objects below it.
fn object(schema: &Value, path: &str, text: &mut String) {
    let Some(properties) = schema["properties"].as_object() else {
        return;
    };
    let place = if path.is_empty() { "the top" } else { path };
    let code = if path.is_empty() { "" } else { "`" };
    text.push_str(&format!(
        "\nAt {code}{place}{code}:\n\n| key | unit | if left out | plausible | possible | meaning \
         |\n|---|---|---|---|---|---|\n"
    ));
    let required = |key: &str| {
        let list = schema["required"].as_array();
        list.is_some_and(|l| l.iter().any(|v| v == key))
    };
    let mut deeper: Vec<(String, &Value)> = vec![];
    for (key, value) in properties {
        let (entry, suffix) = inner(value);
        let name = format!("{key}{suffix}");
        text.push_str(&row(&name, value, entry, required(key)));
        let choices = entry["oneOf"].as_array();
        let has_keys = choices.is_some_and(|all| all.iter().any(|one| one.get("properties").is_some()));
        if entry.get("properties").is_some() || has_keys {
            let below = if path.is_empty() { name } else { format!("{path}.{name}") };
            deeper.push((below, entry));
        }
    }
    for (below, entry) in deeper {
        match entry["oneOf"].as_array() {
            Some(alternatives) => effects(alternatives, &below, text),
            None => object(entry, &below, text),
        }
    }
}

/// What a list or a mapping of names holds, with the suffix of its path.
fn inner(value: &Value) -> (&Value, &'static str) {
    if let Some(items) = value.get("items") {
        return (items, "[]");
    }
    match value.get("additionalProperties") {
        Some(named) if named.is_object() => (named, ".*"),
        _ => (value, ""),
    }
}

fn row(name: &str, value: &Value, entry: &Value, required: bool) -> String {
    let range = |low: Option<f64>, high: Option<f64>| match (low, high) {
        (Some(a), Some(b)) => format!("{} to {}", short(a), short(b)),
        (Some(a), None) => format!("from {}", short(a)),
        _ => String::new(),
    };
    let plausible = entry["x-plausible"].as_array();
    let plausible = plausible.map_or(String::new(), |p| range(p[0].as_f64(), p[1].as_f64()));
    let possible = match entry.get("x-plausible") {
        Some(_) => range(entry["minimum"].as_f64(), entry["maximum"].as_f64()),
        None => String::new(),
    };
    let absent = match (required, value.get("default")) {
        (true, _) => "required".to_owned(),
        (false, Some(Value::Number(n))) => n.as_f64().map_or(String::new(), short),
        (false, Some(Value::Bool(b))) => b.to_string(),
        (false, _) => "none".to_owned(),
    };
    let unit = entry["x-unit"].as_str().unwrap_or_default();
    let words = value["description"].as_str().unwrap_or_default().replace('\n', " ");
    format!("| `{name}` | {unit} | {absent} | {plausible} | {possible} | {words} |\n")
}

fn effects(alternatives: &[Value], path: &str, text: &mut String) {
    text.push_str(&format!("\nAt `{path}`, all of them required:\n\n| `effect` | its other keys |\n|---|---|\n"));
    let empty = Map::new();
    for entry in alternatives {
        let keys = entry["properties"].as_object().unwrap_or(&empty).keys();
        let keys: Vec<String> = keys.skip(1).map(|k| format!("`{k}`")).collect();
        let name = entry["title"].as_str().unwrap_or_default();
        text.push_str(&format!("| `{name}` | {} |\n", keys.join(", ")));
    }
}

/// A number as people write it.
fn short(x: f64) -> String {
    let size = x.abs();
    if size == 0.0 || (1e-3..1e5).contains(&size) { format!("{x}") } else { format!("{x:e}") }
}
