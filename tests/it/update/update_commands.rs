//! `muspin identify` and `muspin update` from outside, and what moduli cannot explain.

use crate::rotor::own_spectrum::own_spectrum;
use assert_cmd::Command;
use muspin::input::{load_machine, load_measurement};
use muspin::spindle::{Effect, EffectKind, Location};
use muspin::update::{Method, Target, UpdateSettings, front_and_rear, gauss_newton, nelder_mead};
use serde_json::Value;
use std::path::Path;

fn muspin() -> Command {
    Command::cargo_bin("muspin").unwrap()
}

fn c03() -> String {
    format!("{}/tests/data/identify/c03", env!("CARGO_MANIFEST_DIR"))
}

fn json(output: &[u8]) -> Value {
    serde_json::from_slice(output).unwrap()
}

#[test]
fn timings_list_the_stages_of_an_updating() {
    let out = tempfile::tempdir().unwrap();
    let mut command = muspin();
    let run = command.args(["update", "--resonances-only", "--timings", "--out"]);
    let run = run.arg(out.path()).output().unwrap();
    let table = String::from_utf8(run.stderr).unwrap();
    for stage in ["stage", "records", "fit ", "fit of resonances only", "report", "in all"] {
        let found = table.lines().any(|line| line.starts_with(stage));
        assert!(found, "{stage}: {table}");
    }
    // Standard output keeps the answer alone.
    assert!(json(&run.stdout)["updating"].is_object());
}

/// What a command that succeeds prints; its files go to `out`.
fn answer(arguments: &[&str], out: &Path) -> Value {
    let mut command = muspin();
    let run = command.args(arguments).arg("--out").arg(out).output();
    let run = run.unwrap();
    let errors = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{errors}");
    json(&run.stdout)
}

#[test]
fn both_methods_meet_the_published_frequencies_within_a_thousandth() {
    for method in ["gauss-newton", "nelder-mead"] {
        let out = tempfile::tempdir().unwrap();
        let answer = answer(&["update", "--method", method], out.path());
        let updating = &answer["updating"];
        assert_eq!(updating["method"], method);
        let percent = &updating["errors_percent"];
        let zeros = &percent["antiresonances"];
        let all: Vec<f64> = [&percent["resonances"], &zeros["front"], &zeros["rear"]]
            .iter()
            .flat_map(|l| l.as_array().unwrap())
            .map(|v| v.as_f64().unwrap())
            .collect();
        assert_eq!(all.len(), 8);
        assert!(all.iter().all(|e| e.abs() < 0.1), "{all:?}");
        let evaluations = updating["evaluations"].as_u64().unwrap();
        if method == "gauss-newton" {
            assert!(evaluations <= 30, "{evaluations}");
        } else {
            assert!(updating["iterations"].as_u64().unwrap() <= 500);
        }
        assert_eq!(updating["modulus_factors"].as_object().unwrap().len(), 15);
        // The written spindle shows the published resonances with the full model.
        let spindle = out.path().join("spindle.yaml");
        let modes = muspin().args(["modes", "--speeds", "0", "--spindle"]).arg(&spindle).output().unwrap();
        let found = &json(&modes.stdout)["speeds"][0]["natural_frequencies_hz"];
        for (k, f) in [1069.0, 1955.0, 3210.0].iter().enumerate() {
            let model = found[2 * k].as_f64().unwrap();
            assert!((model / f - 1.0).abs() < 1e-3, "{model} {f}");
        }
        let summary = std::fs::read(out.path().join("summary.json")).unwrap();
        assert_eq!(json(&summary), answer);
        for plot in ["modulus_factors", "determinability", "frequency_errors", "mode_shapes"] {
            for end in ["svg", "csv"] {
                assert!(out.path().join(format!("plots/{plot}.{end}")).is_file());
            }
        }
    }
}

