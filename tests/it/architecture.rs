//! The shape of the source, read from the source: one-way imports, one home a package, files of one concept.

use std::path::{Path, PathBuf};

/// Folders under `src/` in the order of the pipeline: each may use those before it.
const ORDER: [&str; 21] = [
    "guide",
    "linalg",
    "lti",
    "rotor",
    "spindle",
    "identify",
    "update",
    "augment",
    "robust",
    "controller",
    "pid",
    "predict",
    "diagnose",
    "pipeline",
    "input",
    "export",
    "report",
    "workflow",
    "prelude",
    "cli",
    "python",
];

/// Package as it is named in paths, and where it may be named.
const HOMES: [(&str, &[&str]); 14] = [
    ("faer", &["linalg/"]),
    ("nalgebra", &["linalg/", "rotor/element.rs", "rotor/tilt.rs"]),
    ("wide", &["linalg/lanes.rs"]),
    ("clarabel", &["robust/conic.rs"]),
    ("plotters", &["report/plot/"]),
    ("ab_glyph", &["report/plot/pdf.rs"]),
    ("pdf_writer", &["report/plot/pdf.rs"]),
    ("subsetter", &["report/plot/pdf.rs"]),
    ("serde_yaml", &["input/", "report/"]),
    ("serde", &["input/", "export/", "report/", "workflow/", "cli/", "spindle/", "augment/weights.rs"]),
    ("schemars", &["input/", "spindle/", "augment/weights.rs"]),
    ("pyo3", &["python/"]),
    ("numpy", &["python/"]),
    ("ndarray", &["identify/", "update/", "diagnose/", "input/", "lti/", "python/"]),
];

pub struct Source {
    /// Path below `src/`, with `/`.
    pub path: String,
    pub text: String,
}

impl Source {
    fn layer(&self) -> &str {
        let first = self.path.split('/').next().unwrap_or_default();
        first.strip_suffix(".rs").unwrap_or(first)
    }

    /// Numbered lines of code: comments and what stands in string literals taken out.
    pub fn code(&self) -> Vec<(usize, String)> {
        let bare = without_literals(&self.text);
        bare.lines().enumerate().map(|(k, line)| (k + 1, line.to_owned())).collect()
    }
}

/// The text with comments, string and character literals blanked, line ends kept.
fn without_literals(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut out = String::with_capacity(text.len());
    let mut k = 0;
    let at = |k: usize| chars.get(k).copied().unwrap_or('\0');
    let word = |c: char| c.is_alphanumeric() || c == '_';
    while k < chars.len() {
        let c = at(k);
        let raw_hashes = (c == 'r' && (k == 0 || !word(at(k - 1)) || at(k - 1) == 'b'))
            .then(|| (0..).take_while(|h| at(k + 1 + h) == '#').count())
            .filter(|h| at(k + 1 + h) == '"');
        if c == '/' && at(k + 1) == '/' {
            while k < chars.len() && at(k) != '\n' {
                k += 1;
            }
        } else if c == '/' && at(k + 1) == '*' {
            while k < chars.len() && !(at(k) == '*' && at(k + 1) == '/') {
                if at(k) == '\n' {
                    out.push('\n');
                }
                k += 1;
            }
            k += 2;
        } else if let Some(hashes) = raw_hashes {
            k += hashes + 2;
            while k < chars.len() && !(at(k) == '"' && (0..hashes).all(|h| at(k + 1 + h) == '#')) {
                if at(k) == '\n' {
                    out.push('\n');
                }
                k += 1;
            }
            k += hashes + 1;
        } else if c == '"' {
            k += 1;
            while k < chars.len() && at(k) != '"' {
                if at(k) == '\n' {
                    out.push('\n');
                }
                k += if at(k) == '\\' && at(k + 1) != '\n' { 2 } else { 1 };
            }
            k += 1;
        } else if c == '\'' && (at(k + 2) == '\'' || at(k + 1) == '\\') {
            // A character literal; a lifetime has no closing quote there.
            k += if at(k + 1) == '\\' { 3 } else { 2 };
            while k < chars.len() && at(k) != '\'' {
                k += 1;
            }
            k += 1;
        } else {
            out.push(c);
            k += 1;
        }
    }
    out
}

