//! JSON text to values, of a bounded number and size: a value takes up to thirty times the bytes that it has in the
//! text, and a key is copied into every message about it.

use serde::de::{DeserializeOwned, Error};

/// Most values of a text: four matrices of a thousand states have about a million numbers.
const MOST_VALUES: usize = 4_000_000;
/// Longest string of a text, bytes: a drawing that is stored in one has some hundred thousand.
const LONGEST_STRING: usize = 4_000_000;

/// The value that a text holds.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<T, serde_json::Error> {
    // Separators and brackets in strings count as well: no name has this many.
    let values = text.bytes().filter(|byte| matches!(byte, b',' | b'[' | b'{')).count();
    if values > MOST_VALUES {
        return Err(serde_json::Error::custom(format!("more than {MOST_VALUES} values, the most that are read")));
    }
    if longest_string(text) > LONGEST_STRING {
        return Err(serde_json::Error::custom(format!(
            "a string of more than {LONGEST_STRING} bytes, the most that is read"
        )));
    }
    serde_json::from_str(text)
}

/// Bytes of the longest string of a text.
fn longest_string(text: &str) -> usize {
    let (mut longest, mut begin, mut escaped) = (0, None, false);
    for (at, byte) in text.bytes().enumerate() {
        match (byte, begin) {
            _ if escaped => escaped = false,
            (b'\\', Some(_)) => escaped = true,
            (b'"', None) => begin = Some(at + 1),
            (b'"', Some(from)) => {
                longest = longest.max(at - from);
                begin = None;
            }
            _ => {}
        }
    }
    longest.max(begin.map_or(0, |from| text.len() - from))
}

#[cfg(test)]
mod tests {
    use super::longest_string;

    #[test]
    fn escaped_quotation_marks_end_no_string() {
        assert_eq!(longest_string(r#"{"a": "b\"cd", "e": [1, 2]}"#), 5);
        assert_eq!(longest_string(r#"["\\", "abc"#), 3);
    }
}
