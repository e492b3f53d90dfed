//! A loop that is unstable is said to be, by every command that closes it, with the rate at which it grows and without
//! a figure that has no meaning; and a controller finds the machine that it was designed for.

use crate::cli::program::muspin;
use muspin::controller::{ControlLaw, Controller, MachineTag};
use muspin::export::json::controller_json;
use muspin::input::{load_controller, load_machine, spindle_yaml, tool_yaml};
use muspin::lti::StateSpace;
use muspin::lti::sample::tustin;
use muspin::spindle::Machine;
use serde_json::Value;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/diagnosis/c03");

/// The PID that levitates the updated reference spindle, sampled; with the wrong sign when asked.
fn pid(sign: f64) -> Controller {
    let law = load_controller(&format!("{DATA}/pid.json")).unwrap().law;
    let ControlLaw::Continuous(law) = law else { panic!("continuous") };
    let law = tustin(&law, 5e-5).unwrap();
    Controller {
        name: "start".to_owned(),
        law: ControlLaw::Discrete(StateSpace { c: &law.c * sign, d: &law.d * sign, ..law }),
    }
}

fn machine() -> Machine {
    let files = ["spindle.yaml", "tool.yaml"].map(|name| format!("{DATA}/{name}"));
    load_machine(&files[0], &files[1]).unwrap()
}

/// A folder with the machine and the PID of the wrong sign, which says that it was designed for another machine.
fn wrong() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let another =
        MachineTag { spindle: "another.yaml".to_owned(), tool: "another-tool.yaml".to_owned(), hash: "0".repeat(64) };
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("wrong.json"), controller_json(&pid(-1.0), Some(&another))).unwrap();
    for name in ["spindle.yaml", "tool.yaml"] {
        std::fs::copy(format!("{DATA}/{name}"), path(name)).unwrap();
    }
    folder
}

