//! Rotor files of ROSS: its own frequencies of the free rotor, the spindle file that asks for the rest, the way back.

use crate::cli::program::muspin;
use crate::support::inputs::cut;
use muspin::input::ross::{RossRotor, read_ross};
use muspin::input::{load_machine, read_spindle};
use muspin::rotor::{Damping, PlanarModes, Rotor, Section, Shear};
use muspin::spindle::Side;
use serde_json::Value;
use std::f64::consts::{FRAC_PI_8, PI, TAU};
use std::path::{Path, PathBuf};

fn data() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/ross")
}

fn frequencies() -> Value {
    serde_json::from_str(&std::fs::read_to_string(data().join("frequencies.json")).unwrap()).unwrap()
}

fn loaded(file: &str) -> RossRotor {
    read_ross(file, &std::fs::read_to_string(data().join(file)).unwrap()).unwrap()
}

fn shaft(rotor: &RossRotor) -> Rotor {
    Rotor::new(0.0, rotor.sections.clone(), &rotor.discs).unwrap()
}

/// Frequencies above a hertz with their direction of whirl, Hz.
fn whirl(rotor: &Rotor, rpm: f64, to_hz: f64) -> Vec<(f64, i64)> {
    let found = rotor.whirl(rpm * TAU / 60.0, &Damping::Modal(vec![0.0]), &[], to_hz).unwrap();
    let modes = found.modes.iter();
    let all = modes.map(|m| (m.natural_rad_s / TAU, m.whirl.round() as i64));
    all.filter(|(hz, _)| *hz > 1.0).collect()
}

/// Both programs have the same beam and the same matrices; what is left are the two eigenvalue solvers.
const SAME: f64 = 1e-6;

#[test]
fn free_rotors_of_ross_files_whirl_as_in_ross() {
    let expected = frequencies();
    let to_hz = expected["to_hz"].as_f64().unwrap();
    let mut compared = 0;
    for (name, case) in expected["rotors"].as_object().unwrap() {
        let rotor = shaft(&loaded(case["file"].as_str().unwrap()));
        let mass = case["mass_kg"].as_f64().unwrap();
        assert!((rotor.mass_properties().mass_kg / mass - 1.0).abs() < 1e-12, "{name}: mass");
        for speed in case["speeds"].as_array().unwrap() {
            let rpm = speed["rpm"].as_f64().unwrap();
            let found = whirl(&rotor, rpm, to_hz);
            let theirs = speed["modes"].as_array().unwrap();
            assert_eq!(found.len(), theirs.len(), "{name} at {rpm} rpm");
            for ((hz, sense), mode) in found.iter().zip(theirs) {
                let there = mode[0].as_f64().unwrap();
                assert!((hz / there - 1.0).abs() < SAME, "{name} at {rpm} rpm: {hz}, ROSS {there}");
                assert_eq!(*sense, mode[1].as_i64().unwrap(), "{name} at {rpm} rpm: {hz} Hz");
                compared += 1;
            }
        }
    }
    assert!(compared > 80, "{compared}");
}

