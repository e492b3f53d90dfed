//! What commands say at their end: data in a pipe, sentences with `--text`, JSON with `--json`, nothing with `--quiet`.

use crate::cli::program::muspin;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn here() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn every_command_without_output_folder_has_a_text_and_a_json_answer() {
    let cases: [&[&str]; 6] = [
        &["modes"],
        &["frf", "--points", "5"],
        &["check", "weights/benchmark.yaml", "spindles/reference.yaml"],
        &["identify", "--measurement", "tests/data/diagnosis/c01"],
        &["solve", "mu", "src/cli/examples/mu.json"],
        &["solve", "hinfsyn", "src/cli/examples/hinfsyn.json"],
    ];
    for case in cases {
        let with = |option: &str| {
            let mut arguments = case.to_vec();
            arguments.push(option);
            muspin(&arguments, &here())
        };
        let (plain, _, error) = muspin(case, &here());
        let (code, text, _) = with("--text");
        assert_eq!(code, plain, "{case:?} {error}");
        let first = text.lines().next().unwrap_or_default();
        assert!(first.starts_with("done: ") || first.starts_with("target missed: "), "{case:?}: {first}");
        assert!(text.lines().count() < 40, "{case:?}: {} lines", text.lines().count());
        assert!(!text.contains('\u{1b}'), "{case:?}: no colours without a terminal");
        let (code, json, _) = with("--json");
        assert_eq!(code, plain, "{case:?}");
        let parsed: Result<Value, _> = serde_json::from_str(&json);
        assert!(parsed.is_ok_and(|v| v.is_object()), "{case:?}: {json}");
        let (code, nothing, _) = with("--quiet");
        assert_eq!((code, nothing.as_str()), (plain, ""), "{case:?}");
    }
}

/// What other programs read in a pipe has not changed with `--json`.
#[test]
fn a_pipe_has_the_data_as_before() {
    let (_, piped, _) = muspin(&["modes", "--speeds", "0,10000"], &here());
    let (_, json, _) = muspin(&["modes", "--speeds", "0,10000", "--json"], &here());
    assert_eq!(piped, json);
    let (_, piped, _) = muspin(&["frf", "--points", "3"], &here());
    assert!(piped.starts_with("frequency_hz,g_11_re,g_11_im,"), "{piped}");
    assert_eq!(piped.lines().count(), 4);
    let (_, json, _) = muspin(&["frf", "--points", "3", "--json"], &here());
    let columns: Value = serde_json::from_str(&json).unwrap();
    let header: Vec<&str> = piped.lines().next().unwrap().split(',').collect();
    let row: Vec<f64> = piped.lines().nth(2).unwrap().split(',').map(|c| c.parse().unwrap()).collect();
    for (name, value) in header.iter().zip(row) {
        assert_eq!(columns[name][1].as_f64().unwrap(), value, "{name}");
    }
    let (_, lines, _) = muspin(&["check", "weights/benchmark.yaml"], &here());
    assert_eq!(lines, "weights/benchmark.yaml: weights ok\n");
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let run = |threads: &str| {
        let arguments = ["identify", "--measurement", "tests/data/diagnosis/c01", "--threads", threads];
        muspin(&arguments, &here())
    };
    let (one, two) = (run("1"), run("2"));
    assert_eq!(one.0, 0, "{}", one.2);
    assert_eq!(one.1, two.1);
    // More threads than the machine can use are not started.
    let many = run("1000");
    assert_eq!((many.0, &many.1), (0, &one.1), "{}", many.2);
    assert!(many.2.contains("warning: 1000 threads"), "{}", many.2);
    for wrong in ["0", "1000000"] {
        let (code, out, error) = run(wrong);
        assert_eq!((code, out.as_str()), (2, ""), "{error}");
        assert!(error.contains("--threads"), "{error}");
    }
}

#[test]
fn answers_exclude_each_other() {
    let (code, out, error) = muspin(&["modes", "--json", "--text"], &here());
    assert_eq!((code, out.as_str()), (2, ""), "{error}");
}

/// Interrupts `muspin` with the signal of Ctrl-C while it computes.
#[cfg(unix)]
#[test]
fn an_interrupted_command_says_that_nothing_was_written() {
    let temporary = tempfile::tempdir().unwrap();
    let folder: &Path = temporary.path();
    let child = Command::new(assert_cmd::cargo::cargo_bin("muspin"))
        .args(["design", "--out", "o"])
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A design takes many times longer than this, and the handler is set in the first milliseconds.
    std::thread::sleep(Duration::from_millis(700));
    let started = Instant::now();
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    assert!(started.elapsed() < Duration::from_secs(5), "ends at once");
    assert_eq!(output.status.code(), Some(130));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("interrupted: nothing was written"), "{error}");
    assert!(output.stdout.is_empty() && !folder.join("o").exists());
}

#[test]
fn the_program_alone_says_how_to_begin_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text, error) = muspin(&[], folder.path());
    assert_eq!((code, error.as_str()), (0, ""));
    for way in ["Usage", "muspin run ", "muspin init my-spindle", "muspin modes --spindle my-spindle/spindle.yaml"] {
        assert!(text.contains(way), "{way}: {text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// A debug build has no commit, a release build has that of the repository; neither says that it has none.
#[test]
fn the_version_names_no_commit_that_is_not_known() {
    let (code, text, _) = muspin(&["--version"], &here());
    assert_eq!(code, 0);
    assert!(text.starts_with(&format!("muspin {} (", env!("CARGO_PKG_VERSION"))), "{text}");
    assert!(!text.contains("not recorded"), "{text}");
    assert!(text.contains("debug build") || !here().join(".git").exists() || text.contains("(commit "), "{text}");
}

#[test]
fn speeds_are_lists_ranges_and_both() {
    let list = |option: &str, value: &str| -> Vec<f64> {
        let (code, json, error) = muspin(&["modes", option, value], &here());
        assert_eq!(code, 0, "{error}");
        let answer: Value = serde_json::from_str(&json).unwrap();
        answer["speeds"].as_array().unwrap().iter().map(|s| s["speed_rpm"].as_f64().unwrap()).collect()
    };
    assert_eq!(list("--speeds", "0:1000:3000"), [0.0, 1000.0, 2000.0, 3000.0]);
    assert_eq!(list("--speeds", "0:2000:5000"), [0.0, 2000.0, 4000.0]);
    assert_eq!(list("--speed", "7,0:500.5:1001,9e3"), [7.0, 0.0, 500.5, 1001.0, 9000.0]);
    // Three tenths are no sum of tenths in binary numbers.
    assert_eq!(list("--speeds", "0:0.1:0.3").len(), 4);
}

#[test]
fn speeds_that_are_none_are_refused_in_words() {
    let cases = [
        ("modes", "0:1000", "is no range"),
        ("modes", "0:1:2:3", "is no range"),
        ("modes", "0:0:1000", "the step is above zero"),
        ("modes", "2000:100:1000", "the end not below the start"),
        ("modes", "0:1:100000", "more than 1000 speeds"),
        ("modes", "fast", "`fast` is no speed in rpm"),
        ("compare", "NaN", "`NaN` is no speed in rpm"),
        ("rehearse", "", "`` is no speed in rpm"),
        ("frf", "0,1000", "2 speeds are given; this command computes at one speed"),
    ];
    for (command, speeds, words) in cases {
        let (code, out, error) = muspin(&[command, &format!("--speeds={speeds}")], &here());
        assert_eq!((code, out.as_str()), (2, ""), "{command} {speeds}");
        assert!(error.contains("--speeds") && error.contains(words), "{command} {speeds}: {error}");
    }
}
