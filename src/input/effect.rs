//! One effect of a spindle file (formats.md, section 6): its keys are those that the table of effects has.

use super::InputError;
use super::error::nearest;
use crate::spindle::effects::entry::Entry;
use crate::spindle::effects::{AXIS_NAMES, LocationKind, table::TABLE};
use crate::spindle::{Bearings, Effect, EffectKind, Location, Plane, SpindleError};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Every key that some effect has.
static KEYS: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let mut keys = vec!["effect"];
    let of_entry = TABLE.iter().flat_map(|entry| {
        let names = entry.parameters.iter().map(|p| p.name);
        let axis = entry.one_axis.then_some("axis");
        entry.location.keys().iter().copied().chain(axis).chain(names)
    });
    for key in of_entry {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys
});

/// The keys of an effect as the file has them.
#[derive(Default)]
pub(super) struct EffectFile {
    effect: String,
    bearing: Option<String>,
    axis: Option<String>,
    from: Option<String>,
    to: Option<String>,
    region: Option<String>,
    mode: Option<usize>,
    /// Position and parameters.
    numbers: BTreeMap<String, f64>,
}

impl<'de> Deserialize<'de> for EffectFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Keys)
    }
}

impl JsonSchema for EffectFile {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Effect".into()
    }

    /// One alternative for every entry of the table of effects: its place and its parameters, nothing else.
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let whole = TABLE.iter().map(|entry| of_entry(entry, false));
        let single = TABLE.iter().filter(|entry| entry.one_axis);
        let single = single.map(|entry| of_entry(entry, true));
        let alternatives: Vec<Schema> = whole.chain(single).collect();
        json_schema!({ "oneOf": alternatives })
    }
}

fn of_entry(entry: &Entry, one_axis: bool) -> Schema {
    let mut properties = serde_json::Map::new();
    properties.insert("effect".into(), serde_json::json!({ "const": entry.name }));
    let place = match entry.location {
        LocationKind::None => None,
        LocationKind::Bearing => Some(serde_json::json!({ "enum": ["front", "rear", "both"] })),
        LocationKind::Across => Some(serde_json::json!({ "enum": AXIS_NAMES })),
        LocationKind::Position => Some(serde_json::json!({ "type": "number" })),
        LocationKind::Mode => Some(serde_json::json!({ "type": "integer", "minimum": 1 })),
        LocationKind::Region => Some(serde_json::json!({ "type": "string" })),
    };
    let in_plane = one_axis && entry.location == LocationKind::Position;
    if in_plane {
        let names = Plane::ALL.map(Plane::name);
        properties.insert("axis".into(), serde_json::json!({ "enum": names }));
    } else if one_axis {
        properties.insert("axis".into(), serde_json::json!({ "enum": AXIS_NAMES }));
    }
    if let Some(place) = place.filter(|_| in_plane || !one_axis) {
        properties.extend(entry.location.keys().iter().map(|key| ((*key).into(), place.clone())));
    }
    for parameter in entry.parameters {
        let kind = if parameter.positive {
            serde_json::json!({ "type": "number", "minimum": 0 })
        } else {
            serde_json::json!({ "type": "number" })
        };
        properties.insert(parameter.name.into(), kind);
    }
    let required: Vec<&String> = properties.keys().collect();
    json_schema!({
        "title": entry.name,
        "type": "object",
        "required": required,
        "properties": properties.clone(),
        "additionalProperties": false,
    })
}

struct Keys;

impl<'de> Visitor<'de> for Keys {
    type Value = EffectFile;

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("an effect: {effect: name, its place, its parameters}")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<EffectFile, A::Error> {
        let mut read = EffectFile::default();
        let mut seen: Vec<&'static str> = vec![];
        while let Some(key) = map.next_key::<String>()? {
            let Some(known) = KEYS.iter().find(|known| **known == key) else {
                return Err(A::Error::unknown_field(&key, &KEYS));
            };
            if seen.contains(known) {
                return Err(A::Error::duplicate_field(known));
            }
            seen.push(known);
            match *known {
                "effect" => read.effect = map.next_value()?,
                "bearing" => read.bearing = map.next_value()?,
                "axis" => read.axis = map.next_value()?,
                "from" => read.from = map.next_value()?,
                "to" => read.to = map.next_value()?,
                "region" => read.region = map.next_value()?,
                "mode" => read.mode = map.next_value()?,
                _ => {
                    if let Some(value) = map.next_value::<Option<f64>>()? {
                        read.numbers.insert(key, value);
                    }
                }
            }
        }
        if !seen.contains(&"effect") {
            return Err(A::Error::missing_field("effect"));
        }
        Ok(read)
    }
}

