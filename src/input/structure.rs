//! The keys and kinds of values of a file against the schema of its type: everything that does not fit, where the
//! reader stops at the first.

use super::error::{InputError, is_meant, nearest_key};
use super::error_list::ErrorList;
use super::tree::{LenientTree, key_line, lenient_tree};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value as Json, json};
use serde_yaml::{Mapping, Value};

/// Adds what does not fit a type to the errors of a file, and gives its tree with misspelt keys set right and unknown
/// ones left out. None for what is neither YAML nor JSON.
pub(super) fn check_structure<T: JsonSchema>(errors: &mut ErrorList<'_>) -> Option<Value> {
    // An empty file lacks every key.
    let text = if errors.text.trim().is_empty() { "{}" } else { errors.text };
    let LenientTree { mut value, repeated, is_json } = lenient_tree(text)?;
    if value.is_null() {
        value = Value::Mapping(Mapping::new());
    }
    let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    let schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    let mut walk = Walk { errors, is_json, missing: vec![] };
    walk.report_repeated(&repeated);
    walk.check("", &schema, &mut value);
    walk.report_missing();
    Some(value)
}

struct Walk<'e, 'a> {
    errors: &'e mut ErrorList<'a>,
    is_json: bool,
    /// Paths of required keys that are not there.
    missing: Vec<String>,
}

impl Walk<'_, '_> {
    fn add(&mut self, path: &str, message: &str) {
        let text = if path.is_empty() { message.to_owned() } else { format!("{path}: {message}") };
        self.errors.add(InputError::of_parser(self.errors.file, None, &text));
    }

    fn report_repeated(&mut self, repeated: &[String]) {
        for (number, path) in repeated.iter().enumerate() {
            let before = repeated[..number].iter().filter(|other| *other == path).count();
            let mut error = InputError::of_parser(self.errors.file, None, &format!("{path}: duplicate field"));
            error.line = key_line(self.errors.text, path, before + 1);
            self.errors.add(error);
        }
    }

    fn report_missing(&mut self) {
        match std::mem::take(&mut self.missing).as_slice() {
            [] => {}
            [one] => {
                let (path, name) = one.rsplit_once('.').unwrap_or(("", one));
                self.add(path, &format!("missing field `{name}`"));
            }
            several => {
                let message = format!("missing fields: {}", several.join(", "));
                let hint = "add the keys; spindles/ and weights/ hold complete files";
                self.errors.add(InputError::new(self.errors.file, message).with_hint(hint));
            }
        }
    }

    fn check(&mut self, path: &str, schema: &Json, value: &mut Value) {
        let alternatives = schema["anyOf"].as_array().or(schema["oneOf"].as_array());
        if let Some(alternatives) = alternatives {
            return self.check_alternatives(path, alternatives, value);
        }
        if let Some(names) = schema["enum"].as_array() {
            return self.check_name(path, &texts(names), value);
        }
        let kinds = match &schema["type"] {
            Json::Array(kinds) => texts(kinds),
            Json::String(kind) => vec![kind.as_str()],
            _ => return,
        };
        if value.is_null() && kinds.contains(&"null") {
            return;
        }
        if value.is_null() && kinds == ["object"] {
            *value = Value::Mapping(Mapping::new());
        }
        match (kinds.first().copied(), value) {
            (Some("object"), Value::Mapping(map)) => self.check_mapping(path, schema, map),
            (Some("array"), Value::Sequence(list)) => self.check_list(path, schema, list),
            (Some("number"), Value::Number(_)) | (Some("boolean"), Value::Bool(_)) => {}
            (Some("integer"), Value::Number(number)) if number.is_u64() => {}
            (Some("string"), Value::String(_)) => {}
            // A plain scalar of YAML is text as well.
            (Some("string"), value) if !self.is_json && !value.is_mapping() && !value.is_sequence() => {}
            (Some(kind), value) => {
                let is_number = kind == "integer" && value.is_number();
                let problem = if is_number { "value" } else { "type" };
                self.add(path, &format!("invalid {problem}: {}, expected {}", words(value), kind_words(kind)));
            }
            (None, _) => {}
        }
    }