pub fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files: Vec<PathBuf> = Vec::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    let source = |path: &PathBuf| Source {
        path: path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/"),
        text: std::fs::read_to_string(path).unwrap(),
    };
    files.iter().map(source).collect()
}

/// Fails with all findings at once.
pub fn none(findings: Vec<String>, rule: &str) {
    assert!(findings.is_empty(), "{rule}:\n  {}", findings.join("\n  "));
}

/// True where `text` has `name` as a whole path segment followed by `::`, and not as a part of a longer path.
fn names_crate(line: &str, name: &str) -> bool {
    line.match_indices(name).any(|(start, _)| {
        let before = line[..start].chars().next_back();
        let after = &line[start + name.len()..];
        let starts = before.is_none_or(|c| !(c.is_alphanumeric() || c == '_' || c == ':' || c == '.'));
        let path = after.starts_with("::");
        let whole_use = line.trim_start().starts_with("use ") && (after.starts_with(';') || after.starts_with(" as "));
        starts && (path || whole_use)
    })
}

/// Layers named after `crate::`, alone or in a braced list, with their line.
fn imported_layers(source: &Source) -> Vec<(usize, String)> {
    let code = source.code();
    let joined: String = code.iter().map(|(_, l)| format!("{l}\n")).collect();
    let mut found = Vec::new();
    for (start, _) in joined.match_indices("crate::") {
        let line = joined[..start].matches('\n').count() + 1;
        let rest = &joined[start + "crate::".len()..];
        let word = |t: &str| t.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
        if let Some(list) = rest.strip_prefix('{') {
            let mut depth = 0i32;
            let mut item = String::new();
            for c in list.chars() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 0 => break,
                    '}' => depth -= 1,
                    ',' if depth == 0 => found.push((line, word(std::mem::take(&mut item).trim()))),
                    c if depth == 0 => item.push(c),
                    _ => {}
                }
            }
            found.push((line, word(item.trim())));
        } else {
            found.push((line, word(rest)));
        }
    }
    found
}

#[test]
fn imports_go_down_the_pipeline_only() {
    let place = |layer: &str| ORDER.iter().position(|l| *l == layer);
    let mut findings = Vec::new();
    for source in sources().iter().filter(|s| s.path != "lib.rs" && s.path != "main.rs") {
        let Some(own) = place(source.layer()) else {
            findings.push(format!("{}: '{}' has no place in the pipeline", source.path, source.layer()));
            continue;
        };
        for (line, layer) in imported_layers(source) {
            if place(&layer).is_some_and(|other| other > own) {
                findings.push(format!("{}:{line}: {} uses {layer}", source.path, source.layer()));
            }
        }
    }
    none(findings, "a folder may use the ones above it in the pipeline, never the reverse");
}

#[test]
fn prescribed_packages_stay_in_their_homes() {
    let mut findings = Vec::new();
    for source in sources() {
        for (package, homes) in HOMES {
            if homes.iter().any(|h| source.path.starts_with(h)) {
                continue;
            }
            for (line, code) in source.code() {
                if names_crate(&code, package) {
                    findings.push(format!("{}:{line}: {package}", source.path));
                }
            }
        }
    }
    none(findings, "a package is used only where it can be replaced");
}

#[test]
fn computation_neither_prints_nor_touches_files_clock_or_environment() {
    const FORBIDDEN: [&str; 10] = [
        "println!",
        "print!",
        "dbg!",
        "std::fs",
        "File::open",
        "std::env",
        "std::time",
        "SystemTime",
        "Instant::now",
        "std::process",
    ];
    let computing = ORDER.iter().position(|l| *l == "pipeline").unwrap();
    let mut findings = Vec::new();
    for source in sources().iter().filter(|s| ORDER[..=computing].contains(&s.layer())) {
        for (line, code) in source.code() {
            findings.extend(
                FORBIDDEN.iter().filter(|f| code.contains(**f)).map(|f| format!("{}:{line}: {f}", source.path)),
            );
        }
    }
    none(findings, "from linalg to pipeline there is no file, print, clock or environment");
}

