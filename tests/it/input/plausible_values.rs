//! Values that cannot be and values that look wrong: said with key, unit and reason, and never on a file that is right.

use assert_cmd::Command;
use muspin::input::keys::{FREQUENCIES, KeyGroup, SPINDLE, TOOL, WEIGHTS};
use muspin::input::kind::FileKind;
use muspin::input::{read_spindle, read_tool, read_weights, shipped, yaml};
use muspin::spindle::mesh_quality::coarse_mesh;
use muspin::spindle::{Machine, Spindle};
use serde_yaml::Value;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const REFERENCE: &str = include_str!("../../../spindles/reference.yaml");
const TOOL_TEXT: &str = include_str!("../../../spindles/tools/paper-tool.yaml");
const WEIGHTS_TEXT: &str = include_str!("../../../weights/benchmark.yaml");

fn edited(from: &str, to: &str) -> String {
    assert!(REFERENCE.contains(from), "{from}");
    REFERENCE.replacen(from, to, 1)
}

fn refusal(from: &str, to: &str) -> String {
    let error = read_spindle("s.yaml", &edited(from, to)).unwrap_err();
    format!("{error} | {}", error.hint.clone().unwrap_or_default())
}

/// Exit code, standard output and standard error of `muspin check` on a spindle.
fn check(text: &str) -> (i32, String, String) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("s.yaml");
    std::fs::write(&path, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_muspin"));
    let output = command.arg("check").arg(&path).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let code = output.status.code().unwrap();
    (code, text(&output.stdout), text(&output.stderr))
}

#[test]
fn impossible_sizes_are_refused_with_the_unit_that_they_look_like() {
    let cases: [(&str, &str, &[&str]); 12] = [
        (
            "youngs_modulus_pa: 2.06e+11",
            "youngs_modulus_pa: 206",
            &["youngs_modulus_pa", "206 looks like GPa", "2.06e11"],
        ),
        ("density_kg_m3: 7850.0", "density_kg_m3: 7.85", &["density_kg_m3", "g/cm³"]),
        (
            "outer_diameter_m: 0.0482",
            "outer_diameter_m: 48.2",
            &["rotor.elements[0].outer_diameter_m", "48.2 looks like mm"],
        ),
        ("length_m: 0.0167", "length_m: 16.7", &["rotor.elements[0].length_m", "looks like mm"]),
        ("delay_s: 7.5e-5", "delay_s: 0.075", &["electronics.delay_s", "0.075 looks like ms", "7.5e-5"]),
        ("delay_s: 7.5e-5", "delay_s: 10", &["electronics.delay_s", "µs"]),
        ("sample_rate_hz: 20000.0", "sample_rate_hz: 1.0e+12", &["electronics.sample_rate_hz"]),
        ("sensor_noise_m: 5.0e-8", "sensor_noise_m: 1.0", &["electronics.sensor_noise_m"]),
        ("max_rpm: 50000.0", "max_rpm: 1.0e+9", &["speed.max_rpm", "bursts"]),
        ("gap_m: 5.0e-4", "gap_m: 0.5", &["bearings.front.gap_m", "looks like mm"]),
        ("backup_clearance_m: 2.54e-4", "backup_clearance_m: 0.254", &["backup_clearance_m", "mm"]),
        ("front_sensor_m: 0.06385", "front_sensor_m: 63.85", &["planes.front_sensor_m", "mm"]),
    ];
    for (from, to, parts) in cases {
        let message = refusal(from, to);
        assert!(message.starts_with("s.yaml:"), "{message}");
        for part in parts {
            assert!(message.contains(part), "no {part:?} in {message}");
        }
    }
}

#[test]
fn values_that_contradict_each_other_are_refused() {
    let cases = [
        (
            "bias_current_a: 3.0",
            "bias_current_a: 9.0",
            "bearings.front.bias_current_a: 9 must be smaller than max_current_a",
        ),
        ("rear_sensor_m: 0.3032", "rear_sensor_m: 0.05", "planes.rear_sensor_m: 0.05 must lie behind front_sensor_m"),
        (
            "rear_actuator_m: 0.3252",
            "rear_actuator_m: 0.1",
            "planes.rear_actuator_m: 0.1 must lie behind front_actuator_m",
        ),
        (
            "backup_clearance_m: 2.54e-4",
            "backup_clearance_m: 6.0e-4",
            "backup_clearance_m: 0.0006 must be smaller than bearings.front.gap_m",
        ),
        (
            "backup_clearance_m: 2.54e-4",
            "backup_clearance_m: 2.54e-4\nstiffness_band: {from_hz: 10, to_hz: 5}",
            "stiffness_band.to_hz: 5 must be larger than stiffness_band.from_hz (10)",
        ),
        ("delay_s: 7.5e-5", "delay_s: 5.0e-3", "electronics.delay_s: 0.005 is 100 sample periods"),
    ];
    for (from, to, part) in cases {
        let message = refusal(from, to);
        assert!(message.contains(part), "no {part:?} in {message}");
    }
}

