//! Spindles from 0.06 kg to 1.7 t, alike to the one of 8 kg in all that counts: what is hidden in their rehearsed
//! measurements is found as it is there, with its numbers.

use crate::spindle::alike::{alike, power};
use muspin::input::{load_machine, read_spindle, spindle_yaml};
use muspin::spindle::{Bearings, Effect, EffectKind, Location};
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

/// Hides an effect, whose place and values are those at 8 kg, in a machine `s` times as large.
fn is_found_at(s: f64, kind: EffectKind, place: Location, values: &[f64], share: f64) {
    let place = match place {
        Location::Position(z) => Location::Position(s * z),
        other => other,
    };
    let parameters = kind.parameters();
    let grown = parameters.iter().zip(values);
    let values: Vec<f64> = grown.map(|(p, v)| v * s.powi(power(p.name))).collect();
    let hidden = Effect::new(kind, place, values.clone()).unwrap();
    let found = found(s, &hidden);
    assert_eq!(found["verdict"], "named", "{}", found["sentence"]);
    let effects = found["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "{}", found["sentence"]);
    assert_eq!(effects[0]["effect"], kind.name(), "{}", found["sentence"]);
    // A rotor at rest does not show a polar inertia.
    for (parameter, value) in parameters.iter().zip(&values).filter(|(p, _)| p.name != "polar_inertia_kg_m2") {
        let named = effects[0]["parameters"][parameter.name].as_f64().unwrap();
        let off = (named / value - 1.0).abs();
        assert!(off < share, "{}: {named} for {value}", parameter.name);
    }
}

/// The same of an effect that has one place.
fn is_found(s: f64, kind: EffectKind, values: &[f64], share: f64) {
    is_found_at(s, kind, Location::None, values, share);
}

/// Every kind but the gyroscopic factor, which needs a rotor that turns.
///
/// Three minutes: `cargo test --release --test it diagnose_alike::effects_of_every_kind -- --ignored`.
#[test]
#[ignore = "three minutes"]
fn effects_of_every_kind_are_found_in_spindles_of_a_fifth_and_of_six_times_the_length() {
    let front = || Location::Bearing(Bearings::Front);
    let rear = || Location::Bearing(Bearings::Rear);
    let at = Location::Position;
    // Factors are known as well as priors tell them from what is never exactly right.
    let effects = [
        (EffectKind::LoopDelay, Location::None, vec![3e-5], 0.02),
        (EffectKind::AmplifierBandwidth, front(), vec![1300.0], 0.02),
        (EffectKind::AmplifierSecondOrder, front(), vec![1700.0, 0.5], 0.03),
        (EffectKind::EddyCurrents, front(), vec![5e3], 0.02),
        (EffectKind::LaminatedCore, rear(), vec![3e3], 0.03),
        (EffectKind::SensorLowpass, rear(), vec![6e3], 0.02),
        (EffectKind::SensorOffset, front(), vec![4e-3], 0.02),
        (EffectKind::ActuatorOffset, rear(), vec![-4e-3], 0.02),
        (EffectKind::NegativeStiffness, front(), vec![1.3], 0.1),
        (EffectKind::ForceConstant, rear(), vec![0.85], 0.05),
        (EffectKind::SensorGain, front(), vec![1.08], 0.03),
        (EffectKind::BearingCoupling, front(), vec![0.04], 0.05),
        (EffectKind::AxisMisalignment, front(), vec![3.0], 0.05),
        (EffectKind::CurrentPickup, Location::Across { from: 0, to: 2 }, vec![3e-11], 0.05),
        (EffectKind::ModalDamping, Location::Mode(2), vec![4.0], 0.5),
        (EffectKind::ToolJoint, Location::None, vec![2e9, 1e6, 4.0], 0.25),
        (EffectKind::ToolMass, Location::None, vec![0.03], 0.02),
        (EffectKind::HousingMode, Location::None, vec![700.0, 400.0, 0.03], 0.05),
        (EffectKind::AddedMass, at(0.25), vec![0.5], 0.02),
        (EffectKind::AddedDisc, at(0.25), vec![0.5, 1e-3, 6e-4], 0.1),
        (EffectKind::RegionStiffness, Location::Region("e9".into()), vec![0.75], 0.05),
        (EffectKind::AddedStiffness, at(0.24), vec![6e5], 0.05),
        (EffectKind::AddedDamper, at(0.24), vec![400.0], 0.1),
        (EffectKind::TiltingStiffness, at(0.19), vec![-1.5e4], 0.05),
        (EffectKind::InternalDamping, Location::None, vec![2e-6], 0.1),
        (EffectKind::CrossCoupling, at(0.2), vec![3e5], 0.05),
    ];
    for s in [0.2, 6.0] {
        for (kind, place, values, share) in &effects {
            is_found_at(s, *kind, place.clone(), values, *share);
        }
    }
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

/// Tests of several seconds each: `cargo test --release --test it long:: -- --ignored`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_joint_of_a_large_spindle_is_found() {
        // A tenth is what the damping is known to.
        is_found(3.0, EffectKind::ToolJoint, &[2e9, 1e6, 4.0], 0.2);
    }

    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_heavy_tool_in_a_large_spindle_is_found() {
        is_found(2.5, EffectKind::ToolMass, &[0.05], 0.01);
    }
}
