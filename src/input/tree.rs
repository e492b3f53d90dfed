//! A text as a tree of values that bears with keys that stand twice, and the line of a key in it: the parsers tell
//! positions with their errors only, so that one is made at the key.

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_yaml::{Mapping, Value};
use std::cell::{Cell, RefCell};
use std::fmt;

pub(super) struct LenientTree {
    pub(super) value: Value,
    /// Paths of keys that stand in it before; the first counts.
    pub(super) repeated: Vec<String>,
    pub(super) is_json: bool,
}

/// The values of a text; none for what is neither YAML nor JSON.
pub(super) fn lenient_tree(text: &str) -> Option<LenientTree> {
    let walk = Walk::default();
    let value = walk.root().deserialize(&mut serde_json::Deserializer::from_str(text)).ok();
    let is_json = value.is_some();
    let value = value.or_else(|| {
        walk.repeated.borrow_mut().clear();
        walk.root().deserialize(serde_yaml::Deserializer::from_str(text)).ok()
    })?;
    Some(LenientTree { value, repeated: walk.repeated.into_inner(), is_json })
}

/// Line, from 1, of a key in YAML or JSON; of the nearest key above it where the file does not have it. `repeat` counts
/// how often the key came before.
pub(super) fn key_line(text: &str, path: &str, repeat: usize) -> Option<usize> {
    let mut sought = path;
    while !sought.is_empty() {
        let walk = || Walk { sought, repeat: Cell::new(repeat), ..Walk::default() };
        let (json, yaml) = (walk(), walk());
        let error = json.root().deserialize(&mut serde_json::Deserializer::from_str(text)).err();
        if json.is_found.get() {
            return error.map(|error| error.line());
        }
        let error = yaml.root().deserialize(serde_yaml::Deserializer::from_str(text)).err();
        if yaml.is_found.get() {
            return error.and_then(|error| error.location()).map(|place| place.line());
        }
        sought = &sought[..sought.rfind(['.', '['])?];
    }
    None
}

/// A walk through a text: to its end, or to the key that is sought.
#[derive(Default)]
struct Walk<'a> {
    /// Path of a key; empty for none. What does not lead there is skipped.
    sought: &'a str,
    /// How often that key still has to come before.
    repeat: Cell<usize>,
    is_found: Cell<bool>,
    repeated: RefCell<Vec<String>>,
}

impl Walk<'_> {
    fn root(&self) -> Tree<'_> {
        Tree { path: String::new(), walk: self }
    }

    fn stop<E: Error>(&self) -> E {
        self.is_found.set(true);
        E::custom("found")
    }
}

/// A value at a path.
#[derive(Clone)]
struct Tree<'a> {
    path: String,
    walk: &'a Walk<'a>,
}

impl Tree<'_> {
    fn below(&self, key: &str) -> Self {
        let path = if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) };
        Self { path, walk: self.walk }
    }

    fn entry(&self, number: usize) -> Self {
        Self { path: format!("{}[{number}]", self.path), walk: self.walk }
    }

    fn leads_on(&self) -> bool {
        self.walk.sought.is_empty() || self.walk.sought.starts_with(&self.path)
    }

    fn is_sought(&self) -> bool {
        !self.path.is_empty() && self.path == self.walk.sought
    }

    /// The value unless it is what is sought: a key is found before its value, an entry of a list here.
    fn pass<E: Error>(&self, value: impl Into<Value>) -> Result<Value, E> {
        if self.is_sought() { Err(self.walk.stop()) } else { Ok(value.into()) }
    }
}

impl<'de> DeserializeSeed<'de> for Tree<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Tree<'_> {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        self.pass(Value::Null)?;
        let mut entries = Mapping::new();
        while let Some((key, below)) = map.next_key_seed(TreeKey(&self))? {
            if !below.leads_on() || below.is_sought() {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let (path, value) = (below.path.clone(), map.next_value_seed(below)?);
            let key = Value::from(key);
            if entries.contains_key(&key) {
                self.walk.repeated.borrow_mut().push(path);
            } else {
                entries.insert(key, value);
            }
        }
        Ok(Value::Mapping(entries))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        self.pass(Value::Null)?;
        let mut entries = vec![];
        loop {
            let entry = self.entry(entries.len());
            let read = if entry.leads_on() {
                list.next_element_seed(entry)?
            } else {
                list.next_element::<IgnoredAny>()?.map(|_| Value::Null)
            };
            match read {
                Some(value) => entries.push(value),
                None => return Ok(Value::Sequence(entries)),
            }
        }
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Value, E> {
        self.pass(value)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Value, E> {
        self.pass(value)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Value, E> {
        self.pass(value)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        self.pass(value)
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Value, E> {
        self.pass(value)
    }

    fn visit_unit<E: Error>(self) -> Result<Value, E> {
        self.pass(Value::Null)
    }
}

/// A key of a mapping, with the place of its value.
struct TreeKey<'a>(&'a Tree<'a>);

impl<'de, 'a> DeserializeSeed<'de> for TreeKey<'a> {
    type Value = (String, Tree<'a>);

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl<'de, 'a> Visitor<'de> for TreeKey<'a> {
    type Value = (String, Tree<'a>);

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a string")
    }

    fn visit_str<E: Error>(self, key: &str) -> Result<Self::Value, E> {
        let Self(holder) = self;
        let (below, walk) = (holder.below(key), holder.walk);
        if below.is_sought() {
            match walk.repeat.get() {
                0 => return Err(walk.stop()),
                before => walk.repeat.set(before - 1),
            }
        }
        Ok((key.to_owned(), below))
    }
}
