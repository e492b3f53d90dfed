//! A text as a tree of values that bears with keys that stand twice.

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_yaml::{Mapping, Value};
use std::cell::RefCell;
use std::fmt;

pub(super) struct LenientTree {
    pub(super) value: Value,
    /// Paths of keys that stand in it before; the first counts.
    pub(super) repeated: Vec<String>,
    pub(super) is_json: bool,
}

/// The values of a text; none for what is neither YAML nor JSON.
pub(super) fn lenient_tree(text: &str) -> Option<LenientTree> {
    let repeated = RefCell::new(vec![]);
    let tree = || Tree { path: String::new(), repeated: &repeated };
    let value = tree().deserialize(&mut serde_json::Deserializer::from_str(text)).ok();
    let is_json = value.is_some();
    let value = value.or_else(|| {
        repeated.borrow_mut().clear();
        tree().deserialize(serde_yaml::Deserializer::from_str(text)).ok()
    })?;
    Some(LenientTree { value, repeated: repeated.into_inner(), is_json })
}

/// A value at a path.
struct Tree<'a> {
    path: String,
    repeated: &'a RefCell<Vec<String>>,
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
        let mut entries = Mapping::new();
        while let Some(key) = map.next_key::<String>()? {
            let path = if self.path.is_empty() { key.clone() } else { format!("{}.{key}", self.path) };
            let value = map.next_value_seed(Tree { path: path.clone(), repeated: self.repeated })?;
            let key = Value::from(key);
            if entries.contains_key(&key) {
                self.repeated.borrow_mut().push(path);
            } else {
                entries.insert(key, value);
            }
        }
        Ok(Value::Mapping(entries))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let mut entries = vec![];
        let seed = |number: usize| Tree { path: format!("{}[{number}]", self.path), repeated: self.repeated };
        while let Some(entry) = list.next_element_seed(seed(entries.len()))? {
            entries.push(entry);
        }
        Ok(Value::Sequence(entries))
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_unit<E: Error>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }
}
