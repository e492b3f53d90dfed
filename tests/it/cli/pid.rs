//! `muspin pid`: numbers of a file become a controller that other commands take, and what is said of its loop holds.

use crate::cli::program::muspin;
use muspin::controller::{ControlLaw, Controller};
use muspin::export::json::controller_json;
use muspin::input::load_controller;
use muspin::lti::StateSpace;
use serde_json::Value;
use std::path::Path;

const NUMBERS: &str = "\
name: lab-pid
front: &channel
  gain_a_per_m: 8000
  integral_a_per_m_s: 4.0e+4
  damping_a_s_per_m: 18
  derivative_rolloff_hz: 1800
  rolloff_hz: 2600
rear: *channel
";

/// Numbers that hold the reference spindle, and no good ones.
const REFERENCE: &str = "\
name: own-pid
front: &channel
  gain_a_per_m: 1.08e+4
  integral_a_per_m_s: 2.0e+4
  damping_a_s_per_m: 12.3
  derivative_rolloff_hz: 5700
rear: *channel
";

/// A folder with a slender rotor on magnets and a file of numbers.
fn folder(numbers: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let rotor = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/spindles/s13-lab-rotor.yaml");
    std::fs::copy(rotor, folder.path().join("lab.yaml")).unwrap();
    std::fs::write(folder.path().join("pid.yaml"), numbers).unwrap();
    folder
}

const MACHINE: [&str; 4] = ["--spindle", "lab.yaml", "--tool", "endmill-6"];

fn summary(folder: &Path, arguments: &[&str]) -> (i32, Value, String) {
    let (code, out, err) = muspin(&[arguments, &MACHINE].concat(), folder);
    (code, serde_json::from_str(&out).unwrap_or(Value::Null), err)
}

#[test]
fn numbers_of_a_file_become_a_controller_that_other_commands_take() {
    let folder = folder(REFERENCE);
    let (code, out, err) = muspin(&["pid", "pid.yaml", "--out", "o", "--speeds", "0:25000:50000"], folder.path());
    let found: Value = serde_json::from_str(&out).unwrap();
    assert!(code < 2 && !err.contains("unstable"), "{code} {err}");
    let speeds = found["stability"]["pid"]["certificates"]["speeds"].as_array().unwrap();
    assert!(speeds.len() > 2 && speeds.iter().all(|at| at["growth_rate_per_s"].as_f64().unwrap() < 0.0), "{found}");
    assert_eq!(found["stiffness"]["over_speed"].as_array().unwrap().len(), 3);

    let file = "o/controller/discrete.json";
    // The machine is found beside the controller.
    let (code, out, err) = muspin(&["compare", "--controller", file, "--speeds", "0", "--out", "c"], folder.path());
    assert!(code < 2 && !err.contains("another machine"), "{err}");
    let compared: Value = serde_json::from_str(&out).unwrap();
    let least = |value: &Value| value["minimum_n_per_m"].as_f64().unwrap();
    assert_eq!(least(&compared["stiffness"]["own-pid"]), least(&found["stiffness"]["pid"]));
    let (code, _, err) = muspin(&["export", "--controller", file, "--out", "firmware"], folder.path());
    assert!(code == 0 && folder.path().join("firmware/controller.c").is_file(), "{err}");
    let case = ["simulate", "--controller", file, "--case", "impulse", "--duration", "0.01"];
    assert!(muspin(&case, folder.path()).0 < 2);

    let (code, text, _) = muspin(&["pid", "pid.yaml", "--out", "o", "--text"], folder.path());
    assert!(code < 2 && text.contains("own-pid: stable at every speed") && text.contains("rear_y"), "{text}");

    margins_are_where_the_loop_is_lost(folder.path(), &found);
}

