//! Tools and variants of a batch, each with the name of its folder.

use super::Failure;
use super::batch_arguments::Arguments;
use super::machine::load_machine;
use crate::input::load_spindle;
use crate::input::name::check_name;
use crate::pipeline::variation::{Quantity, Variation, variants as of_machine};
use crate::report::batch::ROW_FILE;
use crate::report::manifest::MANIFEST;
use crate::spindle::Machine;
use std::collections::BTreeMap;
use std::path::Path;

pub(super) struct Variant {
    /// Name of its folder: the tool, and what differs.
    pub(super) name: String,
    pub(super) machine: Machine,
}

impl Variant {
    /// Its folder inside that of the batch.
    pub(super) fn folder(&self, out: &str) -> String {
        Path::new(out).join(&self.name).display().to_string()
    }
}

/// Names of files and folders that the batch writes beside the folder of each tool.
const RESERVED: [&str; 6] = ["plots", "report.html", "summary.json", "tools.csv", ROW_FILE, MANIFEST];

/// Every tool of the command line, as drawn and at both ends of each variation.
pub(super) fn variants(arguments: &Arguments) -> Result<Vec<Variant>, Failure> {
    let variations = arguments.vary.iter().map(|text| variation(text)).collect::<Result<Vec<_>, _>>()?;
    let mut known: BTreeMap<String, String> = BTreeMap::new();
    let mut all = vec![];
    // A spindle that is wrong is told once.
    load_spindle(&arguments.spindle)?;
    let mut failures = vec![];
    for source in expand(&arguments.tools)? {
        match load_machine(&arguments.spindle, &source) {
            Ok(machine) => {
                for (name, machine) in of_machine(&machine, &variations) {
                    failures.extend(check_distinct(&source, &name, &mut known).err());
                    all.push(Variant { name, machine });
                }
            }
            Err(failure) => failures.push(failure),
        }
    }
    let mut failures = failures.into_iter();
    match failures.next() {
        Some(first) => Err(first.with_further(failures)),
        None => Ok(all),
    }
}

/// A variation from the text `ki=3%` or `ki=±3%`.
fn variation(text: &str) -> Result<Variation, Failure> {
    let names = Quantity::ALL.map(Quantity::name);
    let refused = |why: String| {
        Failure::new(format!("--vary {text}: {why}"))
            .with_hint("a quantity and its half width in percent, for example --vary ki=3%,delay=10%")
    };
    let Some((name, width)) = text.split_once('=') else {
        return Err(refused("there is no '='".to_owned()));
    };
    let Some(quantity) = Quantity::from_name(name) else {
        return Err(refused(format!("{name:?} is none of {}", names.join(", "))));
    };
    let digits = width.trim_start_matches('±').trim_end_matches('%');
    match digits.parse::<f64>() {
        Ok(percent) if percent > 0.0 && percent < 50.0 => Ok(Variation { quantity, relative: 0.01 * percent }),
        _ => Err(refused(format!("{width:?} is no percentage between 0 and 50"))),
    }
}

/// Every variant needs a folder of its own, on file systems that do not tell upper from lower case as well.
fn check_distinct(source: &str, name: &str, known: &mut BTreeMap<String, String>) -> Result<(), Failure> {
    let refused = |rule: String| {
        Err(Failure::new(format!("{source}: name: {name:?} {rule}"))
            .with_hint("the results of a tool go to a folder of its name: change `name:` in the tool file"))
    };
    let folder = name.to_lowercase();
    if let Err(rule) = check_name(name) {
        return refused(rule);
    }
    if RESERVED.contains(&folder.as_str()) {
        return refused("is the name of a file or folder of the batch itself".into());
    }
    if let Some(first) = known.insert(folder, source.to_owned()) {
        return refused(format!("is the name of the tool in {first} already"));
    }
    Ok(())
}

/// Files and names as given; a folder stands for its tool files in alphabetical order.
fn expand(tools: &[String]) -> Result<Vec<String>, Failure> {
    let mut all = vec![];
    for tool in tools {
        if !Path::new(tool).is_dir() {
            all.push(tool.clone());
            continue;
        }
        let entries = std::fs::read_dir(tool).map_err(|e| Failure::new(format!("{tool}: {e}")))?;
        let mut files: Vec<String> = entries
            .filter_map(|e| Some(e.ok()?.path()))
            .filter(|p| p.extension().is_some_and(|x| x == "yaml"))
            .map(|p| p.display().to_string())
            .collect();
        files.sort();
        if files.is_empty() {
            return Err(Failure::new(format!("--tools: {tool} holds no .yaml file"))
                .with_hint("give a folder of tool files, or names separated by commas"));
        }
        all.extend(files);
    }
    Ok(all)
}
