//! What lies beside the records of a measurement: other tools, other controllers; and the folder of corrected records.

use super::failure::Failure;
use crate::controller::Controller;
use crate::diagnose::{Alternatives, Diagnosis};
use crate::input::file;
use crate::input::shipped::TOOLS;
use crate::input::{Measurement, load_controller, load_machine, machine_files};
use crate::report::corrected_records::{Circumstances, Copied, RecordNames, stage_records};
use crate::report::results::ResultsFolder;
use crate::spindle::Machine;
use std::collections::BTreeMap;
use std::path::Path;

/// What may have been in the spindle and in the loop, and the names of the records.
pub(crate) struct Surroundings {
    tools: Vec<(String, Machine)>,
    controllers: Vec<(String, Controller)>,
    pub(crate) names: RecordNames,
    spindle: String,
    tool: String,
}

impl Surroundings {
    /// Tools beside the tool's file and those that come with the program, and controllers in the folder of the
    /// measurement; what does not fit the spindle is passed over.
    pub(crate) fn of(loaded: &Measurement, spindle: Option<&str>, tool: Option<&str>, machine: &Machine) -> Self {
        let spindle = spindle.unwrap_or(&loaded.spindle).to_owned();
        let tool = tool.unwrap_or(&loaded.tool).to_owned();
        let mut named: BTreeMap<String, String> = BTreeMap::new();
        for shipped in TOOLS {
            named.insert(shipped.name.to_owned(), shipped.name.to_owned());
        }
        let mut folders = vec![loaded.folder.clone(), loaded.folder.join("tools")];
        if let Some(folder) = Path::new(&tool).parent().filter(|p| p.is_dir()) {
            folders.extend([folder.to_owned(), folder.join("tools")]);
        }
        for path in folders.iter().flat_map(|f| files(f, "yaml")) {
            named.insert(stem(&path), path);
        }
        let tools = named.into_iter().filter_map(|(name, source)| {
            let other = load_machine(&spindle, &source).ok()?;
            (other.tool != machine.tool).then_some((name, other))
        });
        let used: Vec<&String> = loaded.hammers.iter().filter_map(|h| h.controller.as_ref()).collect();
        let controllers = files(&loaded.folder, "json").into_iter().filter_map(|path| {
            let other = load_controller(&path).ok()?;
            (!used.iter().all(|u| **u == path)).then(|| (stem(&path), other))
        });
        let name_of = |path: &str| {
            let path = Path::new(path).file_name();
            path.map_or(String::new(), |n| n.to_string_lossy().into_owned())
        };
        Self {
            tools: tools.collect(),
            controllers: controllers.collect(),
            names: RecordNames {
                sweeps: loaded.sweeps.iter().map(|s| name_of(&s.record.name)).collect(),
                hammers: loaded.hammers.iter().map(|h| name_of(&h.name)).collect(),
            },
            spindle,
            tool,
        }
    }

    /// The same for the diagnosis.
    pub(crate) fn alternatives(&self) -> Alternatives<'_> {
        let mut alternatives = Alternatives { tools: self.tools.clone(), controllers: vec![] };
        for (name, controller) in &self.controllers {
            alternatives.controllers.push((name.clone(), controller));
        }
        alternatives
    }

    /// The corrected records as a measurement folder.
    pub(crate) fn stage_records(
        &self,
        folder: &mut ResultsFolder,
        loaded: &Measurement,
        found: &Diagnosis,
    ) -> Result<(), Failure> {
        let mut files: BTreeMap<String, Vec<u8>> = BTreeMap::new();
        let mut circumstances = |path: &Option<String>, axis: usize| -> Result<_, Failure> {
            let Some(path) = path else {
                return Ok(Circumstances::default());
            };
            let name = format!("{}.json", stem(path));
            let bytes = file::read(Path::new(path), file::MATLAB).map_err(|error| error.of(path))?;
            files.insert(name.clone(), bytes);
            Ok(Circumstances { controller: Some(name), axis })
        };
        let sweeps: Vec<_> = loaded.sweeps.iter().map(|s| (&s.controller, 0)).collect();
        let sweeps = sweeps.into_iter().map(|(c, axis)| circumstances(c, axis));
        let sweeps = sweeps.collect::<Result<Vec<_>, _>>()?;
        let hammers = loaded.hammers.iter().map(|h| circumstances(&h.controller, h.axis));
        let hammers = hammers.collect::<Result<Vec<_>, _>>()?;
        let machine = load_machine(&self.spindle, &self.tool)?;
        let mut copied: Vec<Copied> = files.into_iter().collect();
        let machine = Machine { tool: found.corrected.tool.clone(), ..machine };
        copied.extend(machine_files(&machine).into_iter().map(|(name, text)| (name.to_owned(), text.into_bytes())));
        Ok(stage_records(folder, found, &self.names, &sweeps, &hammers, &copied)?)
    }
}

/// Files of a folder with an extension, in the order of their names; none of a folder that cannot be read.
fn files(folder: &Path, extension: &str) -> Vec<String> {
    let mut all: Vec<String> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .map(|path| path.display().to_string())
        .collect();
    all.sort();
    all
}

fn stem(path: &str) -> String {
    let stem = Path::new(path).file_stem();
    stem.map_or(String::new(), |s| s.to_string_lossy().into_owned())
}