#[test]
fn resonances_only_leaves_antiresonances_off() {
    let out = tempfile::tempdir().unwrap();
    let updating = &answer(&["update", "--resonances-only"], out.path())["updating"];
    let largest = |v: &Value, list: &str| -> f64 {
        let of = |l: &Value| l.as_array().unwrap().iter().map(|v| v.as_f64().unwrap().abs()).fold(0.0, f64::max);
        let percent = &v["errors_percent"];
        if list.is_empty() { of(&percent["resonances"]) } else { of(&percent["antiresonances"][list]) }
    };
    assert!(largest(updating, "") < 0.01);
    assert!(largest(updating, "front") > 0.5 && largest(updating, "rear") > 0.5);
    assert!(largest(&updating["full_update"], "front") < 0.01);
    let table = std::fs::read_to_string(out.path().join("errors.csv")).unwrap();
    assert_eq!(table.lines().count(), 9);
    assert!(table.contains("resonances_only_error_percent") && table.contains("full_error_hz"));
}

#[test]
fn a_sweep_is_identified_first_and_then_updated() {
    let out = tempfile::tempdir().unwrap();
    let answer = answer(&["update", "--measurement", &c03()], out.path());
    assert_eq!(answer["identification"]["resonances_hz"].as_array().unwrap().len(), 3);
    assert!(answer["updating"]["largest_error_percent"].as_f64().unwrap() < 0.1);
    assert_eq!(answer["updating"]["noise_estimated"], false);
    // Cross FRFs and the hammer test at the tool were not used: the updated model predicts them.
    let updating = &answer["updating"];
    assert_eq!(updating["held_out"], serde_json::json!(["13", "31"]));
    for name in ["13", "31"] {
        let list = updating["errors_percent"]["antiresonances"][name].as_array().unwrap();
        assert!(!list.is_empty());
        for e in list.iter().filter_map(Value::as_f64) {
            assert!(e.abs() < 1.0, "{name}: {e} %");
        }
    }
    assert_eq!(answer["verdict"]["met"], true);
    let page = std::fs::read_to_string(out.path().join("report.html")).unwrap();
    assert!(page.contains("Errors of the model") && page.contains("the moduli explain the data"));
    let tool = &updating["held_out_tool_frf"][0];
    assert!(tool["after_db_rms"].as_f64().unwrap() < 1.5, "{tool}");
}

#[test]
fn identify_prints_peaks_and_writes_frfs() {
    let out = tempfile::tempdir().unwrap();
    let found = &answer(&["identify", "--measurement", &c03()], out.path())["identification"];
    assert_eq!(found["antiresonances_hz"]["front"].as_array().unwrap().len(), 3);
    let frf = std::fs::read_to_string(out.path().join("frf-0.csv")).unwrap();
    // frequency, 16 entries, 136 covariances, complex.
    assert_eq!(frf.lines().next().unwrap().split(',').count(), 1 + 2 * (16 + 136));
    assert!(out.path().join("hammer-0.uff").is_file());
}

#[test]
fn bad_measurements_are_one_message_and_write_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let check = |yaml: &str, words: &[&str]| {
        std::fs::write(folder.path().join("measurement.yaml"), yaml).unwrap();
        for command in ["identify", "update"] {
            let run =
                muspin().arg(command).arg("--measurement").arg(folder.path()).arg("--out").arg(&out).output().unwrap();
            let text = String::from_utf8_lossy(&run.stderr).to_string();
            assert_eq!(run.status.code(), Some(2), "{text}");
            // A list tells all that is wrong with it.
            assert!(text.starts_with("error:"), "{text}");
            assert!(text.contains("hint:"), "{text}");
            for word in words {
                assert!(text.contains(word), "{word}: {text}");
            }
            assert!(run.stdout.is_empty() && !out.exists());
        }
    };
    let head = "spindle: reference\ntool: paper-tool\nrecords:\n";
    let record = |r: &str| format!("{head}  - {{{r}}}\n");
    check(&record("kind: sweeep, file: a.csv, speed_rpm: 0"), &["records[0].kind", "sweep"]);
    check(&record("kind: sweep, file: a.csv, speed_rpm: 0"), &["records[0].file", "a.csv"]);
    check(&record("kind: sweep, file: a.csv, sped_rpm: 0"), &["measurement.yaml:4", "speed_rpm"]);
    check(&format!("{head} []\n"), &["measurement.yaml"]);
    check("tool: paper-tool\nrecords: []\n", &["measurement.yaml", "spindle"]);
    std::fs::write(folder.path().join("a.csv"), "frequency_hz,experiment\n50,1\n").unwrap();
    check(&record("kind: sweep, file: a.csv, speed_rpm: 0"), &["a.csv:1", "repeat"]);
    check(&record("kind: sweep, file: a.csv"), &["records[0].speed_rpm"]);
    std::fs::write(folder.path().join("f.yaml"), "resonances_hz: [1069, -3]\n").unwrap();
    check(&record("kind: frequencies, file: f.yaml"), &["f.yaml", "resonances_hz[1]"]);
    std::fs::write(folder.path().join("psd.uff"), "    -1\n    58\n").unwrap();
    check(&record("kind: hammer, file: psd.uff, speed_rpm: 0"), &["psd.uff", "header"]);
}

