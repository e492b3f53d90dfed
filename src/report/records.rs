//! Records of a measurement as the files of formats.md, section 4: sweeps and hammer tests as CSV.

use crate::identify::frf::AXES;
use crate::identify::{HammerFrf, SweepRecord};
use crate::input::sweep::header;
use std::fmt::Write as _;

/// A sweep: one row per line, experiment and repeat.
pub fn sweep_csv(record: &SweepRecord) -> String {
    let mut text = header().join(",") + "\n";
    for (line, hz) in record.frequency_hz.iter().enumerate() {
        for experiment in 0..AXES {
            for repeat in 0..record.repeats() {
                let _ = write!(text, "{hz},{},{}", experiment + 1, repeat + 1);
                for values in [&record.current, &record.signal] {
                    for axis in 0..AXES {
                        let x = values[[line, experiment, repeat, axis]];
                        let _ = write!(text, ",{:.6e},{:.6e}", x.re, x.im);
                    }
                }
                text.push('\n');
            }
        }
    }
    text
}

/// A hammer test with coherence and averages; 1 where the record has none.
pub(crate) fn hammer_csv(record: &HammerFrf) -> String {
    let mut text = String::from("frequency_hz,h_re,h_im,coherence,averages\n");
    let at = |list: &Option<Vec<f64>>, k: usize| list.as_ref().and_then(|l| l.get(k).copied()).unwrap_or(1.0);
    for (k, (hz, h)) in record.frequency_hz.iter().zip(&record.compliance).enumerate() {
        let (coherence, averages) = (at(&record.coherence, k), at(&record.averages, k));
        let _ = writeln!(text, "{hz},{:.6e},{:.6e},{coherence:.9},{averages}", h.re, h.im);
    }
    text
}

/// Kind, file and speed (rpm) of a record.
pub(crate) type Listed = (&'static str, String, f64);

/// The list `measurement.yaml` of computed records under the controller `pid.json`.
pub(crate) fn rehearsed_list(records: &[Listed]) -> String {
    let mut text =
        String::from("# Computed from a model, not measured.\nspindle: spindle.yaml\ntool: tool.yaml\nrecords:\n");
    for (kind, file, rpm) in records {
        let axis = if *kind == "hammer" { ", axis: x" } else { "" };
        let _ = writeln!(text, "  - {{kind: {kind}, file: {file}, speed_rpm: {rpm}, controller: pid.json{axis}}}");
    }
    text
}