#[test]
fn a_written_spindle_asks_for_what_ross_does_not_say() {
    let place = tempfile::tempdir().unwrap();
    let file = data().join("magnets.toml").display().to_string();
    let (code, text, told) = muspin(&["ross", &file, "--out", "own"], place.path());
    assert_eq!(code, 0, "{told}");
    let answer: Value = serde_json::from_str(&text).unwrap();
    let asked: Vec<&str> = answer["to_be_given"].as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect();
    assert_eq!(asked.len(), 14, "{asked:?}");
    let (code, _, told) = muspin(&["check", "own/spindle.yaml"], place.path());
    assert_eq!(code, 2);
    for key in &asked {
        // A block that is missing whole is named by its head.
        let head = key.split('.').next().unwrap();
        assert!(told.contains(key) || told.contains(&format!(" {head},")), "{key} is not named: {told}");
    }
    // Every gap filled as the file says: the # of the key and of the heads above it removed, the value behind it.
    let path = place.path().join("own/spindle.yaml");
    let mut text = std::fs::read_to_string(&path).unwrap();
    text = text.replace("# electronics:", "electronics:");
    for key in &asked {
        let value = match key.rsplit('.').next().unwrap() {
            "damping_ratio" => "[0.004]",
            "flexible_modes" => "3",
            "front_sensor_m" => "0.06",
            "rear_sensor_m" => "0.3",
            "max_force_n" => "500",
            "max_current_a" => "6.0",
            "sensor_noise_m" => "5.0e-8",
            "delay_s" => "7.5e-5",
            "sample_rate_hz" => "20000",
            "backup_clearance_m" => "2.5e-4",
            "amplifier_bandwidth_hz" => "2000",
            _ => "12000",
        };
        let key = key.rsplit('.').next().unwrap();
        text = text.replacen(&format!("# {key}:"), &format!("{key}: {value}"), 1);
    }
    let spindle = read_spindle("spindle.yaml", &text).unwrap();
    std::fs::write(&path, text).unwrap();
    let (code, _, told) = muspin(&["check", "own/spindle.yaml"], place.path());
    assert_eq!(code, 0, "{told}");
    // The magnet of the file: ki = 4 cos(α) μ0 N² A i0 / (4 g²), ks = ki i0/g. The file has eight digits of α = π/8.
    let ki = 4.0 * FRAC_PI_8.cos() * 4e-7 * PI * 100.0f64.powi(2) * 3e-4 * 3.0 / (4.0 * 5e-4f64.powi(2));
    let front = spindle.bearing(Side::Front);
    assert!((front.ki_n_per_a / ki - 1.0).abs() < 1e-8 && (front.ks_n_per_m / (ki * 3.0 / 5e-4) - 1.0).abs() < 1e-8);
    assert!(
        (spindle.planes.front_actuator_m - 0.09).abs() < 1e-12 && (spindle.planes.rear_actuator_m - 0.27).abs() < 1e-12
    );
    assert!((spindle.max_rpm * TAU / 60.0 - 4000.0).abs() < 1e-9);
    // The written rotor is that of ROSS, at rest and at speed.
    let written = Rotor::new(0.0, spindle.sections.clone(), &spindle.discs).unwrap();
    let there = &frequencies()["rotors"]["magnets"]["speeds"][1];
    let found = whirl(&written, there["rpm"].as_f64().unwrap(), 6000.0);
    for ((hz, _), mode) in found.iter().zip(there["modes"].as_array().unwrap()) {
        assert!((hz / mode[0].as_f64().unwrap() - 1.0).abs() < SAME);
    }
}

#[test]
fn a_cone_becomes_cylinders_that_keep_its_frequencies() {
    let rotor = loaded("cones.json");
    let (cylinders, told) = rotor.cylinders();
    assert_eq!(cylinders.len(), 5 + 2 * 8);
    assert!(told.iter().any(|t| t.contains("cone")) && told.iter().any(|t| t.contains("Cowper")), "{told:?}");
    let sliced = Rotor::new(0.0, cylinders, &rotor.discs).unwrap();
    let mass = |r: &Rotor| r.mass_properties().mass_kg;
    assert!((mass(&sliced) / mass(&shaft(&rotor)) - 1.0).abs() < 1e-12);
    let hz = |r: &Rotor| PlanarModes::new(r).unwrap().flexible_hz();
    // The same cones in eight conical elements each: the limit of the one coarse element of the file.
    let mut fine = vec![];
    for section in &rotor.sections {
        let cylinder = |d: [f64; 2]| d[0] == d[1];
        let section = Section { shear: Shear::Cowper, ..section.clone() };
        if cylinder(section.outer_diameter_m) && cylinder(section.inner_diameter_m) {
            fine.push(section);
            continue;
        }
        fine.extend(cut(&section, 8));
    }
    let fine = Rotor::new(0.0, fine, &rotor.discs).unwrap();
    let coarse = shaft(&rotor);
    for ((a, b), c) in hz(&sliced).iter().zip(hz(&fine)).zip(hz(&coarse)).take(2) {
        // Eight and thirty-two slices differ by 4e-4.
        assert!((a / b - 1.0).abs() < 2e-3, "{a} {b}");
        assert!((a / b - 1.0).abs() < (c / b - 1.0).abs(), "{a} {b}, coarse {c}");
    }
}

#[test]
fn a_shaft_that_is_written_for_ross_is_read_back_as_it_was() {
    let place = tempfile::tempdir().unwrap();
    let (code, _, told) =
        muspin(&["ross", "--spindle", "reference", "--tool", "paper-tool", "--out", "there"], place.path());
    assert_eq!(code, 0, "{told}");
    let machine = load_machine("reference", "paper-tool").unwrap();
    let own = machine.rotor().unwrap();
    let nose = machine.tool.length_m().to_string();
    for file in ["there/rotor.toml", "there/rotor.json"] {
        let path = place.path().join(file);
        let back = shaft(&read_ross(file, &std::fs::read_to_string(&path).unwrap()).unwrap());
        for rpm in [0.0, 40000.0] {
            let (a, b) = (whirl(&own, rpm, 6000.0), whirl(&back, rpm, 6000.0));
            assert_eq!(a.len(), b.len(), "{file}");
            for (a, b) in a.iter().zip(&b) {
                // The layer without stiffness keeps 1e-9 of the modulus.
                assert!((a.0 / b.0 - 1.0).abs() < 1e-7 && a.1 == b.1, "{file}: {a:?} {b:?}");
            }
        }
        // Split at the nose face it is spindle and tool again.
        let (code, _, told) = muspin(&["ross", file, "--nose-face-m", &nose, "--out", "back"], place.path());
        assert_eq!(code, 0, "{told}");
        let text = std::fs::read_to_string(place.path().join("back/tool.yaml")).unwrap();
        let tool = muspin::input::read_tool("tool.yaml", &text, &machine.spindle).unwrap();
        assert_eq!(tool.sections.len(), machine.tool.sections.len());
        assert!((tool.tool_plane_m - machine.tool.length_m()).abs() < 1e-9);
    }
}

