//! Diagnoses of rehearsed measurements on machines that are not the reference spindle: the slender rotor of a test rig
//! with many modes in the band, tilting stiffnesses that the shaft feels strongly, and two effects that hide each other.

use muspin::controller::verification::verify_at;
use muspin::controller::{ControlLaw, Controller};
use muspin::input::{load_machine, read_controller, read_spindle, spindle_yaml};
use muspin::pid::settings::TuneSettings;
use muspin::pid::tune::textbook;
use muspin::spindle::halved::{refine_mesh, refined_around_tilting};
use muspin::spindle::{Bearings, Effect, EffectKind, Location, Spindle};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file)
}

/// Runs the program in a folder; what it says on standard error.
fn muspin(arguments: &[&str], folder: &Path) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_muspin"));
    let run = command.args(arguments).arg("--quiet").current_dir(folder).output();
    let run = run.unwrap();
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.code().is_some_and(|c| c < 2), "{said}");
    said
}

fn part(folder: &Path, file: &str, key: &str) -> Value {
    let text = std::fs::read_to_string(folder.join(file).join("summary.json")).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()[key].take()
}

fn spindle_of(file: &Path) -> Spindle {
    let text = std::fs::read_to_string(file).unwrap();
    read_spindle("s.yaml", &text).unwrap()
}

/// A spindle with further effects, written to the folder as `truth.yaml`.
fn hide(effects: &[Effect], given: Spindle, folder: &Path) {
    let add = |machine: Spindle, e: &Effect| machine.with_effect(e.clone());
    let changed = effects.iter().fold(given, add);
    std::fs::write(folder.join("truth.yaml"), spindle_yaml(&changed)).unwrap();
}

/// What the diagnosis of a rehearsal with hidden effects says; it names all of them and nothing else, in any order.
fn named(spindle: &Path, effects: &[Effect], rest: &[&str]) -> Value {
    named_beside(spindle, spindle_of(spindle), effects, rest)
}

/// The same where the spindle that is measured, `given`, is not exactly that of the file.
fn named_beside(spindle: &Path, given: Spindle, effects: &[Effect], rest: &[&str]) -> Value {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    hide(effects, given, folder);
    let spindle = spindle.to_str().unwrap();
    let truth = ["--truth", "truth.yaml", "--out", "m"];
    let rehearse = [&["rehearse", "--spindle", spindle], &truth[..], rest].concat();
    muspin(&rehearse, folder);
    muspin(&["diagnose", "--measurement", "m", "--out", "d"], folder);
    let found = part(folder, "d", "diagnosis");
    assert_eq!(found["verdict"], "named", "{}", found["sentence"]);
    let mut hidden: Vec<&str> = effects.iter().map(|e| e.kind.name()).collect();
    let named = found["effects"].as_array().unwrap().iter();
    let mut names: Vec<&str> = named.map(|e| e["effect"].as_str().unwrap()).collect();
    hidden.sort_unstable();
    names.sort_unstable();
    assert_eq!(names, hidden, "{}", found["sentence"]);
    found
}

/// The value that a diagnosis gives to a parameter of a kind of effect.
fn value_of(found: &Value, kind: EffectKind, parameter: &str) -> f64 {
    let mut effects = found["effects"].as_array().unwrap().iter();
    let own = effects.find(|e| e["effect"] == kind.name()).unwrap();
    own["parameters"][parameter].as_f64().unwrap()
}

fn bearing(kind: EffectKind, bearing: Bearings, value: f64) -> Effect {
    Effect::new(kind, Location::Bearing(bearing), vec![value]).unwrap()
}

fn everywhere(kind: EffectKind, value: f64) -> Effect {
    Effect::new(kind, Location::None, vec![value]).unwrap()
}