#[test]
fn files_are_opened_for_reading_in_one_place() {
    const OPENING: [&str; 6] = ["fs::read(", "read_to_string(", "File::open", "OpenOptions", "fs::copy", "from_path("];
    let mut findings = Vec::new();
    for source in sources().iter().filter(|s| s.path != "input/file.rs") {
        for (line, code) in source.code() {
            let found = OPENING.iter().filter(|f| code.contains(**f));
            findings.extend(found.map(|f| format!("{}:{line}: {f}", source.path)));
        }
    }
    none(findings, "input/file.rs opens files: regular ones, of a bounded size");
}

#[test]
fn library_code_does_not_panic_on_purpose() {
    const FORBIDDEN: [&str; 5] = [".unwrap()", "panic!(", "todo!(", "unimplemented!(", ".expect(\"\")"];
    let mut findings = Vec::new();
    for source in sources() {
        let text: Vec<&str> = source.text.lines().collect();
        for (line, code) in source.code() {
            let empty_reason = text.get(line - 1).is_some_and(|t| t.contains(".expect(\"\")"));
            let found = FORBIDDEN.iter().filter(|f| code.contains(**f) || (f.contains("expect") && empty_reason));
            findings.extend(found.map(|f| format!("{}:{line}: {f}", source.path)));
        }
    }
    none(findings, "errors are values; an invariant is `expect(\"reason\")`");
}

#[test]
fn every_file_is_one_documented_concept() {
    const DRAWERS: [&str; 5] = ["utils", "util", "helpers", "common", "misc"];
    let mut findings = Vec::new();
    for source in sources() {
        let lines = source.text.lines().count();
        if lines > 500 {
            findings.push(format!("{}: {lines} lines, more than 500: two concepts", source.path));
        }
        let wide = source.text.lines().enumerate();
        let wide = wide.filter(|(_, line)| line.chars().count() > 120);
        findings.extend(wide.map(|(k, _)| format!("{}:{}: wider than 120", source.path, k + 1)));
        if !source.text.starts_with("//!") {
            findings.push(format!("{}: no //! header", source.path));
        }
        let segments = source.path.trim_end_matches(".rs").split('/');
        findings.extend(segments.filter(|s| DRAWERS.contains(s)).map(|s| format!("{}: a file named {s}", source.path)));
    }
    none(findings, "a file is one concept and says which");
}

#[test]
fn unsafe_code_is_in_one_folder() {
    let mut findings = Vec::new();
    for source in sources().iter().filter(|s| !s.path.starts_with("linalg/lapack/")) {
        for (line, code) in source.code() {
            if code.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|w| w == "unsafe") {
                findings.push(format!("{}:{line}", source.path));
            }
        }
    }
    none(findings, "unsafe code only in linalg/lapack");
}

#[test]
fn nobody_but_cli_and_main_uses_cli() {
    let users: Vec<String> = sources()
        .iter()
        .filter(|s| s.layer() != "cli" && s.path != "python/mod.rs" && s.path != "main.rs" && s.path != "lib.rs")
        .filter(|s| imported_layers(s).iter().any(|(_, layer)| layer == "cli"))
        .map(|s| s.path.clone())
        .collect();
    none(users, "the library does not know its commands; the Python package starts them in python/mod.rs");
}

#[test]
fn the_reader_of_sources_sees_code_and_only_code() {
    let text = "use crate::{lti::x, report::{a, cli}};\n// crate::cli in a comment\nlet s = \"crate::cli \\\" \"; let \
        c = '\"'; let r = r#\"a \" faer::x\"#;\nfaer::mat();\nfn f<'a>(x: &'a str) {}\n";
    let source = Source { path: "linalg/x.rs".to_owned(), text: text.to_owned() };
    let layers: Vec<(usize, String)> = imported_layers(&source);
    assert_eq!(layers, [(1, "lti".to_owned()), (1, "report".to_owned())]);
    let faer: Vec<usize> = source.code().iter().filter(|(_, l)| names_crate(l, "faer")).map(|(k, _)| *k).collect();
    assert_eq!(faer, [4]);
    assert!(!names_crate("crate::input::serde::x", "serde") && !names_crate("serde_json::x", "serde"));
    assert!(names_crate("use serde;", "serde") && names_crate("    <faer::Mat>::x", "faer"));
}
