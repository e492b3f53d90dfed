//! Commands that put controllers and tools side by side.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn reference(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("results/reference")
        .join(file)
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
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let run: Value =
        serde_json::from_slice(&std::fs::read(reference("summary.json")).unwrap()).unwrap();
    for name in ["mu", "pid"] {
        let key = format!("/stiffness/{name}/minimum_n_per_m");
        let (a, b) = (found.pointer(&key).unwrap(), run.pointer(&key).unwrap());
        // The same plant, law and grid; the files hold every digit.
        let ratio = a.as_f64().unwrap() / b.as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 1e-6, "{name}: {ratio}");
        let depth = found
            .pointer(&format!("/chatter/{name}/minimum_depth_m"))
            .unwrap();
        assert!(depth.as_f64().unwrap() > 0.0);
    }
    for file in ["report.html", "plots/stiffness.svg", "plots/chatter.csv"] {
        assert!(out.join(file).is_file(), "{file}");
    }
}

#[test]
fn a_controller_that_does_not_levitate_is_a_missed_target() {
    let temporary = tempfile::tempdir().unwrap();
    // The nominal, not updated, rotor: its modes are up to 18 % from those of the design.
    let output = muspin()
        .arg("compare")
        .arg("--controller")
        .arg(reference("controller/discrete.json"))
        .arg("--out")
        .arg(temporary.path().join("compare"))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        found.pointer("/stability/mu/stable"),
        Some(&Value::Bool(false))
    );
}

#[test]
fn batch_reads_every_tool_before_it_designs_and_writes_nothing_on_error() {
    let temporary = tempfile::tempdir().unwrap();
    let out = temporary.path().join("batch");
    let output = muspin()
        .args(["batch", "--tools", "paper-tool,endmil-10", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        message.contains("endmil-10") && message.contains("hint:"),
        "{message}"
    );
    assert!(!out.exists());
}