#[test]
fn odd_sizes_are_used_and_said() {
    for (from, to, part) in [
        ("ks_n_per_m: 1.5e+6", "ks_n_per_m: 1.5", "bearings.front.ks_n_per_m: 1.5 lies outside 1000 to 1e8 N/m"),
        ("damping_ratio: [0.004,", "damping_ratio: [0.4,", "rotor.damping_ratio[0]: 0.4 lies outside"),
    ] {
        let (code, out, warned) = check(&edited(from, to));
        assert_eq!(code, 0, "{warned}");
        assert!(out.contains("spindle ok"), "{out}");
        assert!(warned.starts_with("warning: ") && warned.contains(part), "{warned}");
    }
    assert!(check(&edited("ks_n_per_m: 1.5e+6", "ks_n_per_m: 1.5")).2.contains("looks like N/µm: write 1.5e6"));
    let (code, _, warned) = check(REFERENCE);
    assert_eq!((code, warned.as_str()), (0, ""));
}

#[test]
fn shipped_files_are_plausible_and_every_number_in_them_has_a_range() {
    let shipped: [(&[shipped::Shipped], FileKind, &[KeyGroup]); 4] = [
        (shipped::SPINDLES, FileKind::Spindle, SPINDLE),
        (shipped::TOOLS, FileKind::Tool, TOOL),
        (shipped::WEIGHTS, FileKind::Weights, WEIGHTS),
        (shipped::FREQUENCIES, FileKind::Measurement, FREQUENCIES),
    ];
    for (files, kind, groups) in shipped {
        for file in files {
            assert_eq!(kind.warnings(file.name).unwrap(), [], "{}", file.name);
            let value = yaml::value(file.name, file.text).unwrap();
            for name in numbers(&value) {
                let mut known = groups.iter().flat_map(|g| g.keys);
                let found = known.any(|k| k.name.trim_end_matches("[]") == name);
                assert!(found, "{}: {name} has no range", file.name);
            }
        }
    }
    for group in [SPINDLE, TOOL, WEIGHTS, FREQUENCIES].into_iter().flatten() {
        for key in group.keys {
            let ([a, b], [low, high]) = (key.plausible, key.possible);
            assert!(low <= a && a < b && b <= high, "{}.{}", group.at, key.name);
            assert!(!key.reason.is_empty(), "{}", key.name);
        }
    }
}

/// Keys of all numbers, those in lists under the key of the list.
fn numbers(value: &Value) -> Vec<String> {
    let mut found = vec![];
    let Some(mapping) = value.as_mapping() else {
        return found;
    };
    for (key, value) in mapping {
        let inside = match value {
            Value::Sequence(list) => list.clone(),
            other => vec![other.clone()],
        };
        for entry in inside {
            match entry {
                Value::Number(_) => found.push(key.as_str().unwrap().to_owned()),
                other => found.extend(numbers(&other)),
            }
        }
    }
    found
}

#[test]
fn all_missing_keys_are_named_at_once() {
    let text = edited("  sensor_noise_m: 5.0e-8\n", "").replacen("ki_n_per_a: 270.0, ", "", 1).replacen(
        "speed: {max_rpm: 50000.0}\n",
        "",
        1,
    );
    let error = read_spindle("s.yaml", &text).unwrap_err();
    for path in ["electronics.sensor_noise_m", "bearings.front.ki_n_per_a", "speed"] {
        assert!(error.message.contains(path), "{error}");
    }
    assert!(!error.message.contains("rear"), "{error}");
    let error = read_weights("w.yaml", "name: w\ntool: {max_dc_load_n: 4}\n").unwrap_err();
    for path in ["front", "rear", "mode_uncertainty", "tool.max_hf_load_n"] {
        assert!(error.message.contains(path), "{error}");
    }
    let error = read_spindle("s.yaml", "").unwrap_err();
    assert!(error.message.contains("rotor") && error.message.contains("planes"), "{error}");
}

#[test]
fn byte_order_marks_are_read_over_and_utf_16_is_named() {
    let marked = |text: &str| format!("\u{feff}{text}");
    let spindle = read_spindle("s.yaml", &marked(REFERENCE)).unwrap();
    read_tool("t.yaml", &marked(TOOL_TEXT), &spindle).unwrap();
    read_weights("w.yaml", &marked(WEIGHTS_TEXT)).unwrap();
    let wide: Vec<u8> = marked(TOOL_TEXT).encode_utf16().flat_map(u16::to_le_bytes).collect();
    let error = shipped::utf8("t.yaml", wide).unwrap_err();
    assert!(error.message.contains("UTF-16"), "{error}");
    let uff = [b"\xef\xbb\xbf".to_vec(), include_bytes!("../../fuzz/corpus/uff/frf.uff").to_vec()].concat();
    assert_eq!(muspin::input::uff::read("f.uff", &uff).unwrap().len(), 1);
}

