//! The content policy of a page: its own script and styles by their hash, nothing from elsewhere.
//!
//! Source: W3C, Content Security Policy Level 3: a hash source is `'sha256-'` with the SHA-256 of the text of the
//! element in base 64.

use super::plot::animation::REDUCED_MOTION;
use sha2::{Digest, Sha256};

/// What the template has in the place of the policy.
const PLACE: &str = "CONTENT-POLICY";

pub(super) fn with_policy(page: &str) -> String {
    let styles = [text_between(page, "<style>", "</style>"), REDUCED_MOTION].map(hash_source).join(" ");
    let script = page.rfind("<script>").map_or("", |at| text_between(&page[at..], "<script>", "</script>"));
    let policy = format!(
        "default-src 'none'; style-src {styles}; img-src data:; script-src {}; base-uri 'none'; form-action 'none'",
        hash_source(script)
    );
    page.replacen(PLACE, &policy, 1)
}

fn text_between<'a>(page: &'a str, begin: &str, end: &str) -> &'a str {
    let rest = page.split_once(begin).map_or("", |(_, rest)| rest);
    rest.split_once(end).map_or("", |(text, _)| text)
}

fn hash_source(text: &str) -> String {
    format!("'sha256-{}'", base64(&Sha256::digest(text.as_bytes())))
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let byte = |k: usize| u32::from(three.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= three.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{base64, hash_source};

    #[test]
    fn hashes_are_written_as_browsers_compute_them() {
        // RFC 4648, section 10, and the SHA-256 of no byte (FIPS 180-4 examples).
        for (text, wanted) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(text.as_bytes()), wanted);
        }
        assert_eq!(hash_source(""), "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='");
    }
}
