//! `muspin report FOLDER`: rebuilds `report.html` of a results folder from its `summary.json` and `plots/*.svg`.

use super::Failure;
use super::console::{CommandEnd, Console};
use super::machine::say;
use crate::input::json::parse;
use crate::input::{Warning, file};
use crate::report::embedded_pictures::pictures_of;
use crate::report::html;
use crate::report::results::ResultsFolder;
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug, Default)]
pub(super) struct Arguments {
    /// Results folder with summary.json and plots/
    folder: PathBuf,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let folder = &arguments.folder;
    let path = folder.join("summary.json");
    let text = file::read_text(&path, file::RESULT).map_err(|error| {
        Failure::new(format!("{}: {error}", path.display()))
            .with_hint("give the folder of a finished run, such as results/reference")
    })?;
    let summary: serde_json::Value = parse(&text).map_err(|e| {
        Failure::new(format!("{}: line {}, column {}: {e}", path.display(), e.line(), e.column()))
            .with_hint("summary.json is written by muspin; run the command that made this folder again")
    })?;
    if !summary.is_object() {
        return Err(Failure::new(format!("{}: expected one JSON object", path.display()))
            .with_hint("summary.json is written by muspin; run the command that made this folder again"));
    }
    let pictures = pictures_of(folder).map_err(|e| Failure::new(format!("{}: {e}", folder.display())))?;
    if !pictures.left_out.is_empty() {
        say(&left_out(folder, &pictures.left_out));
    }
    let page = html::report(&summary, &pictures.taken).map_err(|e| Failure::new(e.to_string()))?;
    let mut own = ResultsFolder::new();
    own.add("report.html", page)?;
    console.writing(|| own.write_into(folder))?;
    let page = folder.join("report.html").display().to_string();
    Ok(CommandEnd::done("the page was rebuilt").data(String::new(), json!({ "report": page })).file(page))
}

/// What is said of the pictures that the page does not show.
fn left_out(folder: &Path, names: &[String]) -> Warning {
    const LISTED: usize = 20;
    let mut list = names.iter().take(LISTED).map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
    if names.len() > LISTED {
        list.push_str(&format!(" and {} more", names.len() - LISTED));
    }
    let message = format!("not in the page, because muspin did not write them or they were changed since: {list}");
    Warning { file: folder.join("plots").display().to_string(), message }
}