#[test]
fn what_moduli_cannot_explain_is_said_and_does_not_bend_them() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    // A soft taper, which no modulus of an element beside it can imitate in eleven frequencies.
    let joint = Effect::new(EffectKind::ToolJoint, Location::None, vec![2.5e8, 1.2e5, 0.0]);
    let truth = machine.with_effect(joint.unwrap());
    let seen = own_spectrum(&truth, 100.0, 4000.0);
    let list = |l: &[f64]| l.iter().map(|f| Some(Target::free(*f, Some(1e-4 * f)))).collect();
    let targets = front_and_rear(&machine, list(&seen.poles_hz), list(&seen.zeros_hz[0]), list(&seen.zeros_hz[1]));
    let u = gauss_newton(&machine, &targets, &UpdateSettings::default()).unwrap();
    println!("{} {:?}", u.fit.explanation.statement, u.fit.factors);
    assert!(!u.fit.explanation.explained);
    assert!(u.fit.explanation.statement.contains("cannot explain"));
    assert!(u.fit.factors.iter().all(|f| (0.2..5.0).contains(&f.factor)));
}

#[test]
fn library_entry_points_scale_the_elements_of_spindle_and_tool() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let read = &load_measurement("paper-frequencies").unwrap().frequencies[0];
    let list = |l: &[Option<f64>]| l.iter().map(|f| f.map(Target::read_off)).collect();
    let targets = front_and_rear(&machine, list(&read.resonances_hz), list(&read.front_hz), list(&read.rear_hz));
    let settings = UpdateSettings::default();
    for u in [gauss_newton(&machine, &targets, &settings).unwrap(), nelder_mead(&machine, &targets, &settings).unwrap()]
    {
        for section in &u.machine.spindle.sections {
            let factor = section.region.as_ref().map_or(1.0, |r| u.fit.factor(r));
            assert!((section.modulus_scale - factor).abs() < 1e-12);
        }
        assert!(u.fit.determined.rank() >= 8);
        assert_eq!(u.fit.factors[0].standard_deviation_ln.is_some(), u.fit.method == Method::GaussNewton);
    }
}

/// The folder c03 with every number of the sweep's columns that `belongs` picks multiplied by `factor`.
fn scaled_sweep(folder: &Path, belongs: impl Fn(&str) -> bool, factor: f64) {
    for file in std::fs::read_dir(c03()).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.join(file.file_name())).unwrap();
    }
    let path = folder.join("sweep-0.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let row = |line: &str| {
        let cells = line.split(',').zip(&header).map(|(cell, name)| {
            if belongs(name) { format!("{:e}", cell.parse::<f64>().unwrap() * factor) } else { cell.to_owned() }
        });
        cells.collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = text.lines().skip(1).map(row).collect();
    std::fs::write(&path, header.join(",") + "\n" + &rows.join("\n") + "\n").unwrap();
}

