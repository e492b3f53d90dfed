//! Commands that put controllers and tools side by side.

use crate::support::folder::tree;
use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn reference(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("results/reference").join(file)
}

fn muspin() -> Command {
    Command::cargo_bin("muspin").unwrap()
}

#[test]
fn compare_shows_what_the_reference_run_found() {
    let temporary = tempfile::tempdir().unwrap();
    let out = temporary.path().join("compare");
    let output = muspin()
        .arg("compare")
        .arg("--spindle")
        .arg(reference("spindle.yaml"))
        .arg("--controller")
        .arg(reference("controller/discrete.json"))
        .arg("--controller")
        .arg(reference("controller/pid.json"))
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let run: Value = serde_json::from_slice(&std::fs::read(reference("summary.json")).unwrap()).unwrap();
    for name in ["mu", "pid"] {
        let key = format!("/stiffness/{name}/minimum_n_per_m");
        let (a, b) = (found.pointer(&key).unwrap(), run.pointer(&key).unwrap());
        // The same plant, law and grid; the files hold every digit.
        let ratio = a.as_f64().unwrap() / b.as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 1e-6, "{name}: {ratio}");
        let depth = found.pointer(&format!("/chatter/{name}/minimum_depth_m")).unwrap();
        assert!(depth.as_f64().unwrap() > 0.0);
        // Worst cases: rest, quarters and the top speed, then the least of them; bounds in order, the nominal value
        // above them.
        let cases = found.pointer(&format!("/worst_case/{name}")).unwrap();
        let (over_speed, cases) = cases.as_array().unwrap().split_last().unwrap();
        assert_eq!(cases.len(), 5);
        let least = over_speed.pointer("/least_stiffness/not_below_n_per_m");
        let least = least.unwrap().as_f64().unwrap();
        let mut smallest = f64::INFINITY;
        for case in cases {
            assert_eq!(case["stable_at_corners"], true);
            for axis in ["x", "y"] {
                let minimum = &case["stiffness"][axis]["minimum"];
                let figure = |key: &str| minimum[key].as_f64().unwrap();
                let (below, attained) = (figure("not_below_n_per_m"), figure("attained_n_per_m"));
                assert!(below <= attained && attained < 1.005 * below, "{minimum}");
                smallest = smallest.min(below);
                let nominal = a.as_f64().unwrap();
                assert!(case["speed_rpm"] != 0.0 || below <= nominal * (1.0 + 1e-6), "{case}");
            }
        }
        assert_eq!(least, smallest);
        // The statements of figure 9.
        let first = found.pointer(&format!("/tool_plane/{name}/0")).unwrap();
        let ten = first["tool_stiffness"]["x"]["at_10_hz_n_per_m"].as_f64().unwrap();
        let same = found.pointer(&format!("/stiffness/{name}/at_10_hz_n_per_m")).unwrap();
        assert!((ten / same.as_f64().unwrap() - 1.0).abs() < 1e-9);
        assert_eq!(first["flexible_modes"].as_array().unwrap().len(), 3);
        assert!(first["flexible_modes"][0]["damping_ratio"].as_f64().unwrap() > 0.0);
    }
    let ratio = found.pointer("/stiffness_ratio/mu_over_pid/0/minimum").unwrap();
    assert!(ratio.as_f64().unwrap() > 0.0);
    for file in [
        "report.html",
        "plots/stiffness.svg",
        "plots/stiffness_worst.csv",
        "plots/sensitivity_worst.svg",
        "plots/chatter.csv",
    ] {
        assert!(out.join(file).is_file(), "{file}");
    }
}