impl EffectFile {
    /// The effect of entry `index` of the list.
    pub(super) fn effect(self, file: &str, index: usize) -> Result<Effect, InputError> {
        let path = format!("effects[{index}]");
        let Some(kind) = EffectKind::from_name(&self.effect) else {
            let known = EffectKind::all().map(EffectKind::name);
            let best = nearest(&self.effect, known).unwrap_or_default();
            let rule = format!("{path}.effect: {:?} is not in the catalogue", self.effect);
            return Err(InputError::new(file, rule).with_hint(format!("did you mean `{best}`?")));
        };
        let names = kind.parameters().iter().map(|p| p.name);
        let one_axis = kind.entry().one_axis && self.axis.is_some();
        let in_plane = kind.location() == LocationKind::Position;
        let place = kind.location().keys().iter().copied().filter(|_| in_plane || !one_axis);
        let axis = one_axis.then_some("axis");
        let takes: Vec<&str> = place.chain(axis).chain(names).collect();
        let mut allowed = format!("{} takes {}", kind.name(), takes.join(", "));
        if kind.entry().one_axis {
            allowed += match kind.location() {
                LocationKind::Position => "; where it acts in one plane only, axis: x or y stands beside position_m",
                LocationKind::None => "; where one axis differs, axis names it",
                _ => "; where one axis differs, axis stands in place of bearing",
            };
        }
        let fail = |rule: String| InputError::new(file, rule).with_hint(allowed.clone());
        let present = self.present();
        // A foreign key explains a missing one, so it is named first.
        if let Some(key) = present.iter().find(|key| !takes.contains(key)) {
            let rule = format!("{path}.{key}: does not belong to {}", kind.name());
            return Err(fail(rule));
        }
        if let Some(key) = takes.iter().find(|key| !present.contains(key)) {
            return Err(fail(format!("{path}.{key}: is missing")));
        }
        let axis_of = |key: &str, name: &Option<String>| {
            let name = name.clone().unwrap_or_default();
            let axis = AXIS_NAMES.iter().position(|known| *known == name);
            let rule = format!("{path}.{key}: {name:?} must be {}", AXIS_NAMES.join(", "));
            axis.ok_or_else(|| fail(rule))
        };
        let location = if one_axis && in_plane {
            let name = self.axis.clone().unwrap_or_default();
            let rule = format!("{path}.axis: {name:?} must be x or y");
            let plane = Plane::from_name(&name).ok_or_else(|| fail(rule))?;
            let position_m = self.numbers.get("position_m").copied();
            Location::InPlane(position_m.unwrap_or_default(), plane)
        } else if one_axis {
            Location::Axis(axis_of("axis", &self.axis)?)
        } else if kind.location() == LocationKind::Across {
            Location::Across { from: axis_of("from", &self.from)?, to: axis_of("to", &self.to)? }
        } else {
            self.location(kind.location()).ok_or_else(|| {
                let name = self.bearing.clone().unwrap_or_default();
                fail(format!("{path}.bearing: {name:?} must be front, rear or both"))
            })?
        };
        let value = |name: &str| self.numbers.get(name).copied().unwrap_or_default();
        let values = kind.parameters().iter().map(|p| value(p.name)).collect();
        Effect::new(kind, location, values).map_err(|error| {
            let error = match error {
                SpindleError::Value { path: key, value, rule } => {
                    SpindleError::Value { path: format!("{path}.{key}"), value, rule }
                }
                other => other,
            };
            InputError::rule(file, &error)
        })
    }

    fn present(&self) -> Vec<&str> {
        let mut present: Vec<&str> = self.numbers.keys().map(String::as_str).collect();
        let places = [
            ("bearing", self.bearing.is_some()),
            ("axis", self.axis.is_some()),
            ("from", self.from.is_some()),
            ("to", self.to.is_some()),
            ("mode", self.mode.is_some()),
            ("region", self.region.is_some()),
        ];
        present.extend(places.into_iter().filter(|p| p.1).map(|p| p.0));
        present
    }

    /// The location, complete keys provided; none for a bearing of another name.
    fn location(&self, kind: LocationKind) -> Option<Location> {
        let text = |key: &Option<String>| key.clone().unwrap_or_default();
        Some(match kind {
            LocationKind::None => Location::None,
            LocationKind::Bearing => Location::Bearing(Bearings::from_name(&text(&self.bearing))?),
            // Read above, where a name that is no axis has its own sentence.
            LocationKind::Across => return None,
            LocationKind::Position => Location::Position(self.numbers.get("position_m").copied().unwrap_or_default()),
            LocationKind::Mode => Location::Mode(self.mode.unwrap_or_default()),
            LocationKind::Region => Location::Region(text(&self.region)),
        })
    }
}
