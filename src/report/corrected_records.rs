//! Faults of records as topic of the summary, and the corrected records as a measurement folder (formats.md,
//! section 4).

use super::identification::{fault_topic, polluted_lines_topic};
use super::records::{hammer_csv, sweep_csv};
use super::results::{ResultsError, ResultsFolder};
use crate::diagnose::data::measurement::RecordId;
use crate::diagnose::{Diagnosis, FoundFault};
use crate::identify::plausibility::RecordFault;
use serde_json::Value;
use std::fmt::Write as _;

const FOLDER: &str = "measurement";

/// Names of the records in file order.
#[derive(Clone, Debug, Default)]
pub(crate) struct RecordNames {
    pub sweeps: Vec<String>,
    /// Files of the hammer tests.
    pub hammers: Vec<String>,
}

impl RecordNames {
    /// The file of a record, as `measurement.yaml` names it.
    pub(crate) fn of(&self, record: RecordId) -> &str {
        let name = match record {
            RecordId::Sweep(s) => self.sweeps.get(s),
            RecordId::Hammer(t) => self.hammers.get(t),
        };
        name.map_or("", String::as_str)
    }
}

/// `diagnosis.record_faults`.
pub(crate) fn record_faults(d: &Diagnosis, names: &RecordNames) -> Vec<Value> {
    let each = |f: &FoundFault| fault_topic(names.of(f.record), &f.fault, f.name.as_deref());
    let polluted = d.polluted_lines.iter();
    let polluted = polluted.map(|lines| polluted_lines_topic(names.of(RecordId::Sweep(lines.sweep)), lines));
    d.record_faults.iter().map(each).chain(polluted).collect()
}

/// A file that is copied: its name, its bytes.
pub(crate) type Copied = (String, Vec<u8>);

/// How a record was taken.
#[derive(Clone, Debug, Default)]
pub(crate) struct Circumstances {
    /// File of the controller in the folder, as it is named there.
    pub controller: Option<String>,
    /// 0 for x, 1 for y.
    pub axis: usize,
}

/// The measurement without its faults: `sweeps` and `hammers` say how the records of the diagnosis were taken, `files`
/// are spindle, tool and controllers.
pub(crate) fn stage_records(
    folder: &mut ResultsFolder,
    d: &Diagnosis,
    names: &RecordNames,
    sweeps: &[Circumstances],
    hammers: &[Circumstances],
    files: &[Copied],
) -> Result<(), ResultsError> {
    let tool = if d.corrected.tool.is_absent() { "none" } else { "tool" };
    let mut list = format!("spindle: spindle\ntool: {tool}\nrecords:\n");
    let left_out = |record: RecordId| {
        let gone = |f: &FoundFault| f.record == record && f.fault == RecordFault::Disagrees;
        d.record_faults.iter().any(gone)
    };
    let with = |line: &mut String, c: &Circumstances| {
        if let Some(controller) = &c.controller {
            let _ = write!(line, ", controller: {controller:?}");
        }
    };
    let kept = (0..names.sweeps.len()).filter(|s| !left_out(RecordId::Sweep(*s)));
    for (s, record) in kept.zip(&d.sweeps) {
        let file = &names.sweeps[s];
        let rpm = record.speed_rpm;
        let mut line = format!("  - {{kind: sweep, file: {file:?}, speed_rpm: {rpm:?}");
        sweeps.get(s).into_iter().for_each(|c| with(&mut line, c));
        list += &(line + "}\n");
        folder.add(&format!("{FOLDER}/{file}"), sweep_csv(record))?;
    }
    let kept = (0..names.hammers.len()).filter(|t| !left_out(RecordId::Hammer(*t)));
    for (t, frf) in kept.zip(&d.hammers) {
        // A universal file becomes a table.
        let stem = names.hammers[t].rsplit_once('.').map_or("hammer", |n| n.0);
        let file = format!("{stem}.csv");
        let rpm = frf.speed_rpm;
        let mut line = format!("  - {{kind: hammer, file: {file:?}, speed_rpm: {rpm:?}");
        if let Some(c) = hammers.get(t) {
            let _ = write!(line, ", axis: {}", ["x", "y"][c.axis.min(1)]);
            with(&mut line, c);
        }
        list += &(line + "}\n");
        folder.add(&format!("{FOLDER}/{file}"), hammer_csv(frf))?;
    }
    for (name, bytes) in files {
        folder.add(&format!("{FOLDER}/{name}"), bytes.clone())?;
    }
    folder.add(&format!("{FOLDER}/measurement.yaml"), list)
}
