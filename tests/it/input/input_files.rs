//! Files people write: what is read, what is refused and how, and that what is written loads again.

use assert_cmd::Command;
use muspin::augment::weights::StiffnessFloor;
use muspin::input::write::number;
use muspin::input::{
    load_machine, load_spindle, load_tool, load_weights, read_controller, read_spindle, read_tool, read_weights,
    spindle_yaml, tool_yaml,
};
use std::path::PathBuf;
use tempfile::TempDir;

const SPINDLE: &str = include_str!("../../../spindles/reference.yaml");
const TOOL: &str = include_str!("../../../spindles/tools/paper-tool.yaml");
const WEIGHTS: &str = include_str!("../../../weights/benchmark.yaml");

fn muspin() -> Command {
    Command::cargo_bin("muspin").unwrap()
}

fn edited(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

fn write(folder: &TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// `modes` must refuse the spindle with exit 2, no data, and a message with every given part.
fn refused(spindle: &str, parts: &[&str]) {
    let folder = TempDir::new().unwrap();
    let path = write(&folder, "machine.yaml", spindle);
    let output = muspin().arg("modes").arg("--spindle").arg(&path).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty());
    assert!(message.starts_with("error:"), "{message}");
    for part in parts.iter().chain(&["machine.yaml", "hint:"]) {
        assert!(message.contains(part), "no {part:?} in: {message}");
    }
}

#[test]
fn an_unknown_key_names_file_line_key_and_the_nearest_known_key() {
    let bad = edited(SPINDLE, "sensor_noise_m", "senser_noise_m");
    let line = bad.lines().position(|l| l.contains("senser_noise_m")).unwrap() + 1;
    refused(&bad, &[&format!("machine.yaml:{line}"), "senser_noise_m", "`sensor_noise_m`"]);
    let bad = edited(SPINDLE, "length_m: 0.0167", "lenght_m: 0.0167");
    refused(&bad, &["rotor.elements[0]", "lenght_m", "`length_m`"]);
}

#[test]
fn a_missing_file_is_named_with_what_is_shipped() {
    let output = muspin().args(["modes", "--spindle", "no/such.yaml"]).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    for part in ["no/such.yaml", "no such spindle file", "reference", "hint:"] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn numbers_that_make_no_sense_are_refused_with_their_key_path() {
    let cases: [(&str, &str, &[&str]); 12] = [
        (
            "outer_diameter_m: 0.0482",
            "outer_diameter_m: -0.0482",
            &["rotor.elements[0].outer_diameter_m", "-0.0482", "positive"],
        ),
        (
            "outer_diameter_m: 0.0482, inner_diameter_m: 0.0158",
            "outer_diameter_m: 0.0482, inner_diameter_m: 0.05",
            &["rotor.elements[0].inner_diameter_m", "smaller than"],
        ),
        ("position_m: 0.0943", "position_m: 0.0973", &["rotor.discs[0].position_m", "not on a node", "0.0943"]),
        ("length_m: 0.0167", "length_m: long", &["rotor.elements[0].length_m", "long", "expected a number"]),
        ("length_m: 0.0167", "length_m: .nan", &["rotor.elements[0].length_m"]),
        ("gap_m: 5.0e-4", "gap_m: .inf", &["bearings.front.gap_m", "inf"]),
        ("ks_n_per_m: 1.5e+6", "ks_n_per_m: -1.5e+6", &["bearings.front.ks_n_per_m", "positive"]),
        ("rear_sensor_m: 0.3032", "rear_sensor_m: 3.032", &["planes.rear_sensor_m", "must lie on the rotor"]),
        ("flexible_modes: 3", "flexible_modes: 300", &["rotor.flexible_modes", "between"]),
        ("delay_s: 7.5e-5", "delay_s: 1.0e-5", &["electronics.delay_s", "half a sample"]),
        ("poisson_ratio: 0.29", "poisson_ratio: 0.6", &["rotor.materials.steel.poisson_ratio", "0.5"]),
        ("material: steel", "material: stell", &["rotor.elements[0].material", "`steel`"]),
    ];
    for (from, to, parts) in cases {
        refused(&edited(SPINDLE, from, to), parts);
    }
}

#[test]
fn effects_are_checked_against_the_catalogue_and_the_machine() {
    let with = |effect: &str| format!("{SPINDLE}effects:\n  - {effect}\n");
    let cases: [(&str, &[&str]); 12] = [
        (
            "{effect: region_stiffness, region: e99, factor: 0.9}",
            &["effects[0].region", "e99", "no element has", "e15"],
        ),
        ("{effect: loop_dealy, delay_s: 1.0e-5}", &["effects[0].effect", "`loop_delay`"]),
        ("{effect: loop_delay, corner_hz: 1.0}", &["effects[0].corner_hz", "does not belong", "delay_s"]),
        ("{effect: loop_delay}", &["effects[0].delay_s", "missing"]),
        ("{effect: loop_delay, dely_s: 1.0}", &["dely_s", "`delay_s`"]),
        ("{effect: sensor_gain, bearing: middle, factor: 1.0}", &["effects[0].bearing", "front, rear or both"]),
        ("{effect: sensor_gain, axis: front_z, factor: 1.0}", &["effects[0].axis", "front_x", "rear_y"]),
        (
            "{effect: sensor_gain, axis: front_x, bearing: front, factor: 1.0}",
            &["effects[0].bearing", "does not belong", "axis"],
        ),
        ("{effect: sensor_offset, axis: front_x, offset_m: 0.001}", &["effects[0].axis", "does not belong", "bearing"]),
        ("{effect: added_mass, position_m: 2.0, mass_kg: 0.1}", &["effects[0].position_m", "must lie on the rotor"]),
        (
            "{effect: housing_mode, mass_kg: -4.0, frequency_hz: 600.0, damping_ratio: 0.03}",
            &["effects[0].mass_kg", "positive"],
        ),
        ("{effect: modal_damping, mode: 0, factor: 1.1}", &["effects[0].mode", "1 or more"]),
    ];
    for (effect, parts) in cases {
        refused(&with(effect), parts);
    }
}

#[test]
fn the_other_kinds_of_files_are_checked_too() {
    let spindle = load_spindle("reference").unwrap();
    let tool = |from, to| read_tool("t.yaml", &edited(TOOL, from, to), &spindle).unwrap_err();
    assert!(tool("material: steel", "material: bone").message.contains("elements[0].material"));
    assert!(tool("tool_plane_m: 0.1005", "tool_plane_m: 0.2").message.contains("tool_plane_m"));
    assert!(tool("name:", "nam:").message.contains("nam"));
    let negative = tool("outer_diameter_m: 0.0332", "outer_diameter_m: -0.0332").to_string();
    assert!(negative.contains("elements[0].outer_diameter_m"), "{negative}");
    let weights = |from, to| read_weights("w.yaml", &edited(WEIGHTS, from, to)).unwrap_err();
    let zero = weights("max_dc_load_n: 40", "max_dc_load_n: 0");
    assert!(zero.message.contains("tool.max_dc_load_n"), "{zero}");
    assert!(weights("[0.01, 0.01]", "[0.01, 1.5]").message.contains("mode_uncertainty[1]"));
    assert!(weights("rear:", "raer:").hint.unwrap().contains("`rear`"));
}

#[test]
fn optional_weights_have_documented_defaults_and_can_be_set() {
    let table = load_weights("benchmark").unwrap();
    assert_eq!(table.load_crossover_hz, [40.0; 3]);
    assert_eq!(table.displacement_crossover_hz, [40.0, 100.0, 100.0]);
    assert_eq!((table.current_limit_a, table.current_rolloff_hz), (2.5, 3000.0));
    assert_eq!((table.sensor_noise_m, table.tool_tightening), (0.2e-6, 1.0));
    assert_eq!(table.complementary_sensitivity_limit, None);
    let text = edited(WEIGHTS, "max_dc_load_n: 40,", "max_dc_load_n: 40, load_crossover_hz: 25,")
        + "complementary_sensitivity_limit: 4\ntool_tightening: 2\n";
    let set = read_weights("w.yaml", &text).unwrap();
    assert_eq!(set.load_crossover_hz, [25.0, 40.0, 40.0]);
    assert_eq!(set.complementary_sensitivity_limit, Some(4.0));
    assert_eq!(set.tool_tightening, 2.0);
}

#[test]
fn floors_of_the_tool_stiffness_are_bands_of_a_weights_file() {
    let with = |band: &str| read_weights("w.yaml", &format!("{WEIGHTS}tool_stiffness: [{band}]\n"));
    assert_eq!(read_weights("w.yaml", WEIGHTS).unwrap().tool_stiffness, []);
    let read = with("{from_hz: 790, to_hz: 880, at_least_n_per_m: 8.0e+6}").unwrap().tool_stiffness;
    assert_eq!(read, [StiffnessFloor { from_hz: 790.0, to_hz: 880.0, at_least_n_per_m: 8e6 }]);
    for (hz, holds) in [(789.0, false), (790.0, true), (833.0, true), (880.0, true), (881.0, false)] {
        assert_eq!(read[0].holds_at(hz), holds, "{hz} Hz");
    }
    let reversed = with("{from_hz: 880, to_hz: 790, at_least_n_per_m: 8.0e+6}").unwrap_err().to_string();
    assert!(reversed.contains("tool_stiffness[0].to_hz"), "{reversed}");
    let negative = with("{from_hz: 10, to_hz: 10, at_least_n_per_m: -1}").unwrap_err().to_string();
    assert!(negative.contains("tool_stiffness[0].at_least_n_per_m"), "{negative}");
}

#[test]
fn controllers_are_read_in_both_times_and_refused_with_the_bad_matrix() {
    let file = |names: &str, ts: &str, c: &str| {
        format!(
            r#"{{"name": "k", "inputs": {names}, "outputs": ["front_x", "front_y", "rear_x", "rear_y"],
            "sample_time_s": {ts}, "A": [[-1.0]], "B": [[1, 0, 0, 0]], "C": {c},
            "D": [[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,0]]}}"#
        )
    };
    let names = r#"["front_x", "front_y", "rear_x", "rear_y"]"#;
    let c = "[[1],[0],[0],[0]]";
    use muspin::controller::ControlLaw;
    let law = |text: &str| read_controller("k.json", text).unwrap().law;
    assert!(matches!(law(&file(names, "0", c)), ControlLaw::Continuous(_)));
    assert!(matches!(law(&file(names, "5e-5", c)), ControlLaw::Discrete(_)));
    let bad = |text: &str| read_controller("k.json", text).unwrap_err().to_string();
    assert!(bad(&file(names, "0", "[[1],[0],[0]]")).contains("C: has 3 rows"));
    assert!(bad(&file(names, "0", "[[1],[0, 1],[0],[0]]")).contains("C[1]: has 2 columns"));
    assert!(bad(&file(names, "-1", c)).contains("sample_time_s"));
    assert!(bad(&file(r#"["front_y", "front_x", "rear_x", "rear_y"]"#, "0", c)).contains("inputs"));
    assert!(bad("{\"name\": 3}").starts_with("k.json:1"));
    // A pure gain has no states at all.
    let gain = file(names, "0", "[[],[],[],[]]").replace("[[-1.0]]", "[]").replace("[[1, 0, 0, 0]]", "[]");
    assert!(matches!(law(&gain), ControlLaw::Continuous(_)));
}

#[test]
fn a_written_spindle_loads_as_the_same_spindle() {
    let effects = crate::spindle::spindle_plant::catalogue();
    let mut spindle = load_spindle("reference").unwrap();
    spindle.name = "corrected: front, 1.5 µm".into();
    spindle.gyroscopics = false;
    spindle.front.sensor_gain = 1.0123456789012345;
    spindle.sections[3].modulus_scale = 0.912_345_678_901_234_5;
    spindle.sections[4].mass_outer_diameter_m = [0.07; 2];
    spindle.effects = effects;
    let text = spindle_yaml(&spindle);
    assert_eq!(read_spindle("again.yaml", &text).unwrap(), spindle);
    let tool = load_tool("paper-tool", &spindle).unwrap();
    assert_eq!(read_tool("again.yaml", &tool_yaml(&tool), &spindle).unwrap(), tool);
}

#[test]
fn written_numbers_are_numbers_to_old_yaml_readers() {
    let cases = [
        (1.5e6, "1500000.0"),
        (2.06e11, "206000000000.0"),
        (1.25e17, "1.25e+17"),
        (1e20, "1.0e+20"),
        (5e-8, "5.0e-8"),
        (-2.5e-5, "-2.5e-5"),
        (0.0, "0.0"),
        (7850.0, "7850.0"),
    ];
    for (value, text) in cases {
        assert_eq!(number(value), text);
    }
}

#[test]
fn the_embedded_machine_is_the_shipped_one() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    assert_eq!(machine.spindle, read_spindle("s", SPINDLE).unwrap());
    assert_eq!(machine.regions().len(), 15);
}

#[test]
fn check_tells_the_kinds_apart_and_reports_the_bad_one() {
    let folder = TempDir::new().unwrap();
    let spindle = write(&folder, "s.yaml", SPINDLE);
    let tool = write(&folder, "t.yaml", TOOL);
    let weights = write(&folder, "w.yaml", WEIGHTS);
    let output = muspin().arg("check").args([&spindle, &tool, &weights]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0));
    for kind in ["spindle ok", "tool ok", "weights ok"] {
        assert!(text.contains(kind), "{text}");
    }
    let bad = write(&folder, "bad.yaml", &edited(TOOL, "tool_plane_m", "toolplane_m"));
    let output = muspin().arg("check").args([&spindle, &bad]).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    assert!(message.contains("bad.yaml") && message.contains("`tool_plane_m`"), "{message}");
}

#[test]
fn broken_files_of_every_sort_end_in_one_message() {
    let cases: [(&str, String, &str); 6] = [
        ("empty", String::new(), "missing field"),
        ("a list", "[1, 2]\n".into(), "mapping"),
        ("unclosed", "[1, 2\n".into(), "machine.yaml"),
        ("another kind", "a: 1\n".into(), "unknown field `a`"),
        ("a key twice", format!("name: again\n{SPINDLE}"), "duplicate"),
        (
            "no damping",
            edited(SPINDLE, "damping_ratio: [0.004, 0.004, 0.004]", "damping_ratio: []"),
            "rotor.damping_ratio",
        ),
    ];
    for (_, text, part) in cases {
        refused(&text, &[part]);
    }
    let folder = TempDir::new().unwrap();
    let output = muspin().arg("check").arg(folder.path()).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(message.contains("measurement.yaml"), "{message}");
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    use std::io::Read;
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_muspin"))
        .args(["frf", "--points", "2000"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0u8; 12];
    child.stdout.take().unwrap().read_exact(&mut first).unwrap();
    assert_eq!(&first, b"frequency_hz");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
}

#[test]
fn modes_and_frf_write_the_documented_columns() {
    let output = muspin().args(["modes", "--speeds", "0,50000"]).output().unwrap();
    let modes: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(modes["speeds"][1]["speed_rpm"], 50000.0);
    let at_rest = modes["speeds"][0]["natural_frequencies_hz"][0].as_f64().unwrap();
    assert!((at_rest - 1165.151).abs() < 6e-4);
    assert!((modes["mass_kg"].as_f64().unwrap() - 7.99368643476).abs() < 1e-9);
    let arguments = ["frf", "--speed", "20000", "--from", "50", "--to", "4000", "--points", "7"];
    let output = muspin().args(arguments).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 8);
    assert!(lines[0].starts_with("frequency_hz,g_11_re,g_11_im,g_12_re"));
    assert!(lines[0].ends_with("t_yx_im,t_yy_re,t_yy_im"));
    assert!(lines[1].starts_with("50,") && lines[7].starts_with("4000,"));
    assert!(lines.iter().all(|l| l.split(',').count() == 41));
}
