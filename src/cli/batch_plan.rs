//! A batch on many machines: one folder a variant with its files, a list of commands, a Slurm job array; and the rows
//! of the finished folders back together.

use super::Failure;
use super::batch_arguments::Arguments;
use super::batch_variants::Variant;
use super::console::{CommandEnd, Console};
use crate::input::file;
use crate::input::json::parse;
use crate::input::name::check_name;
use crate::input::shipped::{WEIGHTS, text};
use crate::input::{spindle_yaml, tool_yaml};
use crate::report::batch::{BatchRow, ROW_FILE};
use crate::report::results::ResultsFolder;
use crate::spindle::Machine;
use serde::Deserialize;
use serde_json::json;
use std::path::Path;

/// List of commands, one a line, to be run in the folder of the plan.
const COMMANDS: &str = "commands.txt";
/// Names of the variants, in the order of the commands.
const VARIANTS: &str = "variants.json";
/// Folder of the finished variants.
const RESULTS: &str = "results";

#[derive(Deserialize)]
struct Variants {
    variants: Vec<String>,
}

pub(super) fn plan(
    arguments: &Arguments,
    out: &str,
    variants: &[Variant],
    console: &Console,
) -> Result<CommandEnd, Failure> {
    console.claim(out, &[COMMANDS, VARIANTS], &[])?;
    let mut folder = ResultsFolder::new();
    let mut commands = String::new();
    for Variant { name, machine } in variants {
        if machine.tool.is_absent() {
            return Err(Failure::new("--plan: a job names the file of its tool, and there is none")
                .with_hint("run the batch without --plan"));
        }
        let mut tool = machine.tool.clone();
        tool.name.clone_from(name);
        let own = Machine { tool, ..machine.clone() };
        folder.add(&format!("variants/{name}/spindle.yaml"), spindle_yaml(&own.spindle))?;
        folder.add(&format!("variants/{name}/tool.yaml"), tool_yaml(&own.tool))?;
        commands.push_str(&command(arguments, name));
    }
    folder.add("weights.yaml", text(&arguments.weights, "weights", WEIGHTS)?)?;
    folder.add(COMMANDS, commands)?;
    let names: Vec<String> = variants.iter().map(|v| v.name.clone()).collect();
    folder.add(VARIANTS, format!("{:#}\n", json!({ "variants": names })))?;
    folder.add("slurm.sh", slurm(variants.len()))?;
    console.writing(|| folder.write(Path::new(out)))?;
    let sentence = format!("{} variants are planned", variants.len());
    let place = shell_word(out);
    let value = json!({ "run": "batch", "plan": out, "variants": names });
    Ok(CommandEnd::done(sentence.as_str())
        .data(format!("{sentence} in {out}\n"), value)
        .file(format!("{out}/{COMMANDS}"))
        .file(format!("{out}/slurm.sh"))
        .next(format!("cd {place} && parallel --jobs 2 < {COMMANDS}"))
        .next(format!("cd {place} && sbatch slurm.sh"))
        .next(format!("muspin batch --collect {place} --out {}", shell_word(&format!("{out}-table")))))
}

/// The command of one variant, to be run in the folder of the plan.
fn command(arguments: &Arguments, name: &str) -> String {
    let quick = if arguments.quick { " --quick" } else { "" };
    let formats = arguments.pictures.further();
    let no_polish = if arguments.no_polish { " --no-polish" } else { "" };
    let [spindle, tool] = ["spindle.yaml", "tool.yaml"].map(|file| quote_for_shell(&format!("variants/{name}/{file}")));
    format!(
        "muspin --threads 1 batch --spindle {spindle} --tools {tool} \
         --weights weights.yaml --out {RESULTS} --no-table{quick}{no_polish}{formats}\n"
    )
}

/// A Slurm job array over the commands. A job that is killed leaves no folder and is put back into the queue.
fn slurm(count: usize) -> String {
    format!(
        "#!/bin/sh\n\
         #SBATCH --job-name=muspin\n\
         #SBATCH --array=1-{count}\n\
         #SBATCH --cpus-per-task=1\n\
         #SBATCH --requeue\n\
         #SBATCH --output=log-%a.txt\n\
         # Exit 1 says that a specification is missed: the variant is finished all the same.\n\
         sh -c \"$(sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" {COMMANDS})\" || [ $? -eq 1 ]\n"
    )
}

/// Rows of the finished variants of a plan, or of any folder of finished tools.
pub(super) fn collect_rows(folder: &str) -> Result<Vec<BatchRow>, Failure> {
    let place = Path::new(folder);
    let list = place.join(VARIANTS);
    let planned = match file::read_text(&list, file::RESULT) {
        Ok(text) => Some(text),
        Err(error) if error.is_absence() => None,
        Err(error) => return Err(error.of(&list.display().to_string()).into()),
    };
    let results = match planned {
        Some(_) => place.join(RESULTS),
        None => place.to_owned(),
    };
    let names = match &planned {
        Some(text) => names(text).map_err(|rule| {
            Failure::new(format!("{folder}/{VARIANTS}: {rule}"))
                .with_hint("write the plan again with `muspin batch --plan`")
        })?,
        None => list_finished(&results)?,
    };
    let rows: Vec<BatchRow> = names
        .iter()
        .map(|name| {
            let own = results.join(name);
            let why = if own.is_dir() { "not finished" } else { "not started" };
            read_row(&own.join(ROW_FILE)).unwrap_or_else(|| BatchRow::failed_row(name, "", why.to_owned()))
        })
        .collect();
    if rows.iter().all(|r| r.figures.is_none()) {
        let waiting = rows.iter().filter_map(|r| Some(format!("{} {}", r.tool, r.failure.as_ref()?)));
        let waiting: Vec<String> = waiting.collect();
        let list = if waiting.is_empty() { String::new() } else { format!(": {}", waiting.join(", ")) };
        return Err(Failure::new(format!("{folder}: no finished variant ({ROW_FILE}) is in it{list}"))
            .with_hint("give the folder of a plan whose commands were run, or of a batch"));
    }
    Ok(rows)
}

/// A row that was written before; none when there is no such file, or it is of another version.
pub(super) fn read_row(path: &Path) -> Option<BatchRow> {
    parse(&file::read_text(path, file::RESULT).ok()?).ok()
}

/// The names of a list of variants, which are those of folders.
fn names(text: &str) -> Result<Vec<String>, String> {
    let list: Variants = parse(text).map_err(|_| "expected a list `variants` of names".to_owned())?;
    for (k, name) in list.variants.iter().enumerate() {
        check_name(name).map_err(|rule| format!("variants[{k}]: {name:?} {rule}"))?;
    }
    Ok(list.variants)
}

/// A path as it is typed: quoted where a shell would take something in it for more than a letter.
fn shell_word(path: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+".contains(c);
    if path.chars().all(is_plain) { path.to_owned() } else { quote_for_shell(path) }
}

/// A word of a POSIX shell, whatever is in it.
fn quote_for_shell(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// Names of the folders that hold a row, in alphabetical order.
fn list_finished(folder: &Path) -> Result<Vec<String>, Failure> {
    let entries = std::fs::read_dir(folder).map_err(|e| Failure::new(format!("{}: {e}", folder.display())))?;
    let mut names: Vec<String> = entries
        .filter_map(|e| Some(e.ok()?.path()))
        .filter(|p| p.join(ROW_FILE).is_file())
        .filter_map(|p| Some(p.file_name()?.to_str()?.to_owned()))
        .collect();
    names.sort();
    Ok(names)
}
