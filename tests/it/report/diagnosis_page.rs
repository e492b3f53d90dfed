//! Tables and pictures of a diagnosis whose records differ in number of lines.

use muspin::diagnose::decide::misfit::Misfit;
use muspin::diagnose::decide::residuals::{MeasuredChannel, Record};
use muspin::diagnose::locate::correction::Correction;
use muspin::diagnose::locate::localisation::{Localisation, PortScore};
use muspin::diagnose::locate::place::{LawUnit, Place};
use muspin::diagnose::locate::recovered_law::Law;
use muspin::diagnose::{Diagnosis, Verdict};
use muspin::input::load_machine;
use muspin::linalg::c64;
use muspin::report::diagnosis::stage;
use muspin::report::results::ResultsFolder;
use std::f64::consts::TAU;

/// Lines of the sweep at standstill and of the one at speed.
const LINES: [usize; 2] = [6, 9];

fn hz(lines: usize) -> Vec<f64> {
    (1..=lines).map(|k| 100.0 * k as f64).collect()
}

fn law(name: &str, lines: usize) -> Law {
    let values = (1..=lines).map(|k| c64::new(k as f64, -0.5)).collect();
    Law::new(name, LawUnit::Stiffness, hz(lines), values, vec![0.1; lines])
}

fn channel(record: Record, lines: usize, rpm: f64) -> MeasuredChannel {
    let response = |size: f64| vec![c64::new(size, 0.1); lines];
    MeasuredChannel {
        record,
        speed_rad_s: rpm * TAU / 60.0,
        held_out: matches!(record, Record::Hammer(_)),
        omega_rad_s: hz(lines).iter().map(|f| TAU * f).collect(),
        measured: response(1.0),
        before: response(1.2),
        after: response(1.01),
        sigma: vec![0.01; lines],
    }
}

/// A diagnosis with a sweep of few lines at standstill, one of more lines at speed, a hammer test of yet another
/// number, and a place with these laws.
fn diagnosis(laws: Vec<Law>) -> Diagnosis {
    let all: usize = LINES.iter().sum();
    let score = |port: &str, place: Place, lines: usize, laws: Vec<Law>| PortScore {
        port: port.to_owned(),
        place,
        chi2_before: 40.0,
        chi2_after: 1.0,
        score_above_best: 0.0,
        numbers: 2,
        frequency_hz: hz(lines),
        line_before: vec![40.0; lines],
        line_after: vec![1.0; lines],
        laws,
        p: vec![],
    };
    let sweep = |(lines, rpm): (usize, f64)| {
        (0..16).map(move |n| channel(Record::Sweep(n / 4, n % 4), lines, rpm)).collect::<Vec<_>>()
    };
    let mut channels: Vec<MeasuredChannel> =
        [(LINES[0], 0.0), (LINES[1], 20000.0)].into_iter().flat_map(sweep).collect();
    channels.push(channel(Record::Hammer(0), 4, 0.0));
    Diagnosis {
        verdict: Verdict::Unexplained,
        effects: vec![],
        small_effects: vec![],
        nearest: vec![],
        gap_nearest: 3.0,
        slope_read: false,
        strained: vec![],
        further_off: vec![],
        tie: vec![],
        ranking: vec![],
        strength: 0.0,
        corrected: load_machine("reference", "paper-tool").unwrap(),
        gap_before: 4.0,
        gap_after: 1.0,
        gap_before_held_out: 4.0,
        gap_after_held_out: 1.0,
        held_out: "hammer test".to_owned(),
        next_measurement: None,
        misfit: Misfit::default(),
        localisation: Localisation {
            ports: vec![
                score("front bearing", Place::Station(0.1), all, laws),
                score("housing", Place::Housing, LINES[0], vec![]),
            ],
        },
        axis_gains: vec![],
        small: vec![],
        channels,
        correction: Some(Correction {
            port: "front bearing".to_owned(),
            place: Place::Station(0.1),
            sweeps: LINES.iter().map(|lines| vec![[c64::new(1.0, 0.0); 36]; *lines]).collect(),
            taps: vec![vec![[c64::new(1.0, 0.0); 36]; 4]],
            p: vec![],
        }),
        menu: vec![],
        detectable: vec![],
        score: f64::INFINITY,
        record_faults: vec![],
        polluted_lines: vec![],
        sweeps: vec![],
        hammers: vec![],
    }
}

fn file(folder: &ResultsFolder, name: &str) -> String {
    let found = folder.files().find(|(path, _)| *path == name);
    let (_, bytes) = found.unwrap_or_else(|| panic!("no {name}"));
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn first_columns(csv: &str) -> Vec<f64> {
    csv.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect()
}

#[test]
fn laws_of_unequal_lines_have_a_table_and_a_picture_each() {
    let all: usize = LINES.iter().sum();
    for (first, second) in [(all, LINES[1]), (LINES[1], all)] {
        let d = diagnosis(vec![law("x and y alike", first), law("x to y", second)]);
        let mut folder = ResultsFolder::new();
        stage(&mut folder, &d).unwrap();
        for (name, column, lines) in
            [("correction.csv", "law_x_and_y_alike", first), ("correction-2.csv", "law_x_to_y", second)]
        {
            let text = file(&folder, name);
            assert_eq!(first_columns(&text), hz(lines), "{name}");
            let header = text.lines().next().unwrap();
            assert_eq!(header.split(',').count(), 5, "{header}");
            assert!(header.contains(column) && header.ends_with(",place"), "{header}");
            assert!(text.lines().skip(1).all(|row| row.ends_with(",shaft:0.1")), "{text}");
        }
        for (k, lines) in LINES.iter().enumerate() {
            let name = if k == 0 { "corrected-frf.csv" } else { "corrected-frf-2.csv" };
            // Through rad/s and back.
            let found = first_columns(&file(&folder, name));
            assert_eq!(found.len(), *lines, "{name}");
            let is_near = |(found, hz): (&f64, f64)| (found / hz - 1.0).abs() < 1e-12;
            assert!(found.iter().zip(hz(*lines)).all(is_near), "{name}: {found:?}");
        }
        for name in ["plots/impedance.csv", "plots/impedance-2.csv"] {
            assert!(file(&folder, name).lines().count() > 1, "{name}");
        }
    }
}

#[test]
fn laws_of_equal_lines_share_a_table() {
    let d = diagnosis(vec![law("x", 9), law("y", 9)]);
    let mut folder = ResultsFolder::new();
    stage(&mut folder, &d).unwrap();
    let text = file(&folder, "correction.csv");
    assert_eq!(text.lines().next().unwrap().split(',').count(), 8);
    assert_eq!(first_columns(&text), hz(9));
    assert!(folder.files().all(|(path, _)| path != "correction-2.csv"));
}
