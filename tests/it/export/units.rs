//! Co-simulation units: their archive read by a reader of its own, their description as XML.

use muspin::export::fmu::{FmiVersion, FmuUnit, controller_unit, machine_unit};
use muspin::input::load_machine;
use muspin::predict::time::TimeSettings;
use std::collections::BTreeMap;

/// A file of an archive.
struct Entry {
    crc: u32,
    bytes: Vec<u8>,
}

fn number(bytes: &[u8], at: usize, length: usize) -> usize {
    bytes[at..at + length].iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte))
}

/// The entries of an archive by its directory, which stands at its end (APPNOTE 6.3, sections 4.3.12 and 4.3.16).
fn read_archive(archive: &[u8]) -> BTreeMap<String, Entry> {
    let end = archive.len() - 22;
    assert_eq!(archive[end..end + 4], *b"PK\x05\x06", "the end of the directory");
    let (count, size, start) =
        (number(archive, end + 10, 2), number(archive, end + 12, 4), number(archive, end + 16, 4));
    assert_eq!(start + size, end, "the directory reaches to its end");
    let (mut at, mut entries) = (start, BTreeMap::new());
    for _ in 0..count {
        assert_eq!(archive[at..at + 4], *b"PK\x01\x02", "an entry of the directory");
        let (length, name) = (number(archive, at + 24, 4), number(archive, at + 28, 2));
        let path = String::from_utf8(archive[at + 46..at + 46 + name].to_vec()).expect("a name");
        let local = number(archive, at + 42, 4);
        assert_eq!(archive[local..local + 4], *b"PK\x03\x04", "{path}: the file's own header");
        assert_eq!(archive[local + 4..local + 30], archive[at + 6..at + 32], "{path}: header and entry agree");
        let data = local + 30 + name;
        assert_eq!(archive[local + 30..data], *path.as_bytes(), "{path}: the name in its own header");
        let entry = Entry { crc: number(archive, at + 16, 4) as u32, bytes: archive[data..data + length].to_vec() };
        assert!(entries.insert(path, entry).is_none(), "a path stands once");
        at += 46 + name;
    }
    assert_eq!(at, end, "as many entries as the end says");
    entries
}

/// CRC-32 bit by bit (ISO-HDLC).
fn crc_32(bytes: &[u8]) -> u32 {
    !bytes
        .iter()
        .fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 * (crc & 1))))
}

/// Tags of an XML text with their attributes; panics where the text is not well-formed.
fn read_xml(text: &str) -> Vec<(String, BTreeMap<String, String>)> {
    let (mut open, mut tags) = (vec![], vec![]);
    let body = text.strip_prefix("<?xml version=\"1.0\" encoding=\"UTF-8\"?>").expect("a declaration");
    for piece in body.split('<').skip(1) {
        let (tag, between) = piece.split_once('>').expect("a tag is closed");
        assert_eq!(between.trim(), "", "no text between tags");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
            continue;
        }
        let (content, is_empty) = tag.strip_suffix('/').map_or((tag, false), |content| (content, true));
        let (name, mut rest) = content.split_once(' ').unwrap_or((content, ""));
        let mut attributes = BTreeMap::new();
        while !rest.trim().is_empty() {
            let (key, after) = rest.trim_start().split_once("=\"").expect("a value in quotes");
            let (value, after) = after.split_once('"').expect("a quote is closed");
            let entities =
                value.matches("&amp;").count() + value.matches("&lt;").count() + value.matches("&quot;").count();
            assert_eq!(value.matches('&').count(), entities, "{value}");
            assert!(attributes.insert(key.to_owned(), value.to_owned()).is_none(), "{key} stands once");
            rest = after;
        }
        if !is_empty {
            open.push(name.to_owned());
        }
        tags.push((name.to_owned(), attributes));
    }
    assert!(open.is_empty(), "{open:?} is not closed");
    tags
}

fn both_units() -> [FmuUnit; 2] {
    let c_files = ["controller.h", "controller.c", "self_test.c"].map(|name| (name.to_owned(), b"123456789".to_vec()));
    let machine = load_machine("reference", "paper-tool").expect("a shipped machine");
    let settings = TimeSettings::default();
    [
        controller_unit("a < b & \"c\"", &c_files, 5e-5),
        machine_unit(&machine, 0.0, &settings).expect("a unit of the machine"),
    ]
}

