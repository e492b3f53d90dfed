//! `muspin diagnose` on a folder with a record that it cannot use.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// A copy of the folder c03 with the controller of the hammer test unknown.
fn without_controller(folder: &Path) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/diagnosis/c03");
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
    }
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
