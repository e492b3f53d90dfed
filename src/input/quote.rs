//! Foreign text in messages: what controls a terminal or turns the order of letters is written out, and what is quoted
//! is short.

use std::borrow::Cow;

/// Longest quotation, characters.
const LONGEST_QUOTE: usize = 60;
/// Longest word outside of quotation marks, characters: file systems take paths of 4096 bytes.
const LONGEST_WORD: usize = 4096;
/// Longest message, characters.
const LONGEST_TEXT: usize = 8000;

/// Whether a character acts on the text around it: controls, separators of lines, and marks of direction (Unicode
/// Standard Annex 9), which let a text read other than it is.
fn acts(c: char) -> bool {
    c.is_control() || is_direction_mark(c) || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}')
}

/// Whether a character changes the direction in which others are read.
pub(crate) fn is_direction_mark(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A text of one line with such characters written out, as `\u{1b}`.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    written_out(text, acts)
}

/// A text in which marks of direction are written out.
pub(crate) fn without_direction_marks(text: &str) -> Cow<'_, str> {
    written_out(text, is_direction_mark)
}

/// A text of several lines with such characters written out.
pub(crate) fn printable_lines(text: &str) -> Cow<'_, str> {
    written_out(text, |c| c != '\n' && acts(c))
}

fn written_out(text: &str, is_meant: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.chars().any(&is_meant) {
        return Cow::Borrowed(text);
    }
    let mut out = String::new();
    for c in text.chars() {
        if is_meant(c) { out.extend(c.escape_default()) } else { out.push(c) }
    }
    Cow::Owned(out)
}

/// A message as it is shown: printable, what stands in quotation marks or backticks cut to sixty characters.
pub(crate) fn excerpt(message: &str) -> String {
    let text = printable_lines(message);
    let mut out = String::new();
    let mut rest = &*text;
    while let Some(begin) = rest.find(['"', '`']) {
        let mark = if rest[begin..].starts_with('"') { '"' } else { '`' };
        push_words(&mut out, &rest[..begin]);
        rest = &rest[begin + 1..];
        let (inside, behind) = match closing(rest, mark) {
            Some(end) => (&rest[..end], &rest[end + 1..]),
            // A mark that nothing closes: the rest may be a quotation that holds such marks itself.
            None => (rest, ""),
        };
        out.push(mark);
        out.push_str(&shorten_text(inside, LONGEST_QUOTE));
        if inside.len() < rest.len() {
            out.push(mark);
        }
        rest = behind;
    }
    push_words(&mut out, rest);
    shorten_text(&out, LONGEST_TEXT).into_owned()
}

/// Where a quotation ends; `\"` does not end it.
fn closing(text: &str, mark: char) -> Option<usize> {
    let mut escaped = false;
    text.char_indices().find_map(|(k, c)| {
        let ends = c == mark && !escaped;
        escaped = c == '\\' && !escaped;
        ends.then_some(k)
    })
}

/// Adds text outside of quotations, overlong words cut.
fn push_words(out: &mut String, text: &str) {
    for word in text.split_inclusive([' ', '\n']) {
        out.push_str(&shorten_text(word, LONGEST_WORD));
    }
}

/// At most so many characters, the last of a longer text an ellipsis.
fn shorten_text(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        None => Cow::Borrowed(text),
        Some(_) => {
            let end = text.char_indices().nth(most - 1).map_or(0, |(k, _)| k);
            Cow::Owned(format!("{}…", &text[..end]))
        }
    }
}