fn tilting_is_found(spindle: &Path, rest: &[&str], position_m: f64, stiffness: f64) {
    let place = Location::Position(position_m);
    let hidden = Effect::new(EffectKind::TiltingStiffness, place, vec![stiffness]).unwrap();
    let found = named(spindle, &[hidden], rest);
    let effect = &found["effects"][0];
    let at = effect["where"]["position_m"].as_f64().unwrap();
    let value = &effect["parameters"]["stiffness_n_m_per_rad"];
    assert!((at - position_m).abs() < 2e-3, "{at} {position_m}");
    let ratio = value.as_f64().unwrap() / stiffness;
    assert!((ratio - 1.0).abs() < 0.02, "{value} {stiffness}");
}

/// A textbook PID leaves a flexible mode of the updated reference spindle unstable.
#[test]
fn a_rotor_that_a_textbook_pid_does_not_float_is_rehearsed_with_a_pid_tuned_on_it() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let spindle = data("spindles/reference-updated.yaml");
    let spindle = spindle.to_str().unwrap();
    let machine = load_machine(spindle, "paper-tool").unwrap();
    let stable = |controller: &Controller| {
        let ControlLaw::Discrete(law) = &controller.law else {
            panic!("a PID of firmware is sampled");
        };
        let check = verify_at(&machine, law, &[0.0], "at rest").unwrap();
        check.is_stable()
    };
    let textbook = textbook(&machine, &TuneSettings::quick()).unwrap();
    assert!(!stable(&textbook.controller));
    muspin(&["rehearse", "--spindle", spindle, "--out", "m"], folder);
    let file = folder.join("m/pid.json");
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(stable(&read_controller("pid.json", &text).unwrap()));
}

/// A mesh of any file can be halved twice, as a diagnosis needs it; a longer list is refused when it is read.
#[test]
fn the_longest_list_of_elements_can_be_halved_twice() {
    let mut machine = load_machine("reference", "paper-tool").unwrap();
    let section = machine.spindle.sections[0].clone();
    let length = machine.spindle.sections.iter().map(|s| s.length_m).sum::<f64>();
    machine.spindle.sections = vec![section; 300];
    for s in &mut machine.spindle.sections {
        s.length_m = length / 300.0;
    }
    machine.spindle.discs.clear();
    let text = spindle_yaml(&machine.spindle);
    assert!(read_spindle("s.yaml", &text).is_ok());
    let fine = refine_mesh(&refine_mesh(&machine)).rotor().unwrap();
    let elements = 4 * (300 + machine.tool.sections.len());
    assert_eq!(fine.dofs(), 2 * (elements + 1));
    let last = machine.spindle.sections[0].clone();
    machine.spindle.sections.push(last);
    let error = read_spindle("s.yaml", &spindle_yaml(&machine.spindle)).unwrap_err();
    assert!(error.message.contains("at most 300"), "{error}");
}

/// The element that holds a tilting stiffness stays whole, since a third of it is where the slope is read.
#[test]
fn a_finer_mesh_keeps_the_element_of_a_tilting_stiffness() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let count = |m: &muspin::spindle::Machine| (m.tool.sections.len(), m.spindle.sections.len());
    let (tool, own) = count(&machine);
    assert_eq!(count(&refined_around_tilting(&machine)), (2 * tool, 2 * own));
    let lengths = machine.spindle.sections.iter().map(|s| s.length_m);
    let ends: Vec<f64> = lengths
        .scan(0.0, |z, l| {
            *z += l;
            Some(*z)
        })
        .collect();
    let middle = 0.5 * (ends[4] + ends[5]);
    // On a node either neighbour may be read.
    for (position_m, whole) in [(middle, 1), (ends[4], 2)] {
        let place = Location::Position(position_m);
        let effect = Effect::new(EffectKind::TiltingStiffness, place, vec![1e4]).unwrap();
        let finer = refined_around_tilting(&machine.with_effect(effect));
        assert_eq!(count(&finer), (2 * tool, 2 * own - whole));
        assert!(finer.spindle.sections.contains(&machine.spindle.sections[5]));
    }
}

