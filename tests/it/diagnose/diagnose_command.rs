//! `muspin diagnose` on a folder with a record that it cannot use.

use muspin::input::{load_controller, load_machine};
use muspin::pipeline::comparison::predict;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// A copy of a folder of `tests/data/diagnosis`.
fn copy_records(name: &str, folder: &Path) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/diagnosis").join(name);
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
    }
}

/// A copy of the folder c03 with the controller of the hammer test unknown.
fn without_controller(folder: &Path) {
    copy_records("c03", folder);
    let file = folder.join("measurement.yaml");
    let text = std::fs::read_to_string(&file).unwrap();
    let (sweep, hammer) = text.split_once("- kind: hammer").unwrap();
    let hammer = hammer.replace("controller: pid.json", "controller: null");
    let sweep = sweep.replace("controller: pid.json", "controller: null");
    std::fs::write(&file, format!("{sweep}- kind: hammer{hammer}")).unwrap();
}

#[test]
fn a_hammer_test_under_an_unknown_controller_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    without_controller(folder.path());
    let out = folder.path().join("out");
    let run = |command: &str| {
        Command::new(env!("CARGO_BIN_EXE_muspin"))
            .args([command, "--measurement"])
            .arg(folder.path())
            .arg("--out")
            .arg(out.join(command))
            .output()
            .unwrap()
    };
    // Identification needs currents and signals only.
    let identified = run("identify");
    assert_eq!(identified.status.code(), Some(0), "{identified:?}");
    let diagnosed = run("diagnose");
    assert_eq!(diagnosed.status.code(), Some(0), "{diagnosed:?}");
    let said = String::from_utf8(diagnosed.stderr).unwrap();
    assert!(said.contains("hammer-0.csv is left out"), "{said}");
    let text = std::fs::read_to_string(out.join("diagnose/summary.json")).unwrap();
    let diagnosis = &serde_json::from_str::<Value>(&text).unwrap()["diagnosis"];
    assert_eq!(diagnosis["verdict"], "adequate");
    assert_eq!(diagnosis["left_out"][0]["record"], "hammer-0.csv");
    assert_eq!(diagnosis["held_out"], "rear sensors from front currents");
}

/// A loop that is 30 µs slower than its file: what is said of the controller is what it does on the given machine and on
/// the corrected one, at the speed of the hammer test.
#[test]
fn a_diagnosis_ends_with_what_the_controller_does_on_both_machines() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/diagnosis/c01");
    let out = tempfile::tempdir().unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_muspin"));
    let ended = program.args(["diagnose", "--measurement"]).arg(&folder).arg("--out").arg(out.path()).output().unwrap();
    let text = std::fs::read_to_string(out.path().join("summary.json")).unwrap();
    let said = &serde_json::from_str::<Value>(&text).unwrap()["diagnosis"]["consequence"];
    assert_eq!(said["record"], "hammer-0.csv");
    let words = said["sentence"].as_str().unwrap();
    assert!(String::from_utf8(ended.stderr).unwrap().contains(words), "{words}");
    let controller = load_controller(folder.join("pid.json").to_str().unwrap()).unwrap();
    let rpm = said["speed_rpm"].as_f64().unwrap();
    let mut growth = vec![];
    for (name, files) in [("given", folder.as_path()), ("corrected", out.path())] {
        let [spindle, tool] = ["spindle.yaml", "tool.yaml"].map(|file| files.join(file));
        let machine = load_machine(spindle.to_str().unwrap(), tool.to_str().unwrap()).unwrap();
        let expected = predict(&machine, &controller, rpm).unwrap();
        let close = |key: &str, value: f64| {
            let found = said[name][key].as_f64().unwrap();
            assert!((found / value - 1.0).abs() < 1e-6, "{name} {key}: {found} {value}");
        };
        close("growth_rate_per_s", expected.growth_rate_per_s);
        close("least_stiffness_n_per_m", expected.minimum.0);
        growth.push(expected.growth_rate_per_s);
    }
    // The delay moves the poles.
    assert!((growth[0] / growth[1] - 1.0).abs() > 1e-3, "{growth:?}");
}

