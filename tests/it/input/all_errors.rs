//! One reading of a file tells all that is wrong with it, by line.

use assert_cmd::Command;
use muspin::input::error::nearest_key;
use muspin::input::{InputError, load_measurement, read_controller, read_spindle, read_tool, read_weights};
use tempfile::TempDir;

const SPINDLE: &str = include_str!("../../../spindles/reference.yaml");
const TOOL: &str = include_str!("../../../spindles/tools/paper-tool.yaml");
const WEIGHTS: &str = include_str!("../../../weights/benchmark.yaml");

fn edited(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

/// All errors in order; their lines ascend.
fn all(error: &InputError) -> Vec<InputError> {
    let mut list = vec![error.clone()];
    list.extend(error.further.iter().cloned());
    let lines: Vec<usize> = list.iter().filter_map(|e| e.line).collect();
    assert!(lines.is_sorted(), "{list:#?}");
    list
}

/// Each wrong word stands in exactly one error, which has its line.
fn told_once(text: &str, error: &InputError, wrong: &[&str]) {
    let list = all(error);
    assert_eq!(list.len(), wrong.len(), "{list:#?}");
    for word in wrong {
        let own: Vec<&InputError> = list.iter().filter(|e| e.message.contains(word)).collect();
        assert_eq!(own.len(), 1, "{word}: {list:#?}");
        let key = word.rsplit('.').next().unwrap_or(word);
        let line = text.lines().nth(own[0].line.unwrap() - 1).unwrap();
        assert!(line.contains(key), "{word}: {line}");
    }
}

#[test]
fn every_wrong_value_and_unknown_key_of_a_spindle_is_told() {
    let text = edited(
        SPINDLE,
        &[
            ("youngs_modulus_pa: 2.06e+11", "youngs_modulus_pa: 206"),
            ("sensor_bandwidth_hz", "sensor_bandwith_hz"),
            ("delay_s: 7.5e-5", "delay_s: 75"),
            ("max_rpm: 50000.0", "max_rpm: 4.0e+9"),
            ("rear_actuator_m: 0.3252", "rear_actuator_m: 0.1"),
            ("bias_current_a: 3.0", "bias_current_a: 9.0"),
        ],
    );
    let error = read_spindle("s.yaml", &text).unwrap_err();
    let wrong = [
        "youngs_modulus_pa",
        "sensor_bandwith_hz",
        "electronics.delay_s",
        "max_rpm",
        "planes.rear_actuator_m",
        "bearings.front.bias_current_a",
    ];
    told_once(&text, &error, &wrong);
}

#[test]
fn what_follows_from_a_wrong_value_is_not_told() {
    let text = edited(SPINDLE, &[("length_m: 0.0167", "length_m: 16.7"), ("gap_m: 5.0e-4", "gap_m: 0.5")]);
    let error = read_spindle("s.yaml", &text).unwrap_err();
    told_once(&text, &error, &["rotor.elements[0].length_m", "bearings.front.gap_m"]);
}

#[test]
fn values_of_another_kind_and_repeated_keys_are_told_with_the_rest() {
    let text = edited(
        SPINDLE,
        &[
            ("max_rpm: 50000.0", "max_rpm: fast"),
            ("gap_m: 5.0e-4", "gap_m: 5.0e-4, gap_m: 4.0e-4"),
            ("delay_s: 7.5e-5", "delay_s: [7.5e-5]"),
        ],
    );
    let list = all(&read_spindle("s.yaml", &text).unwrap_err());
    for part in ["speed.max_rpm: invalid type", "bearings.front.gap_m: duplicate", "electronics.delay_s: invalid type"]
    {
        assert!(list.iter().any(|e| e.message.contains(part) && e.line.is_some()), "{part}: {list:#?}");
    }
}

#[test]
fn tools_weights_and_controllers_tell_all_too() {
    let spindle = read_spindle("s.yaml", SPINDLE).unwrap();
    let text = edited(TOOL, &[("tool_plane_m: 0.1005", "tool_plane_m: 1.5"), ("outer_diameter_m", "outer_diameter")]);
    told_once(&text, &read_tool("t.yaml", &text, &spindle).unwrap_err(), &["outer_diameter", "tool_plane_m"]);
    let text =
        edited(WEIGHTS, &[("max_dc_load_n: 40", "max_dc_load_n: -40"), ("max_hf_load_n: 5", "max_hf_load_n: 0")]);
    let wrong = ["tool.max_dc_load_n", "tool.max_hf_load_n"];
    told_once(&text, &read_weights("w.yaml", &text).unwrap_err(), &wrong);
    let axes = r#"["front_x", "front_y", "rear_x", "rear_y"]"#;
    let zeros = "[[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]";
    let text = format!(
        "{{\"name\": 3,\n\"inputs\": {axes},\n\"outputs\": {axes},\n\"sample_time\": 0,\n\"A\": [],\n\"B\": [],\n\"C\": \
         [[], [], [], []],\n\"D\": {zeros}}}"
    );
    let list = all(&read_controller("k.json", &text).unwrap_err());
    let told: Vec<(Option<usize>, bool)> = list
        .iter()
        .map(|e| (e.line, e.message.contains("name: invalid type") || e.message.contains("`sample_time`")))
        .collect();
    assert_eq!(told, [(Some(1), true), (Some(4), true)], "{list:#?}");
}

#[test]
fn a_key_without_its_unit_gets_its_full_name() {
    let known = ["ki_n_per_a", "ks_n_per_m", "gap_m", "max_force_n", "max_current_a"];
    for (name, meant) in [("ki", "ki_n_per_a"), ("ks", "ks_n_per_m"), ("gap", "gap_m"), ("max_force", "max_force_n")] {
        assert_eq!(nearest_key(name, known.into_iter()), Some(meant));
    }
    // A slip of the pen goes by distance.
    assert_eq!(nearest_key("gap_mm", known.into_iter()), Some("gap_m"));
    let error = read_spindle("s.yaml", &edited(SPINDLE, &[("ki_n_per_a", "ki")])).unwrap_err();
    assert_eq!(error.hint.as_deref(), Some("did you mean `ki_n_per_a`?"));
    assert!(error.further.is_empty(), "{error:#?}");
}

#[test]
fn every_record_of_a_list_is_looked_at() {
    let folder = TempDir::new().unwrap();
    let records = "  - {kind: sweep, file: a.csv, speed_rpm: 0}\n  - {kind: swep, file: b.csv}\n  - {kind: hammer, file: \
                   c.csv, speed_rpm: 0}\n";
    let text = format!("spindle: reference\ntool: paper-tool\nrecords:\n{records}");
    std::fs::write(folder.path().join("measurement.yaml"), text).unwrap();
    let list = all(&load_measurement(&folder.path().display().to_string()).unwrap_err());
    let lines: Vec<Option<usize>> = list.iter().map(|e| e.line).collect();
    assert_eq!(lines, [Some(4), Some(5), Some(6)], "{list:#?}");
}

#[test]
fn check_prints_every_error() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("s.yaml");
    let text = edited(SPINDLE, &[("delay_s: 7.5e-5", "delay_s: 75"), ("ki_n_per_a", "ki")]);
    std::fs::write(&path, text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_muspin")).arg("check").arg(&path).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(said.matches("error: ").count(), 2, "{said}");
    assert!(said.contains("delay_s") && said.contains("did you mean `ki_n_per_a`?"), "{said}");
}