/// A tilting stiffness beside a joint, beside a mass 2 cm away, and beside a stiffness 1.4 cm away. Alone it explains
/// the records nearly, at a place that is not its own.
///
/// Two minutes: `cargo test --release --test it diagnose_rehearsed::a_tilting_stiffness_beside -- --ignored`.
#[test]
#[ignore = "two minutes"]
fn a_tilting_stiffness_beside_another_effect_is_found() {
    let joint = Effect::new(EffectKind::ToolJoint, Location::None, vec![2.557e9, 3.126e4, 0.288]);
    let at = |kind, position_m, value| Effect::new(kind, Location::Position(position_m), vec![value]).unwrap();
    let tilting = EffectKind::TiltingStiffness;
    let cases = [
        ("s01-short-fast", "endmill-16", at(tilting, 0.077_81, 6575.0), joint.unwrap()),
        ("s04-noncollocated", "drill-8", at(tilting, 0.071_44, 83_643.0), at(EffectKind::AddedMass, 0.091_19, 0.524)),
        (
            "s01-short-fast",
            "endmill-12-long",
            at(tilting, 0.054_92, 13_235.0),
            at(EffectKind::AddedStiffness, 0.069_15, -3.963e5),
        ),
    ];
    for (spindle, tool, strong, other) in cases {
        let spindle = data(&format!("spindles/{spindle}.yaml"));
        let want = strong.values[0];
        let found = named(&spindle, &[strong, other], &["--tool", tool]);
        let stiffness = value_of(&found, tilting, "stiffness_n_m_per_rad");
        assert!((stiffness / want - 1.0).abs() < 0.02, "{stiffness} for {want}");
    }
}

/// Tests of several seconds each: `cargo test --release --test it long:: -- --ignored`.
mod long {
    use super::*;

