//! Which pictures of a results folder stand in its page: those that muspin wrote, as it wrote them.
//!
//! A folder may come from somebody else. A picture is taken when it is a file and no link, the manifest lists it with
//! its hash, and it consists of nothing but the elements of muspin's own pictures.

use super::manifest::Manifest;
use super::plot::animation::REDUCED_MOTION;
use crate::input::file;
use std::collections::BTreeSet;
use std::io;
use std::path::Path;

/// Elements of muspin's pictures.
const ELEMENTS: [&str; 12] =
    ["svg", "title", "desc", "metadata", "style", "g", "rect", "circle", "polygon", "polyline", "text", "animate"];
const ATTRIBUTES: [&str; 34] = [
    "xmlns",
    "role",
    "width",
    "height",
    "viewBox",
    "class",
    "x",
    "y",
    "cx",
    "cy",
    "r",
    "points",
    "fill",
    "opacity",
    "stroke",
    "stroke-width",
    "stroke-dasharray",
    "stroke-linecap",
    "stroke-linejoin",
    "text-anchor",
    "font-family",
    "font-size",
    "font-weight",
    "font-style",
    "transform",
    "dy",
    "dx",
    "fill-opacity",
    "stroke-opacity",
    "dominant-baseline",
    "attributeName",
    "dur",
    "repeatCount",
    "values",
];
/// Attributes that an animation may change.
const ANIMATED: [&str; 3] = ["points", "cx", "cy"];

#[derive(Debug, Default)]
pub(crate) struct Pictures {
    /// Stem and SVG of those for the page, in the order of their stems.
    pub taken: Vec<(String, String)>,
    /// Names of the files that are left out.
    pub left_out: Vec<String>,
}

/// The pictures in `plots/` of a results folder; none where there is no such folder.
pub(crate) fn pictures_of(folder: &Path) -> io::Result<Pictures> {
    let place = folder.join("plots");
    let mut found = Pictures::default();
    if !std::fs::symlink_metadata(&place).is_ok_and(|there| there.is_dir()) {
        return Ok(found);
    }
    let manifest = Manifest::read(folder)?;
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(&place)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.ends_with(".svg") {
            names.insert(name);
        }
    }
    for name in names {
        match picture(&manifest, &place, &name) {
            Some(svg) => found.taken.push((name.trim_end_matches(".svg").to_owned(), svg)),
            None => found.left_out.push(name),
        }
    }
    Ok(found)
}

/// A picture as muspin wrote it; none for any other file.
fn picture(manifest: &Manifest, place: &Path, name: &str) -> Option<String> {
    let listed = format!("plots/{name}");
    if !manifest.lists(&listed) {
        return None;
    }
    let bytes = file::read_unlinked(&place.join(name), file::RESULT).ok()?;
    let svg = manifest.wrote(&listed, &bytes).then(|| String::from_utf8(bytes).ok())??;
    is_own_kind(&svg).then_some(svg)
}

/// Whether an SVG has only elements and attributes of muspin's pictures: nothing that runs, leads elsewhere, or changes
/// the page around it.
fn is_own_kind(svg: &str) -> bool {
    let mut rest = svg;
    let mut open: Vec<&str> = vec![];
    while let Some(begin) = rest.find('<') {
        let Some(end) = rest[begin..].find('>').map(|k| begin + k) else {
            return false;
        };
        let tag = &rest[begin + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            if open.pop() != Some(name.trim_end()) {
                return false;
            }
            continue;
        }
        let (tag, is_whole) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
        let name = tag.split(char::is_whitespace).next().unwrap_or_default();
        let is_first = open.is_empty();
        if !ELEMENTS.contains(&name) || is_first != (name == "svg") || !has_own_attributes(&tag[name.len()..]) {
            return false;
        }
        if name == "style" && (is_whole || rest.split('<').next() != Some(REDUCED_MOTION)) {
            return false;
        }
        if !is_whole {
            open.push(name);
        }
        if open.is_empty() {
            return false;
        }
    }
    open.is_empty() && svg.trim_start().starts_with("<svg") && !rest.contains(['<', '>'])
}

/// Whether the text behind the name of an element is a list of known attributes with values in double quotes.
fn has_own_attributes(text: &str) -> bool {
    let mut rest = text.trim();
    while !rest.is_empty() {
        let Some((name, value)) = rest.split_once("=\"") else {
            return false;
        };
        let Some((value, behind)) = value.split_once('"') else {
            return false;
        };
        if !ATTRIBUTES.contains(&name.trim()) || value.contains(['<', '&']) {
            return false;
        }
        if name == "attributeName" && !ANIMATED.contains(&value) {
            return false;
        }
        rest = behind.trim_start();
    }
    true
}
