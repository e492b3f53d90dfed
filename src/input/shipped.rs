//! Files that come with the program, by name, and how a path or a name becomes text.

use super::error::{InputError, nearest};
use super::file::{self, SizeLimit};
use std::path::Path;

/// What some editors write in front of UTF-8 text.
pub(crate) const BYTE_ORDER_MARK: char = '\u{feff}';

/// A shipped file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shipped {
    /// Name on the command line.
    pub name: &'static str,
    /// Contents.
    pub text: &'static str,
}

macro_rules! shipped {
    ($($name:literal => $path:literal),* $(,)?) => {
        &[$(Shipped { name: $name, text: include_str!(concat!("../../", $path)) }),*]
    };
}

/// Spindles.
pub const SPINDLES: &[Shipped] = shipped!["reference" => "spindles/reference.yaml"];
/// Tools.
pub const TOOLS: &[Shipped] = shipped![
    "drill-8" => "spindles/tools/drill-8.yaml",
    "endmill-10" => "spindles/tools/endmill-10.yaml",
    "endmill-12-long" => "spindles/tools/endmill-12-long.yaml",
    "endmill-16" => "spindles/tools/endmill-16.yaml",
    "endmill-20-short" => "spindles/tools/endmill-20-short.yaml",
    "endmill-6" => "spindles/tools/endmill-6.yaml",
    "facemill-40" => "spindles/tools/facemill-40.yaml",
    "long-reach-8" => "spindles/tools/long-reach-8.yaml",
    "paper-tool" => "spindles/tools/paper-tool.yaml",
    "test-arbor" => "spindles/tools/test-arbor.yaml",
];
/// Weights.
pub const WEIGHTS: &[Shipped] = shipped![
    "benchmark" => "weights/benchmark.yaml",
    "machine" => "weights/machine.yaml",
    "quiet-idle" => "weights/quiet-idle.yaml",
    "stiff-tool" => "weights/stiff-tool.yaml",
    "uncertain-hardware" => "weights/uncertain-hardware.yaml",
    "chatter-band" => "weights/chatter-band.yaml",
];
/// Published frequencies.
pub const FREQUENCIES: &[Shipped] = shipped!["paper-frequencies" => "spindles/paper-frequencies.yaml"];

/// The text of a file that is given by path or by shipped name. A file that exists wins over a name.
///
/// # Errors
/// [`InputError`] when there is neither, or the file is not readable text.
pub fn text(source: &str, what: &str, shipped: &[Shipped]) -> Result<String, InputError> {
    text_within(source, what, shipped, file::KEYS)
}

/// As [`text`], of a file with another limit.
pub(super) fn text_within(
    source: &str,
    what: &str,
    shipped: &[Shipped],
    limit: SizeLimit,
) -> Result<String, InputError> {
    let path = Path::new(source);
    if path.is_dir() || !path.exists() {
        if let Some(found) = shipped.iter().find(|s| s.name == source) {
            return Ok(found.text.to_owned());
        }
        let names: Vec<&str> = shipped.iter().map(|s| s.name).collect();
        let near = nearest(source, names.iter().copied()).unwrap_or_default();
        let rule = if path.is_dir() {
            format!("is a folder, not a {what} file")
        } else {
            format!("there is no such {what} file")
        };
        let hint = if names.is_empty() {
            "check the path".to_owned()
        } else {
            format!("check the path, or take a shipped {what}: {} (nearest: {near})", names.join(", "))
        };
        return Err(InputError::new(source, rule).with_hint(hint));
    }
    utf8(source, file::read(path, limit).map_err(|error| error.of(source))?)
}

/// The text of bytes, without the byte order mark that some editors write.
///
/// # Errors
/// [`InputError`] with the line that is not UTF-8.
pub fn utf8(file: &str, bytes: Vec<u8>) -> Result<String, InputError> {
    let text = String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..good].iter().filter(|b| **b == b'\n').count() + 1;
        not_utf8(file, line, error.as_bytes())
    })?;
    Ok(match text.strip_prefix(BYTE_ORDER_MARK) {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}

/// The error about a line that is not UTF-8 in a text that begins with these bytes.
pub(super) fn not_utf8(file: &str, line: usize, beginning: &[u8]) -> InputError {
    let is_utf16 = beginning.starts_with(&[0xff, 0xfe]) || beginning.starts_with(&[0xfe, 0xff]);
    let mut told = InputError::new(file, if is_utf16 { "is UTF-16 text" } else { "is not UTF-8 text" });
    told.line = Some(line);
    told.with_hint("save the file as UTF-8")
}
