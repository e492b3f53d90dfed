//! Spindles of 125 and 215 kg, alike to the one of 8 kg in all that counts: what is hidden in their rehearsed
//! measurements is found as it is there, with its numbers.

use crate::spindle::alike::{alike, power};
use muspin::input::{load_machine, read_spindle, spindle_yaml};
use muspin::spindle::{Effect, EffectKind, Location};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// What the diagnosis of a machine `s` times as large says of an effect that is hidden in it.
fn found(s: f64, hidden: &Effect) -> Value {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let write = |file: &str, from: &str| {
        let text = std::fs::read_to_string(root.join(from)).unwrap();
        std::fs::write(folder.join(file), alike(&text, s)).unwrap();
    };
    write("spindle.yaml", "tests/data/spindles/reference-updated.yaml");
    write("tool.yaml", "spindles/tools/endmill-10.yaml");
    let text = std::fs::read_to_string(folder.join("spindle.yaml")).unwrap();
    let truth = read_spindle("s.yaml", &text).unwrap();
    let truth = spindle_yaml(&truth.with_effect(hidden.clone()));
    std::fs::write(folder.join("truth.yaml"), truth).unwrap();
    let run = |command: &str| {
        let arguments: Vec<&str> = command.split(' ').collect();
        let mut program = Command::new(env!("CARGO_BIN_EXE_muspin"));
        let run = program.args(&arguments).current_dir(folder).output();
        let run = run.unwrap();
        let said = String::from_utf8(run.stderr).unwrap();
        assert!(run.status.code().is_some_and(|code| code < 2), "{said}");
    };
    let machine = "--spindle spindle.yaml --tool tool.yaml --quiet";
    run(&format!("rehearse {machine} --truth truth.yaml --out m"));
    run("diagnose --measurement m --quiet --out d");
    let summary = std::fs::read_to_string(folder.join("d/summary.json")).unwrap();
    serde_json::from_str::<Value>(&summary).unwrap()["diagnosis"].take()
}

/// Hides an effect, whose values are those at 8 kg, in a machine `s` times as large.
fn is_found(s: f64, kind: EffectKind, values: &[f64], share: f64) {
    let parameters = kind.parameters();
    let grown = parameters.iter().zip(values);
    let values: Vec<f64> = grown.map(|(p, v)| v * s.powi(power(p.name))).collect();
    let hidden = Effect::new(kind, Location::None, values.clone()).unwrap();
    let found = found(s, &hidden);
    assert_eq!(found["verdict"], "named", "{}", found["sentence"]);
    let effects = found["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "{}", found["sentence"]);
    assert_eq!(effects[0]["effect"], kind.name(), "{}", found["sentence"]);
    for (parameter, value) in parameters.iter().zip(&values) {
        let named = effects[0]["parameters"][parameter.name].as_f64().unwrap();
        let off = (named / value - 1.0).abs();
        assert!(off < share, "{}: {named} for {value}", parameter.name);
    }
}

#[test]
fn a_joint_of_a_large_spindle_is_found() {
    // A tenth is what the damping is known to.
    is_found(3.0, EffectKind::ToolJoint, &[2e9, 1e6, 4.0], 0.2);
}

#[test]
fn a_heavy_tool_and_the_housing_of_a_large_spindle_are_found() {
    is_found(2.5, EffectKind::ToolMass, &[0.05], 0.01);
    is_found(3.0, EffectKind::HousingMode, &[700.0, 400.0, 0.03], 0.05);
}

/// The files of the test are alike: the rotor has the cube of the mass, and all natural frequencies are 1/s.
#[test]
fn natural_frequencies_of_machines_that_are_alike_fall_with_their_length() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let temporary = tempfile::tempdir().unwrap();
    let spindle = "tests/data/spindles/reference-updated.yaml";
    let own = load_machine(root.join(spindle).to_str().unwrap(), "endmill-10").unwrap();
    let write = |from: &str, to: &str| {
        let text = std::fs::read_to_string(root.join(from)).unwrap();
        let path = temporary.path().join(to);
        std::fs::write(&path, alike(&text, 3.0)).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let tool = write("spindles/tools/endmill-10.yaml", "tool.yaml");
    let other = load_machine(&write(spindle, "spindle.yaml"), &tool).unwrap();
    let [own, other] = [own, other].map(|machine| machine.rotor().unwrap());
    let ratio = other.mass_properties().mass_kg / own.mass_properties().mass_kg;
    assert!((ratio / 27.0 - 1.0).abs() < 1e-12, "{ratio}");
    let [own, other] = [own, other].map(|rotor| muspin::rotor::PlanarModes::new(&rotor));
    let (own, other) = (own.unwrap().flexible_hz(), other.unwrap().flexible_hz());
    for (a, b) in own.iter().zip(&other).take(8) {
        assert!((3.0 * b / a - 1.0).abs() < 1e-8, "{a} {b}");
    }
}