#[test]
fn a_sweep_in_micrometres_is_named_by_identify_and_refused_by_update() {
    let folder = tempfile::tempdir().unwrap();
    scaled_sweep(folder.path(), |name| name.starts_with('y'), 1e6);
    let run = |command: &str, out: &Path| {
        let mut muspin = muspin();
        muspin.args([command, "--measurement"]).arg(folder.path());
        muspin.arg("--out").arg(out).output().unwrap()
    };
    let out = tempfile::tempdir().unwrap();
    let identified = run("identify", out.path());
    assert_eq!(identified.status.code(), Some(1));
    let errors = String::from_utf8(identified.stderr).unwrap();
    let first = errors.lines().next().unwrap();
    assert!(first.contains("sweep-0.csv: the record is implausible") && first.contains("µm, not m"), "{errors}");
    let answer = json(&identified.stdout);
    assert!(answer["identification"].is_null());
    let found = &answer["plausibility"];
    assert_eq!(found["plausible"], false);
    let fault = &found["record_faults"][0];
    assert_eq!(fault["record"], "sweep-0.csv");
    assert_eq!(fault["fault"], "unit");
    assert_eq!(fault["signal"], "y");
    assert_eq!(fault["factor"], 1e6);
    assert!(fault["channel"].is_null());
    let checks = found["checks"].as_array().unwrap();
    let gain = checks.iter().find(|c| c["name"] == "static_gain").unwrap();
    assert_eq!(gain["ok"], false);
    assert!((gain["value"].as_f64().unwrap().log10() - 6.0).abs() < 0.1);
    let written = std::fs::read(out.path().join("plausibility.json")).unwrap();
    assert_eq!(&json(&written), found);

    let checked = muspin().arg("check").arg(folder.path()).output().unwrap();
    assert_eq!(checked.status.code(), Some(1));
    let verdict = String::from_utf8(checked.stdout).unwrap();
    assert!(verdict.ends_with("measurement implausible\n"), "{verdict}");

    let out = out.path().join("update");
    let updated = run("update", &out);
    assert_eq!(updated.status.code(), Some(2));
    assert!(!out.exists());
    let errors = String::from_utf8(updated.stderr).unwrap();
    assert!(errors.starts_with("error: ") && errors.contains("µm, not m"), "{errors}");
}

#[test]
fn a_hammer_test_in_accelerance_is_a_record_fault_of_the_diagnosis() {
    let folder = tempfile::tempdir().unwrap();
    scaled_sweep(folder.path(), |_| false, 1.0);
    let path = folder.path().join("hammer-0.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let row = |line: &str| {
        let mut cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        let omega = std::f64::consts::TAU * cells[0];
        // x'' / F = (jω)² x / F.
        cells[1] *= -omega * omega;
        cells[2] *= -omega * omega;
        let cells: Vec<String> = cells.iter().map(|c| format!("{c:e}")).collect();
        cells.join(",")
    };
    let mut lines = text.lines().filter(|l| !l.is_empty());
    let header = lines.next().unwrap();
    let rows: Vec<String> = lines.map(row).collect();
    std::fs::write(&path, format!("{header}\n{}\n", rows.join("\n"))).unwrap();
    let out = tempfile::tempdir().unwrap();
    let mut command = muspin();
    command.args(["diagnose", "--measurement"]).arg(folder.path());
    let run = command.arg("--out").arg(out.path()).output().unwrap();
    let errors = String::from_utf8(run.stderr).unwrap();
    let first = errors.lines().next().unwrap();
    assert!(first.contains("hammer-0.csv") && first.contains("accelerance, not compliance"), "{errors}");
    let answer = json(&run.stdout);
    let faults = answer["diagnosis"]["record_faults"].as_array().unwrap();
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(faults[0]["record"], "hammer-0.csv");
    assert_eq!(faults[0]["fault"], "unit");
    assert_eq!(faults[0]["signal"], "h");
    assert_eq!(faults[0]["quantity"], "accelerance");
    assert!(faults[0]["factor"].is_null());
}

#[test]
fn a_right_sweep_passes_every_check() {
    let out = tempfile::tempdir().unwrap();
    let found = answer(&["identify", "--measurement", &c03()], out.path());
    let found = &found["plausibility"];
    assert_eq!(found["plausible"], true);
    assert_eq!(found["record_faults"].as_array().unwrap().len(), 0);
    let checks = found["checks"].as_array().unwrap();
    assert!(checks.iter().all(|c| c["ok"] == true), "{checks:?}");
    for name in ["static_gain", "low_frequency_phase", "reciprocity", "controller"] {
        assert!(checks.iter().any(|c| c["name"] == name), "{name}");
    }
}
