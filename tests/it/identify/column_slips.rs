//! Slips of cables and columns that leave every response plausible: each is put into records of two simulators and has
//! to be said; records without one stay silent.

use crate::support::files::below_root;
use muspin::controller::Controller;
use muspin::identify::{SweepRecord, open_loop, sweep_plausibility};
use muspin::input::{load_controller, load_machine, load_measurement};
use muspin::spindle::Machine;
use std::f64::consts::{PI, SQRT_2};

const SLIPS: [&str; 4] = ["repeated_column", "factor_between_axes", "doubled_plane", "hold"];

struct Rig {
    record: SweepRecord,
    machine: Machine,
    controller: Controller,
}

fn rig(case: &str) -> Rig {
    let folder = below_root(&format!("tests/data/diagnosis/{case}"));
    let path = |file: &str| folder.join(file).to_str().unwrap().to_owned();
    let loaded = load_measurement(folder.to_str().unwrap()).unwrap();
    let sweep = loaded.sweeps.into_iter().next().unwrap();
    Rig {
        controller: load_controller(&sweep.controller.unwrap()).unwrap(),
        record: sweep.record,
        machine: load_machine(&path("spindle.yaml"), &path("tool.yaml")).unwrap(),
    }
}

/// Names and words of the slips that are said of a record.
fn said(rig: &Rig, record: &SweepRecord) -> Vec<(String, String)> {
    let frf = open_loop(record).unwrap();
    let found = sweep_plausibility("sweep", &frf, &rig.machine, Some(&rig.controller)).unwrap();
    let slips = found.checks.iter().filter(|check| SLIPS.contains(&check.name));
    slips.map(|check| (check.name.to_owned(), check.words.clone())).collect()
}

/// One name, and words that hold all of the given ones.
fn is_said(rig: &Rig, record: &SweepRecord, name: &str, words: &[&str]) {
    let found = said(rig, record);
    let own = found.iter().find(|(own, _)| own == name);
    let (_, text) = own.unwrap_or_else(|| panic!("{name} is not said: {found:?}"));
    for word in words {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn records_without_a_slip_stay_silent() {
    for case in ["c01", "c02", "c03", "c04", "c05", "c06", "c15", "c19"] {
        let rig = rig(case);
        assert_eq!(said(&rig, &rig.record), [], "{case}");
    }
}

#[test]
fn a_column_that_was_written_twice_is_said() {
    for case in ["c01", "c19"] {
        let rig = rig(case);
        let mut record = rig.record.clone();
        let first = record.signal.slice(ndarray::s![.., .., .., 0]).to_owned();
        record.signal.slice_mut(ndarray::s![.., .., .., 2]).assign(&first);
        is_said(&rig, &record, "repeated_column", &["front_x", "rear_x", "same numbers"]);
    }
}

#[test]
fn a_factor_between_the_axes_of_a_plane_is_said() {
    for case in ["c01", "c03", "c19"] {
        let rig = rig(case);
        let scaled = |axis: usize, factor: f64| {
            let mut record = rig.record.clone();
            record.signal.slice_mut(ndarray::s![.., .., .., axis]).mapv_inplace(|y| y * factor);
            record
        };
        is_said(&rig, &scaled(1, 2.0), "factor_between_axes", &["front_y", "added"]);
        is_said(&rig, &scaled(2, 1.0 / SQRT_2), "factor_between_axes", &["rear_y", "RMS"]);
        let mut record = rig.record.clone();
        record.current.slice_mut(ndarray::s![.., .., .., 3]).mapv_inplace(|u| u * SQRT_2);
        is_said(&rig, &record, "factor_between_axes", &["current of rear_y", "RMS"]);
    }
}

#[test]
fn a_pair_of_sensors_that_counts_double_is_said() {
    for case in ["c01", "c15"] {
        let rig = rig(case);
        let mut record = rig.record.clone();
        record.signal.slice_mut(ndarray::s![.., .., .., 0..2]).mapv_inplace(|y| y * 2.0);
        is_said(&rig, &record, "doubled_plane", &["front", "2 times"]);
    }
}

#[test]
fn currents_that_were_logged_on_the_other_side_of_the_hold_are_said() {
    for case in ["c15", "c19"] {
        let rig = rig(case);
        let period_s = rig.machine.spindle.electronics.sample_period_s();
        let with_holds = |holds: i32| {
            let mut record = rig.record.clone();
            let lines = record.frequency_hz.clone();
            for (mut line, hz) in record.current.outer_iter_mut().zip(lines) {
                let half = PI * hz * period_s;
                let hold = half.sin() / half;
                line.mapv_inplace(|u| u * hold.powi(holds));
            }
            record
        };
        is_said(&rig, &with_holds(1), "hold", &["leave out hold: true"]);
        is_said(&rig, &with_holds(-1), "hold", &["write hold: true"]);
    }
}
