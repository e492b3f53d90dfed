//! The line of a key in a file, from its path: the parsers tell positions with their errors only, so that one is made
//! at the key.

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::cell::Cell;
use std::fmt;

/// Line, from 1, of a key in YAML or JSON; of the nearest key above it where the file does not have it. `repeat` counts
/// how often the key came before.
pub(super) fn key_line(text: &str, path: &str, repeat: usize) -> Option<usize> {
    let mut path = path;
    while !path.is_empty() {
        let (json, yaml) = (KeySearchEnd::default(), KeySearchEnd::default());
        let error = json.search(path, repeat).deserialize(&mut serde_json::Deserializer::from_str(text)).err();
        if json.is_found.get() {
            return error.map(|error| error.line());
        }
        let error = yaml.search(path, repeat).deserialize(serde_yaml::Deserializer::from_str(text)).err();
        if yaml.is_found.get() {
            return error.and_then(|error| error.location()).map(|place| place.line());
        }
        path = &path[..path.rfind(['.', '['])?];
    }
    None
}

/// What a search has come to.
#[derive(Default)]
struct KeySearchEnd {
    /// How often the key still has to come before.
    repeat: Cell<usize>,
    is_found: Cell<bool>,
}

impl KeySearchEnd {
    fn search<'a>(&'a self, path: &'a str, repeat: usize) -> KeyRemainder<'a> {
        self.repeat.set(repeat);
        KeyRemainder { remaining: path, found: self }
    }
}

/// What is left of the path below a value.
#[derive(Clone, Copy)]
struct KeyRemainder<'a> {
    remaining: &'a str,
    found: &'a KeySearchEnd,
}

impl<'a> KeyRemainder<'a> {
    fn below(self, remaining: &'a str) -> Self {
        Self { remaining, ..self }
    }

    fn stop<E: Error>(self) -> E {
        self.found.is_found.set(true);
        E::custom("found")
    }
}

impl<'de> DeserializeSeed<'de> for KeyRemainder<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for KeyRemainder<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        if self.remaining.is_empty() {
            return Err(self.stop());
        }
        while let Some(rest) = map.next_key_seed(KeySearch(self))? {
            match rest {
                Some(rest) => map.next_value_seed(self.below(rest))?,
                None => map.next_value::<IgnoredAny>().map(drop)?,
            }
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let (index, rest) = match self.remaining.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            Some((digits, rest)) => (digits.parse().ok(), rest.strip_prefix('.').unwrap_or(rest)),
            None if self.remaining.is_empty() => return Err(self.stop()),
            None => (None, ""),
        };
        let mut number = 0usize;
        loop {
            let goes_on = if index == Some(number) {
                list.next_element_seed(self.below(rest))?
            } else {
                list.next_element::<IgnoredAny>()?.map(drop)
            };
            if goes_on.is_none() {
                return Ok(());
            }
            number += 1;
        }
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<(), E> {
        self.leaf()
    }

    fn visit_i64<E: Error>(self, _: i64) -> Result<(), E> {
        self.leaf()
    }

    fn visit_u64<E: Error>(self, _: u64) -> Result<(), E> {
        self.leaf()
    }

    fn visit_f64<E: Error>(self, _: f64) -> Result<(), E> {
        self.leaf()
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        self.leaf()
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.leaf()
    }
}

impl KeyRemainder<'_> {
    fn leaf<E: Error>(self) -> Result<(), E> {
        if self.remaining.is_empty() { Err(self.stop()) } else { Ok(()) }
    }
}

/// A key on the way: the path below it, or none when it leads elsewhere.
struct KeySearch<'a>(KeyRemainder<'a>);

impl<'de, 'a> DeserializeSeed<'de> for KeySearch<'a> {
    type Value = Option<&'a str>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl<'de, 'a> Visitor<'de> for KeySearch<'a> {
    type Value = Option<&'a str>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E: Error>(self, key: &str) -> Result<Self::Value, E> {
        let Self(search) = self;
        let Some(rest) = search.remaining.strip_prefix(key) else {
            return Ok(None);
        };
        if !rest.is_empty() {
            let below = rest.strip_prefix('.').or(rest.starts_with('[').then_some(rest));
            return Ok(below);
        }
        match search.found.repeat.get() {
            0 => Err(search.stop()),
            before => {
                search.found.repeat.set(before - 1);
                Ok(None)
            }
        }
    }
}