    fn check_alternatives(&mut self, path: &str, alternatives: &[Json], value: &mut Value) {
        let is_null = |schema: &&Json| schema["type"] == "null";
        if value.is_null() && alternatives.iter().any(|schema| is_null(&schema)) {
            return;
        }
        let others: Vec<&Json> = alternatives.iter().filter(|schema| !is_null(schema)).collect();
        if let [only] = others.as_slice() {
            return self.check(path, only, value);
        }
        let names = texts(others.iter().map(|schema| &schema["const"]));
        if names.len() == others.len() {
            return self.check_name(path, &names, value);
        }
        if value.is_number() && others.iter().any(|schema| schema["type"] == "number") {
            return;
        }
        // Which of them is meant is for the reader to tell; the keys are those of all.
        let mut properties = Map::new();
        for (name, schema) in others.iter().filter_map(|schema| schema["properties"].as_object()).flatten() {
            let constant = schema.get("const").or(schema.get("enum")).is_some();
            let schema = if constant { json!({ "type": "string" }) } else { schema.clone() };
            properties.entry(name).or_insert(schema);
        }
        let union = json!({ "type": "object", "properties": properties, "additionalProperties": false });
        self.check(path, &union, value);
    }

    fn check_name(&mut self, path: &str, names: &[&str], value: &Value) {
        if !value.as_str().is_some_and(|name| names.contains(&name)) {
            self.add(path, &format!("{} is none of {}", words(value), names.join(", ")));
        }
    }

    fn check_list(&mut self, path: &str, schema: &Json, list: &mut [Value]) {
        let length = schema["minItems"].as_u64().filter(|least| schema["maxItems"].as_u64() == Some(*least));
        if let Some(length) = length.filter(|length| *length != list.len() as u64) {
            self.add(path, &format!("has {} entries, must have {length}", list.len()));
        }
        for (number, entry) in list.iter_mut().enumerate() {
            self.check(&format!("{path}[{number}]"), &schema["items"], entry);
        }
    }

    fn check_mapping(&mut self, path: &str, schema: &Json, map: &mut Mapping) {
        let none = Map::new();
        let properties = schema["properties"].as_object().unwrap_or(&none);
        let any = schema["additionalProperties"].as_object().map(|_| &schema["additionalProperties"]);
        if any.is_none() {
            self.correct_keys(path, properties, map);
        }
        let below = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        for name in texts(schema["required"].as_array().into_iter().flatten()) {
            if !map.contains_key(name) {
                self.missing.push(below(name));
            }
        }
        for (key, value) in map.iter_mut() {
            let name = key.as_str().unwrap_or_default();
            if let Some(schema) = properties.get(name).or(any) {
                self.check(&below(name), schema, value);
            }
        }
    }

    /// Reports the keys that a mapping does not have, and gives their values to those that they misspell.
    fn correct_keys(&mut self, path: &str, properties: &Map<String, Json>, map: &mut Mapping) {
        let known: Vec<&str> = properties.keys().map(String::as_str).collect();
        let foreign: Vec<Value> =
            map.keys().filter(|k| k.as_str().is_none_or(|k| !known.contains(&k))).cloned().collect();
        for key in foreign {
            let name = key.as_str().unwrap_or_default();
            let listed: Vec<String> = known.iter().map(|k| format!("`{k}`")).collect();
            let message = format!("unknown field `{name}`, expected one of {}", listed.join(", "));
            let text = if path.is_empty() { message } else { format!("{path}: {message}") };
            let mut error = InputError::of_parser(self.errors.file, None, &text);
            let at = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
            error.line = key_line(self.errors.text, &at, 0);
            self.errors.add(error);
            let value = map.remove(&key).unwrap_or_default();
            let meant = nearest_key(name, known.iter().copied());
            if let Some(meant) = meant.filter(|meant| is_meant(name, meant) && !map.contains_key(*meant)) {
                map.insert(meant.into(), value);
            }
        }
    }
}

fn texts<'j>(list: impl IntoIterator<Item = &'j Json>) -> Vec<&'j str> {
    list.into_iter().filter_map(Json::as_str).collect()
}

/// A value in the words of the parser.
fn words(value: &Value) -> String {
    match value {
        Value::Null => "unit value".to_owned(),
        Value::Bool(value) => format!("boolean `{value}`"),
        Value::Number(number) if number.is_f64() => format!("floating point `{number}`"),
        Value::Number(number) => format!("integer `{number}`"),
        Value::String(text) => format!("string {text:?}"),
        Value::Sequence(_) => "sequence".to_owned(),
        Value::Mapping(_) | Value::Tagged(_) => "map".to_owned(),
    }
}

fn kind_words(kind: &str) -> &'static str {
    match kind {
        "object" => "a mapping of keys to values",
        "array" => "a list",
        "number" => "a number",
        "integer" => "a whole number, zero or more",
        "boolean" => "true or false",
        _ => "text",
    }
}
