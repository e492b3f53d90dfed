//! Values that are possible alone and do not go together: said by `check` with the key, and never of a shipped file.

use muspin::input::kind::FileKind;
use std::path::Path;
use tempfile::TempDir;

const SPINDLE: &str = include_str!("../../../spindles/reference.yaml");
const TOOL: &str = include_str!("../../../spindles/tools/endmill-10.yaml");
const WEIGHTS: &str = include_str!("../../../weights/benchmark.yaml");

/// What is said of a file, and the same with a slip.
fn slip(kind: FileKind, text: &str, from: &str, to: &str) -> Vec<String> {
    assert!(text.contains(from), "{from}");
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("file.yaml");
    std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    let said = kind.warnings(path.to_str().unwrap()).unwrap();
    said.into_iter().map(|warning| warning.message).collect()
}

#[test]
fn slips_of_a_spindle_are_said_with_their_key() {
    for (from, to, key) in [
        // A gap of the diameter; ks of another magnet.
        ("gap_m: 5.0e-4", "gap_m: 1.0e-3", "bearings.front.ks_n_per_m"),
        ("ks_n_per_m: 6.4e+5", "ks_n_per_m: 3.0e+5", "bearings.rear.ks_n_per_m"),
        ("max_force_n: 1400.0", "max_force_n: 140.0", "bearings.front.max_force_n"),
        (
            "front_sensor_m: 0.06385\n  front_actuator_m: 0.1315",
            "front_sensor_m: 0.1315\n  front_actuator_m: 0.06385",
            "planes.front_sensor_m",
        ),
        ("delay_s: 7.5e-5", "delay_s: 2.5e-5", "electronics.delay_s"),
        ("delay_s: 7.5e-5", "delay_s: 1.0e-3", "electronics.delay_s"),
        // Turns a second, and radians a second, in place of turns a minute.
        ("max_rpm: 50000.0", "max_rpm: 833.3", "speed.max_rpm"),
        ("max_rpm: 50000.0", "max_rpm: 5236.0", "speed.max_rpm"),
        (
            "polar_inertia_kg_m2: 3.351644021609e-05, diametral_inertia_kg_m2: 1.702272551684e-05",
            "polar_inertia_kg_m2: 1.702272551684e-05, diametral_inertia_kg_m2: 3.351644021609e-05",
            "polar_inertia_kg_m2",
        ),
    ] {
        let said = slip(FileKind::Spindle, SPINDLE, from, to);
        assert!(said.iter().any(|message| message.contains(key)), "{key}: {said:?}");
    }
}

#[test]
fn slips_of_tools_and_weights_are_said_with_their_key() {
    let said = slip(FileKind::Tool, TOOL, "tool_plane_m: 0.094", "tool_plane_m: 0.04");
    assert!(said.iter().any(|message| message.contains("tool_plane_m")), "{said:?}");
    for (from, to, key) in [
        ("max_hf_load_n: 5,", "max_hf_load_n: 50,", "tool.max_hf_load_n"),
        ("max_hf_displacement_m: 10.0e-6", "max_hf_displacement_m: 100.0e-6", "tool.max_hf_displacement_m"),
        // A pole for integral action, and none so slow.
        ("name: benchmark", "name: benchmark\nintegral_corner_hz: 1\nleast_decay_per_s: 30", "least_decay_per_s"),
        ("name: benchmark", "name: benchmark\ntool_tightening: 0.01", "tool_tightening"),
        (
            "name: benchmark",
            "name: benchmark\nuncertainty: {actuator: {low: 2.0, high: 3.0, crossover_hz: 500}}",
            "uncertainty.actuator.low",
        ),
    ] {
        let said = slip(FileKind::Weights, WEIGHTS, from, to);
        assert!(said.iter().any(|message| message.contains(key)), "{key}: {said:?}");
    }
}

#[test]
fn nothing_is_said_of_shipped_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut seen = 0;
    for folder in ["spindles", "spindles/tools", "weights"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let file = path.to_str().unwrap();
            if file.ends_with(".yaml") {
                let said = FileKind::of(file).unwrap().warnings(file).unwrap();
                assert!(said.is_empty(), "{file}: {said:?}");
                seen += 1;
            }
        }
    }
    assert!(seen > 10, "{seen}");
}
