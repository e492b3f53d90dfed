//! Most entries of the lists of a file: a longer one is a mistake, and would take hours or all memory.

use super::error::InputError;
use serde_yaml::Value;

/// Most entries of lists and mappings that have no limit of their own: no machine has as many discs, no measurement as
/// many records.
const MOST: usize = 1000;
/// Most entries by key.
const MOST_OF_KEY: [(&str, usize); 6] = [
    // As many as a shaft may have.
    ("elements", 300),
    // Flexible modes: those above the tenth are beyond the band of any bearing.
    ("damping_ratio", 100),
    ("mode_uncertainty", 100),
    // A polynomial of double precision numbers has no roots to speak of beyond.
    ("numerator", 40),
    ("denominator", 40),
    ("resonances_hz", 200),
];

/// Refuses the first list that is too long.
pub(super) fn check_lists(file: &str, value: &Value) -> Result<(), InputError> {
    check_at(file, "", "", value)
}

fn check_at(file: &str, path: &str, key: &str, value: &Value) -> Result<(), InputError> {
    let own = MOST_OF_KEY.iter().find(|(name, _)| *name == key);
    let most = own.map_or(MOST, |(_, most)| *most);
    let refuse = |count: usize| {
        let place = if path.is_empty() { "the file" } else { path };
        Err(InputError::new(file, format!("{place}: has {count} entries; at most {most} are possible"))
            .with_hint("shorten the list; records belong into CSV files"))
    };
    match value {
        Value::Sequence(list) if list.len() > most => refuse(list.len()),
        Value::Mapping(map) if map.len() > most => refuse(map.len()),
        Value::Sequence(list) => {
            let mut entries = list.iter().enumerate();
            entries.try_for_each(|(k, entry)| check_at(file, &format!("{path}[{k}]"), key, entry))
        }
        Value::Mapping(map) => map.iter().try_for_each(|(name, entry)| {
            let name = name.as_str().unwrap_or("?");
            let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
            check_at(file, &path, name, entry)
        }),
        _ => Ok(()),
    }
}