/// With a gain of one channel a percent beyond its margin the loop is unstable, a percent before it stable.
fn margins_are_where_the_loop_is_lost(folder: &Path, found: &Value) {
    let whole = load_controller(folder.join("o/controller/discrete.json").to_str().unwrap()).unwrap();
    let ControlLaw::Discrete(law) = whole.law else { panic!("not sampled") };
    let mut checked = 0;
    for (channel, margin) in found["margins"]["pid"]["channels"].as_array().unwrap().iter().enumerate().step_by(2) {
        for (key, beyond) in [("smallest_gain_factor", 0.99), ("largest_gain_factor", 1.01)] {
            let Some(factor) = margin[key].as_f64().filter(|factor| *factor > 0.0) else { continue };
            let stable = |times: f64| {
                let (mut b, mut d) = (law.b.clone(), law.d.clone());
                (0..b.nrows()).for_each(|i| b[(i, channel)] *= times);
                (0..d.nrows()).for_each(|i| d[(i, channel)] *= times);
                let law = ControlLaw::Discrete(StateSpace { b, d, ..law.clone() });
                let json = controller_json(&Controller { name: "scaled".to_owned(), law }, None);
                std::fs::write(folder.join("scaled.json"), json).unwrap();
                muspin(&["frf", "--controller", "scaled.json", "--points", "2"], folder).0 == 0
            };
            assert!(stable(factor / beyond), "{channel} {key} {factor}");
            assert!(!stable(factor * beyond), "{channel} {key} {factor}");
            checked += 1;
        }
    }
    assert!(checked > 2, "{found}");
}