#[test]
fn a_hammer_record_stands_beside_the_prediction_of_its_loop() {
    let temporary = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/diagnosis/c01");
    let output = muspin()
        .arg("compare")
        .arg("--spindle")
        .arg(data.join("spindle.yaml"))
        .arg("--tool")
        .arg(data.join("tool.yaml"))
        .arg("--controller")
        .arg(data.join("pid.json"))
        .arg("--measurement")
        .arg(&data)
        .args(["--speeds", "0", "--out"])
        .arg(temporary.path().join("compare"))
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    let found: Value = serde_json::from_slice(&output.stdout).expect(&errors);
    let plane = found["tool_plane"].as_object().unwrap();
    let (_, predicted) = plane.iter().find(|(k, _)| !k.starts_with("measured")).unwrap();
    let (_, measured) = plane.iter().find(|(k, _)| k.starts_with("measured")).unwrap();
    let at = |v: &Value, key: &str| v["tool_stiffness"].get("x").unwrap_or(&v["tool_stiffness"])[key].as_f64();
    // The record has an effect that the model lacks: the same size, not the same number.
    let key = "at_max_speed_n_per_m";
    let ratio = at(measured, key).unwrap() / at(&predicted[0], key).unwrap();
    assert!((0.3..3.0).contains(&ratio), "{ratio}");
    // Modes and lobes of the record itself.
    let modes = measured["modes"].as_array().unwrap();
    assert!(modes.iter().any(|mode| mode["damping_ratio"].as_f64().unwrap() < 0.03), "{modes:?}");
    let chatter = found["chatter"].as_object().unwrap();
    let depth = |is_measured: bool| {
        let (_, own) = chatter.iter().find(|(key, _)| key.starts_with("measured") == is_measured).unwrap();
        own["minimum_depth_m"].as_f64().unwrap()
    };
    assert!((0.2..5.0).contains(&(depth(true) / depth(false))), "{chatter:?}");
}

/// One record in mm/N, one of the same name in another folder, and one that was not taken at the tool.
#[test]
fn hammer_records_are_checked_before_they_are_compared() {
    let temporary = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/diagnosis/c01");
    let folder = temporary.path().join("measurement");
    std::fs::create_dir_all(folder.join("other")).unwrap();
    for file in ["spindle.yaml", "tool.yaml", "pid.json", "hammer-0.csv"] {
        std::fs::copy(data.join(file), folder.join(file)).unwrap();
    }
    let text = std::fs::read_to_string(data.join("hammer-0.csv")).unwrap();
    let scaled = |line: &str| -> String {
        let number = |(k, cell): (usize, &str)| match (k, cell.parse::<f64>()) {
            (1 | 2, Ok(x)) => format!("{:e}", 1e3 * x),
            _ => cell.to_owned(),
        };
        line.split(',').enumerate().map(number).collect::<Vec<_>>().join(",")
    };
    let millimetres: Vec<String> = text.lines().map(scaled).collect();
    std::fs::write(folder.join("other/hammer-0.csv"), millimetres.join("\n")).unwrap();
    let record = |file: &str, more: &str| format!("- {{kind: hammer, file: {file}, speed_rpm: 0, axis: x, {more}}}\n");
    let list = [
        record("hammer-0.csv", "controller: pid.json"),
        record("other/hammer-0.csv", "controller: pid.json"),
        record("hammer-0.csv", "response_m: 0.1, force_m: 0.3"),
    ];
    let head = "spindle: spindle.yaml\ntool: tool.yaml\nrecords:\n";
    std::fs::write(folder.join("measurement.yaml"), format!("{head}{}", list.concat())).unwrap();
    let output = muspin()
        .args(["compare", "--speeds", "0", "--spindle"])
        .arg(data.join("spindle.yaml"))
        .arg("--tool")
        .arg(data.join("tool.yaml"))
        .arg("--controller")
        .arg(data.join("pid.json"))
        .arg("--measurement")
        .arg(&folder)
        .arg("--out")
        .arg(temporary.path().join("compare"))
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("other/hammer-0.csv: the record is implausible") && errors.contains("mm/N"), "{errors}");
    assert!(errors.contains("not taken at the tool plane"), "{errors}");
    let found: Value = serde_json::from_slice(&output.stdout).expect(&errors);
    let keys: Vec<&String> =
        found["tool_plane"].as_object().unwrap().keys().filter(|k| k.contains("measured")).collect();
    assert_eq!(keys, ["measured_hammer-0", "measured_hammer-0_2"], "{errors}");
}

