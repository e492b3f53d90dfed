//! The manifest of an output folder: path and SHA-256 of every file that muspin wrote there.
//!
//! A file is replaced or removed only when the manifest lists it and its hash is still that of the list: whatever else
//! is in the folder belongs to the user. The manifest holds no clock, machine or user: same files, same bytes.

use crate::export::firmware::sha256_hex;
use crate::input::{file, json};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// Name of the manifest in its folder.
pub const MANIFEST: &str = "muspin-manifest.json";

/// Files that muspin wrote into a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// What this file is, for people who find it.
    #[serde(default)]
    about: String,
    /// Relative path with `/` → SHA-256 in hexadecimal digits.
    pub files: BTreeMap<String, String>,
    /// Hashes of the run before while its files are being replaced one by one; empty otherwise. A run that was
    /// interrupted leaves them here, so that the next one recognises the files of either.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub replacing: BTreeMap<String, String>,
}

impl Manifest {
    /// The manifest of files that are about to be written.
    pub fn of<'a>(files: impl Iterator<Item = (&'a str, &'a [u8])>) -> Self {
        Self {
            about: "files that muspin wrote here; a later run replaces these and nothing else".to_owned(),
            files: files.map(|(p, b)| (p.to_owned(), sha256_hex(b))).collect(),
            replacing: BTreeMap::new(),
        }
    }

    /// The manifest of a folder; an empty one where there is none.
    ///
    /// # Errors
    /// A file that cannot be read or is not a manifest, and paths in it that lead out of the folder.
    pub fn read(folder: &Path) -> io::Result<Self> {
        let text = match file::read_text(&folder.join(MANIFEST), file::RESULT) {
            Ok(text) => text,
            Err(error) if error.is_absence() => return Ok(Self::default()),
            Err(error) => return Err(error.into()),
        };
        let read: Self = json::parse(&text)?;
        let outside = read.paths().find(|path| !is_inside(path)).map(str::to_owned);
        match outside {
            None => Ok(read),
            Some(path) => Err(io::Error::other(format!("'{path}' is not a path inside the folder"))),
        }
    }

    /// The bytes of the file.
    pub fn to_json(&self) -> Vec<u8> {
        // A map of strings always has a JSON form.
        let mut text = serde_json::to_vec_pretty(self).unwrap_or_default();
        text.push(b'\n');
        text
    }

    /// Listed paths, each once, in their order.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        let both = self.files.keys().chain(self.replacing.keys());
        let once: std::collections::BTreeSet<&str> = both.map(String::as_str).collect();
        once.into_iter()
    }

    /// Whether the path is listed.
    pub fn lists(&self, path: &str) -> bool {
        self.files.contains_key(path) || self.replacing.contains_key(path)
    }

    /// Whether these bytes are what muspin wrote to the path.
    pub fn wrote(&self, path: &str, bytes: &[u8]) -> bool {
        let hash = Some(sha256_hex(bytes));
        self.files.get(path) == hash.as_ref() || self.replacing.get(path) == hash.as_ref()
    }
}

/// Whether a relative path with `/` stays inside its folder.
pub(crate) fn is_inside(path: &str) -> bool {
    let part_is_name = |part: &str| !part.is_empty() && part != "." && part != "..";
    !path.contains('\\') && path.split('/').all(part_is_name)
}