#[test]
fn an_unstable_pid_says_so_with_its_mode_and_is_no_success() {
    let folder = folder(&NUMBERS.replace("damping_a_s_per_m: 18", "damping_a_s_per_m: 0"));
    let (code, found, err) = summary(folder.path(), &["pid", "pid.yaml", "--out", "o"]);
    assert_eq!(code, 1, "{err}");
    // What looks odd in the machine comes before.
    let said = err.lines().find(|line| line.starts_with("lab-pid: unstable: the closed loop grows by"));
    assert!(said.is_some_and(|line| line.contains("What grows has")), "{err}");
    assert_eq!(found["verdict"]["met"], false);
    assert!(found["instability"]["frequency_hz"].as_f64().unwrap() > 0.0);
    assert!(found["stiffness"]["pid"]["minimum_n_per_m"].is_null() && found["margins"].is_null(), "{found}");
    assert!(folder.path().join("o/controller/discrete.json").is_file());
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_written() {
    let folder = folder(&NUMBERS.replace("rolloff_hz: 2600", "rolloff_hz: 5000"));
    let (code, _, err) = summary(folder.path(), &["pid", "pid.yaml", "--out", "o"]);
    assert!(code == 2 && err.contains("rolloff_hz: 5000 Hz is not below half of the sample rate"), "{err}");
    assert!(!folder.path().join("o").exists());
    let (code, _, err) = muspin(&["check", "pid.yaml", "--spindle", "lab.yaml"], folder.path());
    assert!(code == 2 && err.contains("pid.yaml:7"), "{err}");
    // Limits are those of a search; numbers of a file have none.
    let (code, _, err) = summary(folder.path(), &["pid", "pid.yaml", "--noise-current", "0.01"]);
    assert!(code == 2 && err.contains("--noise-current"), "{err}");
    let (code, _, err) = summary(folder.path(), &["pid", "--noise-current", "0"]);
    assert!(code == 2 && err.contains("--noise-current: 0"), "{err}");
}

/// A search of half a minute in a release build: `cargo test --release --test it cli::pid -- --ignored`
#[test]
#[ignore = "a whole search"]
fn a_tuned_pid_keeps_its_limits() {
    let folder = folder(NUMBERS);
    let (code, found, err) = summary(folder.path(), &["pid", "--out", "o", "--noise-current", "0.05"]);
    assert_eq!(code, 0, "{err}");
    assert!(found["pid"]["noise_current_a"].as_f64().unwrap() <= 0.05);
    assert_eq!(found["pid"]["meets_limits"], true);
    assert!(found["pid"]["front"]["gain_a_per_m"].as_f64().unwrap() > 0.0);
}

/// Magnets that are stiff against a slender shaft move its modes far from where they are free: none of them is missing.
#[test]
fn modes_of_a_slender_rotor_are_listed_where_the_magnets_put_them() {
    let numbers = "name: own-pid\nfront: &channel\n  gain_a_per_m: 4170\n  damping_a_s_per_m: 22\n  \
                   derivative_rolloff_hz: 1000\nrear: *channel\n";
    let folder = folder(numbers);
    let (_, _, err) = summary(folder.path(), &["pid", "pid.yaml", "--out", "o", "--speeds", "0"]);
    let file = ["--controller", "o/controller/discrete.json"];
    let (_, found, _) = summary(folder.path(), &[&["compare", "--speeds", "0", "--out", "c"][..], &file].concat());
    let plane = &found["tool_plane"]["own-pid"][0];
    let flexible = plane["flexible_modes"].as_array().unwrap();
    let rigid = plane["rigid_body_modes"].as_array().unwrap();
    let missing = flexible.iter().filter(|mode| mode.is_null()).count();
    assert!(missing > 0 && rigid.len() >= missing, "{plane} {err}");
    // Each stands where the tool is most compliant.
    let frf = ["frf", "--from", "5", "--to", "150", "--points", "3000"];
    let (_, out, _) = muspin(&[&frf[..], &file, &MACHINE].concat(), folder.path());
    let mut lines = out.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = header.iter().position(|name| *name == "t_xx_re").unwrap();
    let curve: Vec<(f64, f64)> = lines
        .map(|line| {
            let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            (row[0], row[at].hypot(row[at + 1]))
        })
        .collect();
    let peaks: Vec<f64> = curve.windows(3).filter(|w| w[1].1 > w[0].1 && w[1].1 > w[2].1).map(|w| w[1].0).collect();
    for mode in rigid.iter().filter(|mode| mode["damping_ratio"].as_f64().unwrap() < 0.1) {
        let hz = mode["frequency_hz"].as_f64().unwrap();
        assert!(peaks.iter().any(|peak| (peak / hz - 1.0).abs() < 0.05), "{hz} {peaks:?}");
    }
}

/// The band in which stiffness counts bounds neither the sensitivity nor the zone.
#[test]
fn a_band_of_the_stiffness_does_not_bound_the_zone() {
    let folder = folder(NUMBERS);
    let file = folder.path().join("lab.yaml");
    let whole = std::fs::read_to_string(&file).unwrap();
    let numbers = ["pid", "pid.yaml", "--speeds", "0", "--out"];
    let (_, wide, _) = summary(folder.path(), &[numbers.as_slice(), &["a"]].concat());
    std::fs::write(&file, format!("{whole}\nstiffness_band: {{from_hz: 5, to_hz: 20}}\n")).unwrap();
    let (_, narrow, _) = summary(folder.path(), &[numbers.as_slice(), &["b"]].concat());
    let (wide, narrow) = (&wide["sensitivity"]["pid"], &narrow["sensitivity"]["pid"]);
    assert_eq!(wide["zone"], narrow["zone"]);
    for key in ["front_db", "rear_db"] {
        let (a, b) = (wide[key].as_f64().unwrap(), narrow[key].as_f64().unwrap());
        assert!((a - b).abs() < 0.1, "{key}: {a} and {b}");
    }
}

/// Figures at rest and at top speed are of these speeds, whatever speeds are asked for.
#[test]
fn a_comparison_at_rest_has_the_figures_of_the_top_speed() {
    let folder = folder(REFERENCE);
    let (code, _, err) = muspin(&["pid", "pid.yaml", "--out", "o"], folder.path());
    assert!(code < 2, "{err}");
    let compare = |speeds: &[&str], out: &str| {
        let command = ["compare", "--controller", "o/controller/discrete.json", "--out", out];
        let (code, found, err) = muspin(&[command.as_slice(), speeds].concat(), folder.path());
        assert!(code < 2, "{err}");
        serde_json::from_str::<Value>(&found).unwrap()
    };
    let (usual, rest) = (compare(&[], "a"), compare(&["--speeds", "0"], "b"));
    for topic in ["stiffness", "sensitivity"] {
        assert!(usual[topic]["own-pid"]["at_top_speed"].is_object(), "{usual}");
        assert_eq!(usual[topic], rest[topic]);
    }
}
