//! `muspin report FOLDER`: rebuilds `report.html` of a results folder from its `summary.json` and `plots/*.svg`.

use super::console::{Console, Shown};
use super::{Failure, Outcome};
use crate::report::html;
use crate::report::results::ResultsFolder;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `muspin report`.
#[derive(clap::Args, Debug, Default)]
pub(super) struct Arguments {
    /// Results folder with summary.json and plots/
    folder: PathBuf,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let folder = &arguments.folder;
    let path = folder.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|e| {
        Failure::new(format!("{}: {e}", path.display()))
            .with_hint("give the folder of a finished run, such as results/reference")
    })?;
    let summary: serde_json::Value = serde_json::from_str(&text).map_err(|e| {
        Failure::new(format!("{}: line {}, column {}: {e}", path.display(), e.line(), e.column()))
            .with_hint("summary.json is written by muspin; run the command that made this folder again")
    })?;
    if !summary.is_object() {
        return Err(Failure::new(format!("{}: expected one JSON object", path.display()))
            .with_hint("summary.json is written by muspin; run the command that made this folder again"));
    }
    let pictures = pictures(&folder.join("plots"))?;
    let page = html::report(&summary, &pictures).map_err(|e| Failure::new(e.to_string()))?;
    let mut own = ResultsFolder::new();
    own.add("report.html", page)?;
    console.writing(|| own.write_into(folder))?;
    let page = folder.join("report.html").display().to_string();
    console.other(String::new, || json!({ "report": page }), || Shown::done("the page was rebuilt").file(&page))?;
    Ok(Outcome::Done)
}

/// All pictures of the folder, by stem, in their order; none if there is no such folder.
fn pictures(folder: &Path) -> Result<Vec<(String, String)>, Failure> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let failed = |path: &Path, e: std::io::Error| Failure::new(format!("{}: {e}", path.display()));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|e| failed(folder, e))? {
        let path = entry.map_err(|e| failed(folder, e))?.path();
        let stem = path.file_stem().and_then(|s| s.to_str()).map(str::to_owned);
        if let (Some(stem), Some("svg")) = (stem, path.extension().and_then(|e| e.to_str())) {
            found.push((stem, std::fs::read_to_string(&path).map_err(|e| failed(&path, e))?));
        }
    }
    found.sort();
    Ok(found)
}