#[test]
fn what_is_no_rotor_for_a_spindle_is_refused_by_name() {
    let good: Value = serde_json::from_str(&std::fs::read_to_string(data().join("cones.json")).unwrap()).unwrap();
    let refused = |value: &Value, words: &str| {
        let error = read_ross("rotor.json", &value.to_string()).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    };
    let second = "ShaftElement_Shaft Element 1";
    let mut changed = good.clone();
    changed[second]["n"] = 5.into();
    refused(&changed, "node 2");
    changed = good.clone();
    changed[second]["L"] = "long".into();
    refused(&changed, "Shaft Element 1: L: expected a number");
    changed = good.clone();
    changed[second]["L"] = (-1.0).into();
    refused(&changed, "length_m");
    changed = good.clone();
    changed["CouplingElement_c"] = good[second].clone();
    refused(&changed, "CouplingElement_c");
    changed = good.clone();
    changed["Wheel_w"] = good[second].clone();
    refused(&changed, "Wheel_w");
    changed = good;
    changed[second].as_object_mut().unwrap().remove("material");
    refused(&changed, "material");
    refused(&serde_json::json!({ "ross_version": "2.3.0" }), "ShaftElement");
    assert!(read_ross("rotor.toml", "[[[").unwrap_err().to_string().contains("TOML"));
    let place = tempfile::tempdir().unwrap();
    let file = data().join("cones.json").display().to_string();
    let (code, _, told) = muspin(&["ross", &file, "--nose-face-m", "0.03", "--out", "o"], place.path());
    assert!(code == 2 && told.contains("--nose-face-m") && !Path::new(&place.path().join("o")).exists(), "{told}");
}

#[test]
fn a_rotor_turned_round_has_the_same_frequencies_and_its_discs_at_the_other_end() {
    for file in ["two_discs.toml", "cones.json"] {
        let rotor = loaded(file);
        let (one, other) = (shaft(&rotor), shaft(&rotor.clone().reverse_ends()));
        let (here, there) = (whirl(&one, 6000.0, 3000.0), whirl(&other, 6000.0, 3000.0));
        assert_eq!(here.len(), there.len(), "{file}");
        for ((hz, sense), (turned, other)) in here.iter().zip(&there) {
            assert!((turned / hz - 1.0).abs() < 1e-8, "{file}: {turned} {hz}");
            assert_eq!(sense, other, "{file} {hz}");
        }
        let length = one.to_m() - one.from_m();
        let [a, b] = [&one, &other].map(Rotor::mass_properties);
        let mirrored = length - b.centre_of_gravity_m;
        assert!((a.centre_of_gravity_m - mirrored).abs() < 1e-9, "{file}: {} {mirrored}", a.centre_of_gravity_m);
    }
}

#[test]
fn the_command_writes_a_rotor_turned_round() {
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let file = data().join("two_discs.toml");
    let file = file.to_str().unwrap();
    for (name, more) in [("as-it-is", None), ("turned", Some("--reverse"))] {
        let mut arguments = vec!["ross", file, "--out", name];
        arguments.extend(more);
        let (code, _, told) = muspin(&arguments, folder.path());
        assert_eq!(code, 0, "{told}");
    }
    // What ROSS does not say is still to be given: the shaft alone is compared, element by element from either end.
    let lengths = |name: &str| -> Vec<f64> {
        let text = std::fs::read_to_string(out(name).join("spindle.yaml")).unwrap();
        let key = "length_m: ";
        text.match_indices(key)
            .map(|(at, _)| {
                let rest = &text[at + key.len()..];
                let end = rest.find([',', '}', '\n']).unwrap();
                rest[..end].trim().parse().unwrap()
            })
            .collect()
    };
    let (one, mut other) = (lengths("as-it-is"), lengths("turned"));
    assert!(!one.is_empty());
    other.reverse();
    assert_eq!(one, other);
}

