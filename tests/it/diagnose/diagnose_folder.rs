//! Reads a measurement folder for the diagnosis tests, without the program's own readers.

use muspin::controller::Controller;
use muspin::diagnose::data::measurement::{ControlAxis, HammerTest, RecordSet};
use muspin::identify::{HammerFrf, SweepRecord};
use muspin::input::{load_controller, load_machine};
use muspin::linalg::c64;
use muspin::spindle::Machine;
use ndarray::Array4;
use std::path::Path;

pub struct Folder {
    pub machine: Machine,
    pub controller: Controller,
    pub sweep: SweepRecord,
    pub hammer: Option<HammerFrf>,
}

impl Folder {
    /// All records: the sweep, and the hammer test in x if there is one.
    pub fn measurement(&self) -> RecordSet<'_> {
        let taps = self.hammer.iter().map(|frf| HammerTest {
            frf: frf.clone(),
            axis: ControlAxis::X,
            controller: &self.controller,
        });
        RecordSet { sweeps: vec![self.sweep.clone()], taps: taps.collect() }
    }
}

fn table(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).expect("file");
    text.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().expect("number")).collect()).collect()
}

pub fn read(name: &str) -> Folder {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/diagnosis").join(name);
    let path = |f: &str| dir.join(f).to_str().expect("utf-8").to_owned();
    let machine = load_machine(&path("spindle.yaml"), &path("tool.yaml")).expect("machine");
    let controller = load_controller(&path("pid.json")).expect("controller");
    let rows = table(&dir.join("sweep-0.csv"));
    let mut frequency_hz: Vec<f64> = rows.iter().map(|r| r[0]).collect();
    frequency_hz.dedup();
    frequency_hz.sort_by(f64::total_cmp);
    frequency_hz.dedup();
    let repeats = rows.iter().map(|r| r[2] as usize).max().expect("repeats");
    let zero = c64::new(0.0, 0.0);
    let mut current = Array4::from_elem((frequency_hz.len(), 4, repeats, 4), zero);
    let mut signal = current.clone();
    for r in &rows {
        let k = frequency_hz.iter().position(|f| *f == r[0]).expect("line");
        for axis in 0..4 {
            let at = (k, r[1] as usize - 1, r[2] as usize - 1, axis);
            current[at] = c64::new(r[3 + 2 * axis], r[4 + 2 * axis]);
            signal[at] = c64::new(r[11 + 2 * axis], r[12 + 2 * axis]);
        }
    }
    let sweep = SweepRecord {
        name: name.into(),
        speed_rpm: 0.0,
        frequency_hz,
        current,
        signal,
        left_out: vec![],
        run_out: false,
    };
    let hammer = dir.join("hammer-0.csv").exists().then(|| {
        let rows = table(&dir.join("hammer-0.csv"));
        HammerFrf {
            speed_rpm: 0.0,
            frequency_hz: rows.iter().map(|r| r[0]).collect(),
            compliance: rows.iter().map(|r| c64::new(r[1], r[2])).collect(),
            coherence: Some(rows.iter().map(|r| r[3]).collect()),
            averages: Some(rows.iter().map(|r| r[4]).collect()),
        }
    });
    Folder { machine, controller, sweep, hammer }
}
