//! `muspin diagnose` of a hanging rotor: a mass that the drawing lacks, a soft region, and neither.

use crate::cli::program::muspin;
use crate::spindle::rotors_without_magnets::{coarse_bar, hanging_bar, hits};
use serde_json::Value;
use std::path::Path;

/// A drive point, and two responses that are held out.
const PLACES_M: [[f64; 2]; 3] = [[0.45, 0.45], [0.45, 1.2], [0.45, 0.1]];

fn diagnose(folder: &Path, spindle: &str) -> (i32, Value, String) {
    // Results in a folder below that of the records are replaced by the next run.
    let command = ["diagnose", "--measurement", ".", "--spindle", spindle, "--out", "found", "--json"];
    let (code, out, err) = muspin(&command, folder);
    if let Ok(text) = std::fs::read(folder.join("found/spindle.yaml")) {
        std::fs::write(folder.join("corrected.yaml"), text).unwrap();
    }
    let answer: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{err}"));
    (code, answer["diagnosis"].clone(), err)
}

fn disc(position_m: f64, mass_kg: f64) -> String {
    format!(
        "  discs:\n    - {{position_m: {position_m}, mass_kg: {mass_kg}, polar_inertia_kg_m2: 0, \
             diametral_inertia_kg_m2: 0}}\n"
    )
}

#[test]
fn a_rotor_as_drawn_is_adequate() {
    let folder = tempfile::tempdir().unwrap();
    hits(folder.path(), &hanging_bar(""), &PLACES_M);
    let (code, found, err) = diagnose(folder.path(), "rotor.yaml");
    assert_eq!((code, &found["verdict"]), (0, &Value::from("adequate")), "{err}");
    assert_eq!(found["effects"].as_array().unwrap().len(), 0);
}

/// What elements that are too long leave is no effect: the element to split is said, by `update` as well.
#[test]
fn an_element_that_is_too_long_for_the_measured_modes_is_said() {
    let folder = tempfile::tempdir().unwrap();
    hits(folder.path(), &hanging_bar(""), &PLACES_M);
    std::fs::write(folder.path().join("rotor.yaml"), coarse_bar()).unwrap();
    let (code, found, err) = diagnose(folder.path(), "rotor.yaml");
    assert!(code == 1 && err.contains("is too long for mode"), "{found} {err}");
    let (code, _, err) = muspin(&["update", "--measurement", ".", "--out", "updated"], folder.path());
    assert!(code == 1 && err.contains("is too long for mode"), "{err}");
}

#[test]
fn a_hidden_mass_is_named_with_its_place_and_the_corrected_file_is_adequate() {
    let folder = tempfile::tempdir().unwrap();
    hits(folder.path(), &hanging_bar(&disc(0.7, 0.2)), &PLACES_M);
    let (code, found, err) = diagnose(folder.path(), "rotor.yaml");
    assert_eq!((code, &found["verdict"]), (0, &Value::from("named")), "{err}");
    let effect = &found["effects"][0];
    assert_eq!(effect["effect"], "added_mass");
    let (place_m, mass_kg) = (effect["where"]["position_m"].as_f64(), effect["parameters"]["mass_kg"].as_f64());
    // A hundredth of the length, and what half a per cent of noise leaves of a thirtieth of the rotor.
    assert!((place_m.unwrap() - 0.7).abs() < 0.02 && (mass_kg.unwrap() / 0.2 - 1.0).abs() < 0.1, "{effect}");
    assert!(err.contains("a mass of"), "{err}");
    let (code, found, err) = diagnose(folder.path(), "corrected.yaml");
    assert_eq!((code, &found["verdict"]), (0, &Value::from("adequate")), "{err}");
}

#[test]
fn a_soft_region_is_named_and_needs_held_out_data_to_be_more_than_probable() {
    let folder = tempfile::tempdir().unwrap();
    let truth = hanging_bar("").replace("region: end", "region: end, modulus_scale: 0.8");
    for (places, verdict) in [(&PLACES_M[..], "named"), (&PLACES_M[..1], "probable")] {
        hits(folder.path(), &truth, places);
        let (code, found, err) = diagnose(folder.path(), "rotor.yaml");
        assert_eq!((code, &found["verdict"]), (0, &Value::from(verdict)), "{err}");
        let effect = &found["effects"][0];
        assert_eq!(effect["effect"], "region_stiffness");
        assert_eq!(effect["where"]["region"], "end");
        assert!((effect["parameters"]["factor"].as_f64().unwrap() / 0.8 - 1.0).abs() < 0.03, "{effect}");
    }
}

#[test]
fn two_changes_at_once_are_not_called_one() {
    let folder = tempfile::tempdir().unwrap();
    let truth = hanging_bar(&disc(0.7, 0.4)).replace("region: end", "region: end, modulus_scale: 0.5");
    hits(folder.path(), &truth, &PLACES_M);
    let (code, found, err) = diagnose(folder.path(), "rotor.yaml");
    assert_eq!((code, &found["verdict"]), (1, &Value::from("unexplained")), "{err}");
    assert!(err.contains("no single change"), "{err}");
}

#[test]
fn the_page_shows_errors_and_changes_and_is_made_again_from_its_summary() {
    let folder = tempfile::tempdir().unwrap();
    hits(folder.path(), &hanging_bar(&disc(0.7, 0.2)), &PLACES_M);
    let found = folder.path().with_extension("found");
    let out = found.to_str().unwrap();
    let command = ["diagnose", "--measurement", ".", "--spindle", "rotor.yaml", "--out", out, "--format", "pdf"];
    let (code, _, err) = muspin(&command, folder.path());
    assert_eq!(code, 0, "{err}");
    let page = std::fs::read_to_string(found.join("report.html")).unwrap();
    for shown in ["a mass of", "Single changes, best first", "Errors of the model", "explained below"] {
        assert!(page.contains(shown), "{shown}");
    }
    assert!(found.join("plots/ranking.pdf").exists());
    let rows = std::fs::read_to_string(found.join("errors.csv")).unwrap();
    assert!(rows.lines().next().unwrap().contains("with the change_error_percent"), "{rows}");
    let (code, _, err) = muspin(&["report", out], folder.path());
    assert_eq!(code, 0, "{err}");
    assert_eq!(std::fs::read_to_string(found.join("report.html")).unwrap(), page);
    std::fs::remove_dir_all(&found).unwrap();
}