#[test]
fn an_archive_is_read_back_with_its_checksums() {
    assert_eq!(crc_32(b"123456789"), 0xCBF4_3926);
    for unit in both_units() {
        for version in FmiVersion::ALL {
            let binary = ("x86_64-linux", ".so", vec![0x7f; 70_000]);
            let entries = read_archive(&unit.archive(version, Some(binary)).expect("an archive"));
            for (path, entry) in &entries {
                assert_eq!(entry.crc, crc_32(&entry.bytes), "{path}");
            }
            for (name, bytes) in &unit.sources {
                assert_eq!(&entries[&format!("sources/{name}")].bytes, bytes, "{name}");
            }
            let folder = if version == FmiVersion::Two { "linux64" } else { "x86_64-linux" };
            assert_eq!(entries[&format!("binaries/{folder}/{}.so", unit.name)].bytes.len(), 70_000);
            assert!(unit.archive(version, None).is_some_and(|bytes| read_archive(&bytes).len() == entries.len() - 1));
        }
    }
    let [controller, _] = both_units();
    let entries = read_archive(&controller.archive(FmiVersion::Three, None).expect("an archive"));
    assert_eq!(entries["sources/controller.c"].crc, 0xCBF4_3926);
    assert!(!entries.contains_key("sources/self_test.c"), "what the unit does not need stays out");
}

#[test]
fn a_description_lists_each_variable_once_and_each_output_as_unknown() {
    let axes = ["front_x", "front_y", "rear_x", "rear_y"];
    for (unit, count) in both_units().into_iter().zip([1 + 4 + 4, 1 + 10 + 26]) {
        for version in FmiVersion::ALL {
            let entries = read_archive(&unit.archive(version, None).expect("an archive"));
            let text = String::from_utf8(entries["modelDescription.xml"].bytes.clone()).expect("UTF-8");
            let tags = read_xml(&text);
            let tag = if version == FmiVersion::Two { "ScalarVariable" } else { "Float64" };
            let variables: Vec<_> = tags.iter().filter(|(name, _)| name == tag).map(|(_, a)| a).collect();
            let names: std::collections::BTreeSet<&String> = variables.iter().map(|a| &a["name"]).collect();
            assert_eq!((variables.len(), names.len()), (count, count), "{text}");
            for (k, attributes) in variables.iter().enumerate() {
                assert_eq!(attributes["valueReference"], k.to_string());
            }
            let side = if unit.name == "muspin_machine" { "command" } else { "current" };
            assert!(axes.iter().all(|axis| names.contains(&format!("{side}_{axis}"))), "{names:?}");
            // Version 2.0 counts from one, 3.0 names the reference; the outputs stand last.
            let outputs = variables.iter().filter(|a| a["causality"] == "output").count();
            let (tag, key, first) = match version {
                FmiVersion::Two => ("Unknown", "index", count - outputs + 1),
                FmiVersion::Three => ("Output", "valueReference", count - outputs),
            };
            let listed: Vec<usize> =
                tags.iter().filter(|(name, _)| name == tag).map(|(_, a)| a[key].parse().unwrap()).collect();
            assert_eq!(listed[..outputs], *(first..first + outputs).collect::<Vec<_>>());
            let units: Vec<&String> = tags.iter().filter(|(name, _)| name == "Unit").map(|(_, a)| &a["name"]).collect();
            let used =
                tags.iter().filter(|(name, _)| name == "Real" || name == "Float64").filter_map(|(_, a)| a.get("unit"));
            used.for_each(|unit| assert!(units.contains(&unit), "{unit}"));
            let root = &tags[0].1;
            let (key, value) = if version == FmiVersion::Two { ("guid", "2.0") } else { ("instantiationToken", "3.0") };
            assert_eq!(root["fmiVersion"], value);
            let token = format!("\"{}\"", root[key]);
            assert!(unit.sources.iter().any(|(_, bytes)| String::from_utf8_lossy(bytes).contains(&token)));
            if version == FmiVersion::Three {
                let built = read_xml(&String::from_utf8_lossy(&entries["sources/buildDescription.xml"].bytes));
                let files = built.iter().filter(|(name, _)| name == "SourceFile").map(|(_, a)| a["name"].as_str());
                assert!(files.eq(unit.compiled()));
            }
        }
    }
}