#[test]
fn deep_nesting_and_long_lists_are_refused_at_once() {
    let deep = [
        "a: ".to_owned() + &"[".repeat(100_000),
        "- ".repeat(100_000),
        "{a: ".repeat(50_000),
        " ".repeat(100_000) + "a: 1",
    ];
    for text in deep {
        let start = Instant::now();
        let error = read_spindle("s.yaml", &text).unwrap_err();
        assert!(error.message.contains("levels deep"), "{error}");
        // Without the check the parser takes half a minute.
        assert!(start.elapsed() < Duration::from_secs(5));
    }
    let element = "    - {length_m: 0.0001, outer_diameter_m: 0.03, material: steel}\n";
    let many = edited("  discs:\n", &(element.repeat(4000) + "  discs:\n"));
    let error = read_spindle("s.yaml", &many).unwrap_err();
    assert!(error.message.contains("at most 300"), "{error}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_muspin"));
    let frf = command.args(["frf", "--points", "1000000000"]).assert().code(2).stdout("");
    let message = String::from_utf8_lossy(&frf.get_output().stderr).into_owned();
    assert!(message.contains("--points 1000000000: at most"), "{message}");
}

/// A steel cylinder of 0.4 m and 50 mm with a stub as tool, in `n` equal elements.
fn cylinder(n: usize) -> Machine {
    let mut spindle: Spindle = read_spindle("s", REFERENCE).unwrap();
    let mut element = spindle.sections[0].clone();
    element.length_m = 0.4 / n as f64;
    element.region = None;
    spindle.sections = vec![element.clone(); n];
    spindle.discs.clear();
    let mut tool = read_tool("t", TOOL_TEXT, &spindle).unwrap();
    element.length_m = 0.01;
    tool.sections = vec![element];
    tool.discs.clear();
    tool.tool_plane_m = 0.01;
    Machine::new(spindle, tool).unwrap()
}

#[test]
fn a_coarse_mesh_is_said_with_its_error_and_the_element_to_split() {
    let third = |n: usize| {
        let rotor = cylinder(n).rotor().unwrap();
        muspin::rotor::PlanarModes::new(&rotor).unwrap().flexible_hz()[2]
    };
    let exact = third(64);
    let mut said = vec![];
    for n in [3, 4] {
        let found = coarse_mesh(&cylinder(n), 3, 0.005).unwrap().expect("too coarse");
        let error = third(n) / exact - 1.0;
        assert_eq!((found.mode, found.in_tool), (3, false));
        // The mesh that the error is taken from has sixteen elements and an error of its own.
        assert!((found.relative_error / error - 1.0).abs() < 0.2, "{found:?} {error}");
        said.push(found.relative_error);
    }
    assert!(said[1] < said[0]);
    assert_eq!(coarse_mesh(&cylinder(24), 3, 0.005).unwrap(), None);
    let reference = muspin::input::load_machine("reference", "paper-tool").unwrap();
    assert_eq!(coarse_mesh(&reference, 3, 0.005).unwrap(), None);
    // One long element among short ones is the one that is named.
    let mut uneven = cylinder(24);
    let long = uneven.spindle.sections.drain(6..14).map(|s| s.length_m).sum();
    let mut joined = uneven.spindle.sections[0].clone();
    joined.length_m = long;
    uneven.spindle.sections.insert(6, joined);
    let found = coarse_mesh(&uneven, 3, 0.005).unwrap().expect("one long element");
    assert_eq!((found.element, found.in_tool), (6, false), "{found:?}");
}

#[test]
fn check_reads_every_format_and_tells_all_that_is_wrong() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let corpus = |file: &str| root.join("tests/fuzz/corpus").join(file).display().to_string();
    let data = root.join("tests/data/diagnosis/c01");
    let good = [
        corpus("sweep/three-lines.csv"),
        corpus("hammer/ten-lines.csv"),
        corpus("mode_shapes/two.csv"),
        corpus("uff/frf.uff"),
        corpus("controller/gain.json"),
        corpus("mat/controller.mat"),
        data.join("measurement.yaml").display().to_string(),
        data.display().to_string(),
    ];
    let run = |files: &[String]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_muspin"));
        command.arg("check").args(files).output().unwrap()
    };
    let output = run(&good);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{message}");
    let lines = String::from_utf8(output.stdout).unwrap();
    for kind in [
        "sweep ok",
        "hammer record ok",
        "mode shapes ok",
        "universal file ok",
        "controller ok",
        "MATLAB file ok",
        "measurement ok",
    ] {
        assert!(lines.contains(kind), "{lines}");
    }
    let folder = TempDir::new().unwrap();
    let bad: Vec<String> = good[..6]
        .iter()
        .map(|file| {
            let name = std::path::Path::new(file).file_name().unwrap();
            let bytes = std::fs::read(file).unwrap();
            let copy = folder.path().join(name);
            std::fs::write(&copy, &bytes[..bytes.len() * 2 / 5]).unwrap();
            copy.display().to_string()
        })
        .collect();
    let output = run(&bad);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    for file in [&bad[0], &bad[3], &bad[4], &bad[5]] {
        assert!(message.contains(file.as_str()), "no {file} in {message}");
    }
}
