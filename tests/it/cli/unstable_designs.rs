//! A design whose loop is unstable at speed says so first, with the rate at which it grows, the mode behind it and no
//! figure of a stable loop, and writes no firmware.

use crate::cli::program::muspin;
use crate::support::files::below_root;
use muspin::controller::ControlLaw;
use muspin::controller::verification::growth_rate;
use muspin::input::{load_controller, load_machine};
use muspin::spindle::{ModelDetail, Plant};
use serde_json::Value;
use std::f64::consts::TAU;
use std::path::Path;

fn rotor(file: &str) -> String {
    below_root(&format!("tests/data/rotors/{file}")).to_str().unwrap().to_owned()
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

/// Tables for a processor; beside the JSON stands the error of its continuous form.
fn has_firmware(folder: &Path) -> bool {
    ["controller.c", "controller.h", "coefficients.csv", "test_vectors.csv", "sections.h", "controller.mat"]
        .iter()
        .any(|name| folder.join(name).exists())
}

/// A rotor of 80 g, whose bending lies above the Nyquist frequency, has no uncertain mode and so no D-scales to draw.
#[test]
fn a_rotor_without_uncertain_modes_is_designed_for() {
    let folder = tempfile::tempdir().unwrap();
    let [spindle, tool] = ["rigid.yaml", "rigid.tool.yaml"]
        .map(|file| below_root(&format!("tests/data/rigid/{file}")).to_str().unwrap().to_owned());
    let arguments = ["design", "--spindle", &spindle, "--tool", &tool, "--no-polish", "--out", "d", "--quiet"];
    let (code, _, err) = muspin(&arguments, folder.path());
    assert!(code < 2, "{err}");
    let out = folder.path().join("d");
    assert_eq!(summary(&out)["design"]["stable"], true);
    assert!(out.join("plots/mu.svg").exists() && !out.join("plots/d_scales.svg").exists());
}

/// A flywheel, designed at rest only, is lost at the nutation of its top speed.
#[test]
fn an_unstable_design_says_so_first_and_writes_no_firmware() {
    let folder = tempfile::tempdir().unwrap();
    let [spindle, tool] = ["n3-flywheel.yaml", "n3-flywheel.tool.yaml"].map(rotor);
    let arguments = ["design", "--spindle", &spindle, "--tool", &tool, "--no-polish", "--text", "--out", "d"];
    let (code, text, err) = muspin(&arguments, folder.path());
    assert_eq!(code, 1, "{err}");
    let first = text.lines().next().unwrap();
    assert!(first.contains("unstable: the closed loop grows by "), "{first}");
    assert!(first.contains("What grows has ") && first.contains("covered"), "{first}");
    for word in ["N/µm", "zone A", "zone B", "zone C", "≤ 1", "muspin export"] {
        assert!(!text.contains(word), "{word}: {text}");
    }
    let out = folder.path().join("d");
    assert!(!has_firmware(&out.join("controller")));
    let found = summary(&out);
    assert_eq!(found["verdict"]["met"], false);
    for key in ["stiffness", "sensitivity", "margins"] {
        assert!(found[key].is_null(), "{key}");
    }
    assert!(found["design"]["table_as_written"]["mu_peak_discrete"].is_null());
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("unstable: the closed loop grows by ") && !page.contains("every specification holds"));
    // The rate and the speed are those of the loop of the files that were written.
    let number = |key: &str| found["instability"][key].as_f64().unwrap();
    let machine = load_machine(&spindle, &tool).unwrap();
    let path = out.join("controller/discrete.json");
    let ControlLaw::Discrete(law) = load_controller(path.to_str().unwrap()).unwrap().law else { panic!("sampled") };
    let plant = Plant::new(&machine, number("speed_rpm") * TAU / 60.0, ModelDetail::Full).unwrap();
    let growth = growth_rate(&plant.sample_plant().unwrap(), &law).unwrap();
    let stated = number("growth_rate_per_s");
    assert!(growth > 0.0 && (stated / growth - 1.0).abs() < 1e-3, "{stated} for {growth}");
    // The rigid rotor's nutation is its speed times the ratio of its inertias, 1.41; its disc bends at 2.9 kHz.
    let mode = &found["instability"]["mode"];
    assert_eq!(mode["kind"], "nutation", "{mode}");
    let free_hz = mode["forward_at_speed_hz"].as_f64().unwrap();
    assert!((free_hz / (1.41 * number("speed_rpm") / 60.0) - 1.0).abs() < 0.03, "{free_hz}");
}

#[test]
fn a_batch_with_an_unstable_design_says_so_first() {
    let folder = tempfile::tempdir().unwrap();
    let [spindle, tool] = ["n3-flywheel.yaml", "n3-flywheel.tool.yaml"].map(rotor);
    let arguments =
        ["batch", "--spindle", &spindle, "--tools", &tool, "--quick", "--no-polish", "--text", "--out", "b"];
    let (code, text, err) = muspin(&arguments, folder.path());
    assert_eq!(code, 1, "{err}");
    let first = text.lines().next().unwrap();
    assert!(first.contains("unstable: the design for stub; 0 of 1 tools"), "{first}");
    let out = folder.path().join("b");
    assert!(!has_firmware(&out.join("stub")));
    let words = summary(&out)["plain_words"][0].as_str().unwrap().to_owned();
    assert!(words.contains("stub: unstable: the closed loop grows by "), "{words}");
    assert!(summary(&out)["table"][0]["minimum_stiffness_mu_n_per_m"].is_null());
    assert_eq!(summary(&out.join("stub"))["verdict"]["met"], false);
    // A row that was written is read back with its reason.
    let (code, again, _) = muspin(&arguments, folder.path());
    assert_eq!((code, again.lines().next()), (1, Some(first)));
}