#[test]
fn a_controller_that_does_not_levitate_is_a_missed_target() {
    let temporary = tempfile::tempdir().unwrap();
    // The nominal, not updated, rotor: its modes are up to 18 % from those of the design.
    let output = muspin()
        .arg("compare")
        .args(["--spindle", "reference", "--tool", "paper-tool"])
        .arg("--controller")
        .arg(reference("controller/discrete.json"))
        .arg("--out")
        .arg(temporary.path().join("compare"))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(errors.contains("unstable: the closed loop grows by"), "{errors}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found.pointer("/stability/mu/stable"), Some(&Value::Bool(false)));
}

#[test]
fn batch_reads_every_tool_before_it_designs_and_writes_nothing_on_error() {
    let temporary = tempfile::tempdir().unwrap();
    let out = temporary.path().join("batch");
    let output = muspin().args(["batch", "--tools", "paper-tool,endmil-10", "--out"]).arg(&out).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("endmil-10") && message.contains("hint:"), "{message}");
    assert!(!out.exists());
}

/// Tests of several seconds each: `cargo test --release --test it long:: -- --ignored`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long: see the command of the module"]
    fn tools_of_a_batch_that_run_side_by_side_have_the_bytes_of_one_after_another() {
        let temporary = tempfile::tempdir().unwrap();
        let batch = |name: &str, options: &[&str]| {
            let out = temporary.path().join(name);
            let tools = "endmill-16,paper-tool";
            let command = ["batch", "--tools", tools, "--quick", "--no-polish"];
            let run = muspin().args(command).args(options).arg("--out").arg(&out).output().unwrap();
            let errors = String::from_utf8(run.stderr).unwrap();
            (tree(&out), String::from_utf8(run.stdout).unwrap(), errors)
        };
        let (files, table, errors) = batch("three", &["--threads", "3"]);
        assert_eq!(errors, "");
        // The rows are in the order of the tools.
        let tools: Vec<&str> = table.lines().map(|l| l.split(',').next().unwrap()).collect();
        assert_eq!(tools, ["tool", "endmill-16", "paper-tool"]);
        let (timed, timed_table, timings) = batch("timed", &["--timings", "--threads", "1"]);
        assert_eq!(table, timed_table);
        assert_eq!(files.keys().collect::<Vec<_>>(), timed.keys().collect::<Vec<_>>());
        for (name, bytes) in &files {
            assert!(bytes == &timed[name], "{name} differs");
        }
        // One after another, the stages of both tools are told apart.
        for stage in ["D-K iteration", "worst cases", "report", "in all"] {
            let lines = timings.lines().filter(|l| l.starts_with(stage));
            assert_eq!(lines.count(), 1, "{stage}: {timings}");
        }
    }

    #[test]
    #[ignore = "long: see the command of the module"]
    fn batch_of_one_tool_fills_table_picture_and_folder() {
        let temporary = tempfile::tempdir().unwrap();
        let out = temporary.path().join("batch");
        let output = muspin()
            .args(["batch", "--tools", "endmill-16", "--spindle"])
            .arg(reference("spindle.yaml"))
            .arg("--out")
            .arg(&out)
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{errors}");
        let mut table = csv::Reader::from_reader(output.stdout.as_slice());
        let header = table.headers().unwrap().clone();
        let row = table.records().next().unwrap().unwrap();
        let cell = |name: &str| {
            let place = header.iter().position(|h| h == name).unwrap();
            row.get(place).unwrap().to_owned()
        };
        let number = |name: &str| cell(name).parse::<f64>().unwrap();
        assert_eq!(cell("tool"), "endmill-16");
        assert_eq!(cell("meets_specification"), "true");
        assert!(number("mu_as_specified") <= 1.0);
        for name in ["mu", "pid"] {
            let nominal = number(&format!("minimum_stiffness_{name}_n_per_m"));
            let worst = number(&format!("worst_stiffness_{name}_n_per_m"));
            assert!(worst > 0.0 && worst < nominal * 1.001, "{name}: {worst} {nominal}");
        }
        // A tool that meets the specification is asked for its slack only on demand.
        assert_eq!(cell("largest_tool_tightening"), "");
        for file in [
            "tools.csv",
            "report.html",
            "plots/tools.svg",
            "plots/tools_stiffness.svg",
            "endmill-16/controller.c",
            "endmill-16/pid.json",
        ] {
            assert!(out.join(file).is_file(), "{file}");
        }
    }
}