fn written(file: &str, name: &str, place: &Path) -> Value {
    let path = data().join(file).display().to_string();
    let (code, text, told) = muspin(&["ross", &path, "--out", name], place);
    assert_eq!(code, 0, "{told}");
    serde_json::from_str(&text).unwrap()
}

fn notes(answer: &Value) -> Vec<&str> {
    answer["notes"].as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect()
}

#[test]
fn seals_and_thrust_pads_beside_two_magnets_are_named_and_are_no_magnets() {
    let place = tempfile::tempdir().unwrap();
    let answer = written("beside_magnets.toml", "o", place.path());
    let asked = answer["to_be_given"].as_array().unwrap();
    let none = |key: &str| !asked.iter().any(|a| a == key);
    assert!(none("bearings.front.ki_n_per_a") && none("bearings.rear.gap_m") && none("planes.rear_actuator_m"));
    let told = notes(&answer);
    for words in ["SealElement", "ThrustPad", "Ball Bearing", "sensors_axis_rotation", "i0: "] {
        assert_eq!(told.iter().filter(|n| n.contains(words)).count(), 1, "{words}: {told:?}");
    }
    // Six elements have both kinds of damping: one note each.
    for key in ["alpha: mass", "beta: stiffness"] {
        let of: Vec<&&str> = told.iter().filter(|n| n.contains(key)).collect();
        assert!(of.len() == 1 && of[0].contains("6 elements"), "{told:?}");
    }
}

#[test]
fn the_pid_of_the_magnets_becomes_a_controller() {
    let place = tempfile::tempdir().unwrap();
    written("beside_magnets.toml", "o", place.path());
    let path = place.path().join("o/controller.json");
    let controller = muspin::input::load_controller(path.to_str().unwrap()).unwrap();
    let muspin::controller::ControlLaw::Continuous(law) = controller.law else {
        panic!("in continuous time");
    };
    for hz in [0.1, 30.0, 2000.0] {
        let s = muspin::linalg::c64::new(0.0, hz * TAU);
        let found = law.transfer(s);
        // Amplifier and sensor gain multiply to one.
        let pid = 2e4 + 5e4 / s + 20.0 * s / (1.0 + s / 8e3);
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let expected = if i == j { -pid } else { 0.0.into() };
            assert!((found[(i, j)] - expected).norm() < 1e-12 * pid.norm(), "{hz} Hz, {i}, {j}");
        }
    }
}

#[test]
fn supports_with_mass_and_unequal_axes_are_said() {
    let place = tempfile::tempdir().unwrap();
    let answer = written("support_with_mass.toml", "o", place.path());
    let told = notes(&answer);
    for words in ["n_link", "a mass of 2 kg that is not on the shaft", "a support of node 5"] {
        assert!(told.iter().any(|n| n.contains(words)), "{words}: {told:?}");
    }
    let text = std::fs::read_to_string(data().join("beside_magnets.toml")).unwrap();
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        read_ross("rotor.toml", &text.replacen(from, to, 1)).unwrap()
    };
    let said = |rotor: &RossRotor, words: &str| rotor.left_out.iter().any(|n| n.contains(words));
    let unequal = changed("i0 = 3.0", "i0 = [3.0, 2.5]");
    assert!(said(&unequal, "i0: bias currents of 3 A in x and 2.5 A in y"), "{:?}", unequal.left_out);
    let damped = changed("[parameters]", "[parameters]\nalpha = 3.0\nmodel = 2");
    assert!(said(&damped, "parameters.alpha: mass-proportional damping") && said(&damped, "parameters.model"));
    let seal = changed("SealElement_Seal", "LabyrinthSeal_Seal");
    assert!(said(&seal, "LabyrinthSeal") && seal.magnet_pair().is_some());
    let unknown = changed("SealElement_Seal", "Whisker_Seal");
    assert!(said(&unknown, "the class Whisker is not known") && unknown.bearings.len() == 3, "{:?}", unknown.left_out);
}

#[test]
fn a_seal_beside_one_bearing_does_not_become_the_rear_magnet() {
    let text = std::fs::read_to_string(data().join("two_discs.toml")).unwrap();
    let second = "BearingElement_Bearing 1";
    assert!(text.contains(second));
    let rotor = read_ross("rotor.toml", &text.replacen(second, "LabyrinthSeal_laby", 1)).unwrap();
    assert!(rotor.magnet_pair().is_none() && rotor.bearings.len() == 1);
    assert!(rotor.left_out.iter().any(|n| n.contains("LabyrinthSeal_laby")), "{:?}", rotor.left_out);
}