    /// Free laws across the joint take up a stiffness elsewhere too: that the joint alone seems to explain everything does
    /// not end the search.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_stiffness_beside_a_tool_joint_is_found() {
        let spindle = data("spindles/s06-strong-ks.yaml");
        let joint = vec![4.091e8, 7.086e4, 0.444];
        let hidden = [
            Effect::new(EffectKind::AddedStiffness, Location::Position(0.2303), vec![2.658e6]).unwrap(),
            Effect::new(EffectKind::ToolJoint, Location::None, joint).unwrap(),
        ];
        let found = named(&spindle, &hidden, &["--tool", "endmill-12-long"]);
        let stiffness = value_of(&found, EffectKind::AddedStiffness, "stiffness_n_per_m");
        assert!((stiffness / 2.658e6 - 1.0).abs() < 0.01, "{stiffness}");
        let turning = value_of(&found, EffectKind::ToolJoint, "rotational_n_m_per_rad");
        assert!((turning / 7.086e4 - 1.0).abs() < 0.01, "{turning}");
    }

    /// A machine that was never updated: forces, stiffnesses and gains are all further off than an updating leaves. That is
    /// no effect, and the answer says which numbers are off.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_machine_that_is_off_everywhere_has_no_effect_but_is_to_be_updated() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        let spindle = data("spindles/s06-strong-ks.yaml");
        let mut truth = spindle_of(&spindle);
        for (bearing, force, stiffness, gain) in
            [(&mut truth.front, 1.1, 1.22, 1.04), (&mut truth.rear, 0.91, 0.82, 0.965)]
        {
            bearing.ki_n_per_a *= force;
            bearing.ks_n_per_m *= stiffness;
            bearing.sensor_gain *= gain;
        }
        std::fs::write(folder.join("truth.yaml"), spindle_yaml(&truth)).unwrap();
        let spindle = spindle.to_str().unwrap();
        let machine = ["--spindle", spindle, "--tool", "endmill-10"];
        let rest = ["--truth", "truth.yaml", "--out", "m"];
        muspin(&[&["rehearse"], &machine[..], &rest].concat(), folder);
        muspin(&["diagnose", "--measurement", "m", "--out", "d"], folder);
        let found = part(folder, "d", "diagnosis");
        let sentence = found["sentence"].as_str().unwrap();
        assert_eq!(found["verdict"], "adequate", "{sentence}");
        assert!(sentence.contains("further off than a careful updating leaves"));
        assert!(sentence.contains("update the model before a design"));
        let off = found["further_off"].as_array().unwrap();
        let change = |name: &str| {
            let own = off.iter().find(|f| f["parameter"] == name).unwrap();
            own["relative_change"].as_f64().unwrap()
        };
        for (name, exact) in [
            ("front bearing, force constant", 0.1),
            ("rear bearing, force constant", -0.09),
            ("front bearing, negative stiffness", 0.22),
            ("rear bearing, negative stiffness", -0.18),
        ] {
            // Twice what a careful updating leaves of the two.
            let tolerance = if f64::abs(exact) > 0.15 { 0.08 } else { 0.04 };
            assert!((change(name) - exact).abs() < tolerance, "{name}: {}", change(name));
        }
        let usual = |f: &Value| f["usual_deviations"].as_f64().unwrap();
        assert!(off.windows(2).all(|w| usual(&w[0]) >= usual(&w[1])));
    }

    /// Alone, the internal damping explains the records with a force constant far outside its prior: it is one of two.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn an_effect_beside_which_a_nuisance_parameter_is_far_off_is_one_of_two() {
        let spindle = data("spindles/s06-strong-ks.yaml");
        let hidden = [
            everywhere(EffectKind::InternalDamping, 2.815e-6),
            bearing(EffectKind::ForceConstant, Bearings::Rear, 0.8363),
        ];
        let found = named(&spindle, &hidden, &["--tool", "endmill-12-long"]);
        let loss = value_of(&found, EffectKind::InternalDamping, "loss_time_s");
        assert!((loss / 2.815e-6 - 1.0).abs() < 0.1, "{loss}");
        let factor = value_of(&found, EffectKind::ForceConstant, "factor");
        assert!((factor - 0.8363).abs() < 0.05, "{factor}");
    }

    /// A moment on a shaft that feels it strongly is not predicted by a linear step, and a fit of its place ends between two
    /// nodes.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_strong_tilting_stiffness_is_found() {
        let spindle = data("spindles/s04-noncollocated.yaml");
        tilting_is_found(&spindle, &[], 0.2939, 5.1e4);
    }

    /// Both are of kinds that are never exactly right: beside one of them, what is never exactly right takes up the other.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn two_effects_that_nuisance_parameters_take_up_are_named() {
        let spindle = data("spindles/s01-short-fast.yaml");
        let damping = Location::Mode(1);
        let hidden = [
            bearing(EffectKind::NegativeStiffness, Bearings::Front, 0.7472),
            Effect::new(EffectKind::ModalDamping, damping, vec![4.7012]).unwrap(),
        ];
        let found = named(&spindle, &hidden, &["--tool", "endmill-6"]);
        let of = |kind| value_of(&found, kind, "factor");
        // Priors hold what is never exactly right to a twenty-fifth and a fifth.
        assert!((of(EffectKind::NegativeStiffness) - 0.7472).abs() < 0.03);
        assert!((of(EffectKind::ModalDamping) / 4.7012).ln().abs() < 0.2);
    }

    /// A soft joint lowers all resonances, as a wrong clock does, and the hammer test at the tool looks as if its
    /// frequencies were in rad/s. One effect explains the records as they are.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_soft_joint_is_no_wrong_clock() {
        let spindle = data("spindles/s04-noncollocated.yaml");
        let values = vec![8.548e8, 47_379.0, 0.444];
        let joint = Effect::new(EffectKind::ToolJoint, Location::None, values).unwrap();
        let found = named(&spindle, &[joint], &["--tool", "endmill-12-long"]);
        assert!(found["record_faults"].as_array().unwrap().is_empty());
        let turning = &found["effects"][0]["parameters"]["rotational_n_m_per_rad"];
        let ratio = turning.as_f64().unwrap() / 47_379.0;
        assert!((ratio - 1.0).abs() < 0.01, "{turning}");
    }

    /// Its first mode is at 17 Hz and fourteen lie below 4 kHz; the magnets lower the second by 8.6 Hz.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_slender_rotor_is_identified_updated_and_diagnosed() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        let spindle = data("spindles/s13-lab-rotor.yaml");
        let spindle_name = spindle.to_str().unwrap();
        muspin(&["rehearse", "--spindle", spindle_name, "--out", "m"], folder);
        // Nothing is hidden: the coarse mesh of the file is not what the data complain about.
        muspin(&["diagnose", "--measurement", "m", "--out", "nothing"], folder);
        let nothing = part(folder, "nothing", "diagnosis");
        assert_eq!(nothing["verdict"], "adequate", "{}", nothing["sentence"]);
        assert!(nothing["gap_after"].as_f64().unwrap() < 1.0);

        let said = muspin(&["update", "--measurement", "m", "--out", "u"], folder);
        assert!(said.contains("is too long for mode"), "{said}");
        let found = part(folder, "u", "identification");
        let list = |key: &str| -> Vec<f64> {
            let all = found[key].as_array().unwrap();
            all.iter().map(|v| v.as_f64().unwrap()).collect()
        };
        // The free-free rotor by the dense eigenvalue problem of a finer mesh. The sweep begins below its first mode.
        let machine = load_machine(spindle_name, "paper-tool").unwrap();
        let rotor = refine_mesh(&refine_mesh(&machine)).rotor().unwrap();
        let modes = muspin::rotor::PlanarModes::new(&rotor).unwrap().flexible_hz();
        let (measured, sd) = (list("resonances_hz"), list("resonances_standard_deviation_hz"));
        // The first eleven, one after the other; of those above 3 kHz, which the magnets hardly move, some are found.
        assert!((11..=14).contains(&measured.len()), "{measured:?}");
        for (k, f) in measured.iter().enumerate() {
            let nearest = modes[11..].iter().min_by(|a, b| (*a - f).abs().total_cmp(&(*b - f).abs())).unwrap();
            let exact = if k < 11 { modes[k] } else { *nearest };
            // A thousandth is what the mesh of the rehearsal, every element in two, leaves at 1.8 kHz.
            assert!((f - exact).abs() < 3.0 * sd[k] + 1e-3 * exact, "{f} {exact} {}", sd[k]);
        }
        let shift = found["magnet_shift_removed_hz"]["resonances"][1].as_f64();
        assert!((8.0..9.0).contains(&shift.unwrap()), "{shift:?}");

        // Nearly the whole shaft is a quarter stiffer: fourteen modes bend otherwise, and the reduction follows them.
        let region = Location::Region("shaft".to_owned());
        let stiffer = Effect::new(EffectKind::RegionStiffness, region, vec![1.25]).unwrap();
        hide(&[stiffer], spindle_of(&spindle), folder);
        let rehearse = [
            "rehearse",
            "--spindle",
            spindle_name,
            "--truth",
            "truth.yaml",
            "--controller",
            "m/pid.json",
            "--out",
            "n",
        ];
        muspin(&rehearse, folder);
        muspin(&["diagnose", "--measurement", "n", "--out", "stiffer"], folder);
        let stiffer = part(folder, "stiffer", "diagnosis");
        assert_eq!(stiffer["verdict"], "named", "{}", stiffer["sentence"]);
        assert_eq!(stiffer["effects"].as_array().unwrap().len(), 1);
        assert_eq!(stiffer["effects"][0]["where"]["region"], "shaft");
        let factor = stiffer["effects"][0]["parameters"]["factor"].as_f64();
        assert!((factor.unwrap() - 1.25).abs() < 0.03, "{factor:?}");
    }

    /// Three grams at a slender tool move its resonance by many times its width.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_small_mass_at_a_slender_tool_is_found() {
        let spindle = data("spindles/s09-four-modes.yaml");
        let mass = Effect::new(EffectKind::ToolMass, Location::None, vec![0.003]).unwrap();
        let found = named(&spindle, &[mass], &["--tool", "drill-8"]);
        let mass = &found["effects"][0]["parameters"]["mass_kg"];
        let ratio = mass.as_f64().unwrap() / 0.003;
        assert!((ratio - 1.0).abs() < 0.02, "{mass}");
    }

    /// Where the front of the spindle is softer and the rest stiffer by a hundredth, the linear step to a mass at the tip
    /// leads nowhere, and that to a mass with a position ends at the tip.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_mass_at_the_tip_is_one_of_the_tool() {
        let spindle = data("spindles/s12-big-discs.yaml");
        let mut given = spindle_of(&spindle);
        for (i, section) in given.sections.iter_mut().enumerate() {
            section.modulus_scale *= if i < 6 { 0.99 } else { 1.01 };
        }
        let mass = Effect::new(EffectKind::ToolMass, Location::None, vec![0.0104]).unwrap();
        let found = named_beside(&spindle, given, &[mass], &["--tool", "drill-8"]);
        let mass = &found["effects"][0]["parameters"]["mass_kg"];
        let ratio = mass.as_f64().unwrap() / 0.0104;
        assert!((ratio - 1.0).abs() < 0.01, "{mass}");
    }

    /// On a spindle of 30 kg, at three places.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_strong_tilting_stiffness_is_found_wherever_it_acts() {
        let folder = data("diagnosis/c19");
        let [tool, controller] = ["tool.yaml", "k.json"].map(|f| folder.join(f));
        let rest = ["--tool", tool.to_str().unwrap(), "--controller", controller.to_str().unwrap()];
        for (position_m, stiffness) in [(0.15, 3e5), (0.1, 3e5), (0.2325, -3e5)] {
            tilting_is_found(&folder.join("spindle.yaml"), &rest, position_m, stiffness);
        }
    }

    /// More delay with a faster rear amplifier looks, as far as one effect can, like eddy currents at the front: the first
    /// effect that is found is neither.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn the_first_effect_of_a_pair_is_exchanged() {
        let spindle = Path::new(env!("CARGO_MANIFEST_DIR")).join("spindles/reference.yaml");
        let hidden = [
            bearing(EffectKind::AmplifierBandwidth, Bearings::Rear, 3000.0),
            everywhere(EffectKind::LoopDelay, 1.494e-5),
        ];
        let found = named(&spindle, &hidden, &["--tool", "endmill-20-short"]);
        let bandwidth = value_of(&found, EffectKind::AmplifierBandwidth, "bandwidth_hz");
        assert!((bandwidth / 3000.0 - 1.0).abs() < 2e-3, "{bandwidth}");
        let delay = value_of(&found, EffectKind::LoopDelay, "delay_s");
        assert!((delay / 1.494e-5 - 1.0).abs() < 1e-2, "{delay}");
    }

    /// Beside a tilting stiffness a low-pass of all sensors stood in for a slower loop, with the stiffness at a place beside
    /// its own.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_slower_loop_beside_a_tilting_stiffness_is_no_low_pass() {
        let spindle = Path::new(env!("CARGO_MANIFEST_DIR")).join("spindles/reference.yaml");
        let place = Location::Position(0.176_194_978_793_040_2);
        let tilting = EffectKind::TiltingStiffness;
        let hidden = [
            Effect::new(tilting, place, vec![-25_395.481_430_270_14]).unwrap(),
            everywhere(EffectKind::LoopDelay, 2.222_590_720_025_578_6e-5),
        ];
        let rest = ["--tool", "endmill-12-long", "--seed", "5200"];
        let found = named(&spindle, &hidden, &rest);
        let delay = value_of(&found, EffectKind::LoopDelay, "delay_s");
        assert!((delay / 2.2226e-5 - 1.0).abs() < 5e-3, "{delay}");
        let stiffness = value_of(&found, tilting, "stiffness_n_m_per_rad");
        assert!((stiffness / -25_395.0 - 1.0).abs() < 0.03, "{stiffness}");
    }
}