/// A pole at 1e28 1/s changes nothing in the band, but no sample rate has a form of it: what the controller does on the
/// corrected machine is left open, and the effect is named all the same.
#[test]
fn a_controller_without_a_discrete_form_does_not_end_a_diagnosis() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    copy_records("c01", folder);
    let file = folder.join("pid.json");
    let mut law: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    let states = law["A"].as_array().unwrap().len();
    let rows = |law: &mut Value, key: &str, last: &[f64; 4]| {
        for (i, row) in law[key].as_array_mut().unwrap().iter_mut().enumerate() {
            row.as_array_mut().unwrap().push(last.get(i).copied().unwrap_or(0.0).into());
        }
    };
    rows(&mut law, "A", &[0.0; 4]);
    rows(&mut law, "C", &[1e-6, 0.0, 0.0, 0.0]);
    let mut fast = vec![0.0; states];
    fast.push(-1e28);
    law["A"].as_array_mut().unwrap().push(fast.into());
    law["B"].as_array_mut().unwrap().push(vec![1e28, 0.0, 0.0, 0.0].into());
    std::fs::write(&file, law.to_string()).unwrap();
    let [spindle, tool] = ["spindle.yaml", "tool.yaml"].map(|own| folder.join(own));
    let machine = load_machine(spindle.to_str().unwrap(), tool.to_str().unwrap()).unwrap();
    assert!(predict(&machine, &load_controller(file.to_str().unwrap()).unwrap(), 0.0).is_err());
    let mut program = Command::new(env!("CARGO_BIN_EXE_muspin"));
    let ended = program.args(["diagnose", "--json", "--measurement"]).arg(folder).arg("--out").arg(folder.join("d"));
    let text = String::from_utf8(ended.output().unwrap().stdout).unwrap();
    let diagnosis = &serde_json::from_str::<Value>(&text).unwrap()["diagnosis"];
    assert_eq!(diagnosis["verdict"], "named");
    assert_eq!(diagnosis["effects"][0]["effect"], "loop_delay");
}

/// Tests of several seconds each: `cargo test --release --test it long:: -- --ignored`.
mod long {
    use super::*;

    /// Folders of a second simulator with its own mesh: a thrust disc of −3e5 N m/rad at 0.2325 m, and a sweep at 30 000 rpm
    /// whose record says 15 000.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn what_another_simulator_hides_is_named_with_its_numbers() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/diagnosis");
        let out = tempfile::tempdir().unwrap();
        let diagnosis = |name: &str| {
            let folder = root.join(name);
            let run = Command::new(env!("CARGO_BIN_EXE_muspin"))
                .args(["diagnose", "--measurement"])
                .arg(&folder)
                .arg("--spindle")
                .arg(folder.join("spindle.yaml"))
                .arg("--tool")
                .arg(folder.join("tool.yaml"))
                .arg("--out")
                .arg(out.path().join(name))
                .output()
                .unwrap();
            assert_eq!(run.status.code(), Some(0), "{run:?}");
            let text = std::fs::read_to_string(out.path().join(name).join("summary.json")).unwrap();
            serde_json::from_str::<Value>(&text).unwrap()["diagnosis"].clone()
        };
        let disc = diagnosis("c19");
        assert_eq!(disc["verdict"], "named");
        assert_eq!(disc["effects"].as_array().unwrap().len(), 1);
        let effect = &disc["effects"][0];
        assert_eq!(effect["effect"], "tilting_stiffness");
        let stiffness = effect["parameters"]["stiffness_n_m_per_rad"].as_f64().unwrap();
        assert!((stiffness / -3e5 - 1.0).abs() < 0.02, "{stiffness}");
        let position_m = effect["where"]["position_m"].as_f64().unwrap();
        assert!((position_m - 0.2325).abs() < 2e-3, "{position_m}");
        let label = diagnosis("c15");
        assert_eq!(label["verdict"], "named");
        assert!(label["effects"].as_array().unwrap().is_empty());
        let fault = &label["record_faults"][0];
        assert_eq!(fault["fault"], "speed_label");
        let speed_rpm = fault["speed_rpm"].as_f64().unwrap();
        assert!((speed_rpm / 30_000.0 - 1.0).abs() < 1e-3, "{speed_rpm}");
    }
}