/// The growth rate that the first line states, 1/s; that the controller is of another machine comes after it.
fn growth(text: &str) -> f64 {
    let warned = text.lines().skip(1).any(|l| l.contains("another machine"));
    assert!(warned, "{text}");
    let line = text.lines().next().unwrap_or_default();
    let (_, after) = line.split_once("unstable: the closed loop grows by ").unwrap();
    after.split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn the_compliance_of_an_unstable_loop_is_not_printed() {
    let folder = wrong();
    let arguments = ["frf", "--controller", "wrong.json", "--points", "3"];
    let (code, out, err) = muspin(&arguments, folder.path());
    assert_eq!((code, out.as_str()), (1, ""), "{err}");
    // The magnets alone let the rotor fall at some 100 1/s; the wrong sign pushes.
    assert!(growth(&err) > 100.0, "{err}");
    let stable = controller_json(&pid(1.0), None);
    std::fs::write(folder.path().join("right.json"), stable).unwrap();
    let arguments = ["frf", "--controller", "right.json", "--points", "3"];
    let (code, out, err) = muspin(&arguments, folder.path());
    assert_eq!((code, out.lines().count()), (0, 4), "{err}");
}

#[test]
fn a_simulation_of_an_unstable_loop_meets_nothing_and_has_no_zone() {
    let folder = wrong();
    let arguments = ["simulate", "--controller", "wrong.json", "--case", "impulse", "--duration", "0.01"];
    let (code, out, err) = muspin(&arguments, folder.path());
    assert_eq!(code, 1, "{err}");
    let rate = growth(&err);
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(summary["verdict"]["met"], false);
    let written = summary["stability"]["growth_rate_per_s"].as_f64().unwrap();
    assert!((written - rate).abs() < 0.01, "{written} {rate}");
    assert!(!out.contains("vibration_zone"), "{out}");
}

#[test]
fn an_unstable_loop_is_not_exported() {
    let folder = wrong();
    let arguments = ["export", "--controller", "wrong.json", "--out", "x"];
    let (code, out, err) = muspin(&arguments, folder.path());
    assert_eq!((code, out.as_str()), (1, ""), "{err}");
    assert!(growth(&err) > 100.0 && err.contains("nothing was written"), "{err}");
    assert!(!folder.path().join("x").exists());
}

#[test]
fn a_comparison_says_nothing_about_the_stiffness_of_an_unstable_loop() {
    let folder = wrong();
    let arguments = ["compare", "--controller", "wrong.json", "--speeds", "0", "--out", "c"];
    let (code, out, err) = muspin(&arguments, folder.path());
    assert_eq!(code, 1, "{err}");
    assert!(growth(&err) > 100.0, "{err}");
    let summary: Value = serde_json::from_str(&out).unwrap();
    let of = |pointer: &str| summary.pointer(pointer).unwrap();
    for key in ["minimum_n_per_m", "at_10_hz_n_per_m", "at_max_speed_n_per_m"] {
        assert!(of(&format!("/stiffness/start/{key}")).is_null(), "{key}");
    }
    assert!(of("/stiffness/start/reason").as_str().unwrap().contains("1/s"));
    assert!(of("/sensitivity/start/zone").is_null());
    assert!(of("/sensitivity/start/front_db").is_null());
    assert!(of("/chatter/start/minimum_depth_m").is_null());
    let worst = of("/worst_case/start").as_array().unwrap();
    let last = worst.last().unwrap().pointer("/least_stiffness").unwrap();
    assert!(last["not_below_n_per_m"].is_null() && last["reason"].is_string());
    assert_eq!(of("/verdict/met"), false);
}

#[test]
fn a_controller_finds_the_machine_beside_it_and_says_when_another_is_used() {
    // A negative stiffness of its own tells this machine from the one of the data.
    let mut machine = machine();
    machine.spindle.front.ks_n_per_m *= 1.01;
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::create_dir(path("controller")).unwrap();
    std::fs::write(path("spindle.yaml"), spindle_yaml(&machine.spindle)).unwrap();
    std::fs::write(path("tool.yaml"), tool_yaml(&machine.tool)).unwrap();
    std::fs::write(path("controller/k.json"), controller_json(&pid(1.0), None)).unwrap();
    let frf = |more: &[&str]| {
        let usual = ["frf", "--controller", "controller/k.json", "--points", "2"];
        let (code, out, err) = muspin(&[&usual[..], more].concat(), folder.path());
        assert_eq!(code, 0, "{err}");
        (out, err)
    };
    let (found, _) = frf(&[]);
    let (named, _) = frf(&["--spindle", "spindle.yaml", "--tool", "tool.yaml"]);
    let other = [format!("{DATA}/spindle.yaml"), format!("{DATA}/tool.yaml")];
    let (another, _) = frf(&["--spindle", &other[0], "--tool", &other[1]]);
    assert_eq!(found, named);
    assert_ne!(found, another);

    // The tag of a forced export of it: the hash is that of the machine, layout and comments apart.
    let simulate = |controller: &str, more: &[&str]| {
        let usual = ["simulate", "--controller", controller, "--case", "impulse", "--duration", "0.01"];
        let (_, out, err) = muspin(&[&usual[..], more].concat(), folder.path());
        let summary: Value = serde_json::from_str(&out).unwrap();
        (summary["machine"].clone(), err)
    };
    let (used, err) = simulate("controller/k.json", &[]);
    assert!(used["is_that_of_the_design"].is_null(), "{used}");
    assert!(!err.contains("another machine"), "{err}");
    let tag = MachineTag {
        spindle: "../spindle.yaml".to_owned(),
        tool: "../tool.yaml".to_owned(),
        hash: used["hash"].as_str().unwrap().to_owned(),
    };
    let tagged = controller_json(&pid(1.0), Some(&tag));
    std::fs::write(path("controller/tagged.json"), tagged).unwrap();
    let commented = format!("# another layout\n{}", spindle_yaml(&machine.spindle));
    std::fs::write(path("spindle.yaml"), commented).unwrap();
    let (used, err) = simulate("controller/tagged.json", &[]);
    assert_eq!(used["is_that_of_the_design"], true);
    assert!(!err.contains("another machine"), "{err}");
    let (used, err) = simulate("controller/tagged.json", &["--spindle", "reference"]);
    assert_eq!(used["is_that_of_the_design"], false);
    assert!(err.contains("warning") && err.contains("another machine"), "{err}");
}
