//! JSON text to values, of a bounded number: a value takes up to thirty times the bytes that it has in the text.

use serde::de::{DeserializeOwned, Error};

/// Most values of a text: four matrices of a thousand states have about a million numbers.
const MOST_VALUES: usize = 4_000_000;

/// The value that a text holds.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<T, serde_json::Error> {
    // Separators and brackets in strings count as well: no name has this many.
    let values = text.bytes().filter(|byte| matches!(byte, b',' | b'[' | b'{')).count();
    if values > MOST_VALUES {
        return Err(serde_json::Error::custom(format!("more than {MOST_VALUES} values, the most that are read")));
    }
    serde_json::from_str(text)
}
