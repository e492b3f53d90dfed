//! Rotors without magnets, by file and command: published tables, and a hanging rotor that is hit with a hammer.

use crate::cli::program::muspin;
use crate::rotor::rotor_reference::receptance;
use muspin::input::{load_measurement, read_rotor};
use muspin::linalg::c64;
use muspin::rotor::{Damping, PlanarModes};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

/// Elements of a cylinder.
fn elements(length_m: f64, diameters_m: [f64; 2], count: usize, region: &str) -> String {
    let one = format!(
        "    - {{length_m: {}, outer_diameter_m: {}, inner_diameter_m: {}, material: steel, region: {region}}}\n",
        length_m / count as f64,
        diameters_m[0],
        diameters_m[1]
    );
    one.repeat(count)
}

fn rotor_file(material: [f64; 3], elements: &str, rest: &str) -> String {
    let [e, rho, nu] = material;
    format!(
        "name: rotor\nrotor:\n  materials:\n    steel: {{youngs_modulus_pa: {e:.3}, density_kg_m3: {rho}, \
         poisson_ratio: {nu}}}\n  elements:\n{elements}  damping_ratio: [0.001]\n{rest}"
    )
}

/// Natural frequencies of `rotor.yaml`, Hz, each of both planes, at speeds in rpm.
fn modes(folder: &Path, text: &str, speeds: &str) -> Vec<Vec<f64>> {
    std::fs::write(folder.join("rotor.yaml"), text).unwrap();
    let (code, out, err) = muspin(&["modes", "--spindle", "rotor.yaml", "--speeds", speeds, "--json"], folder);
    assert_eq!(code, 0, "{err}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    let list = |speed: &Value| {
        let all = speed["damped_frequencies_hz"].as_array().unwrap();
        all.iter().map(|x| x.as_f64().unwrap()).collect()
    };
    answer["speeds"].as_array().unwrap().iter().map(list).collect()
}

/// Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines (2010), example 5.9.1: two discs on two bearings of
/// 1 MN/m, six elements; rad/s to five digits.
#[test]
fn a_two_disc_rotor_on_springs_has_the_frequencies_of_the_book() {
    let folder = tempfile::tempdir().unwrap();
    let rest = "  discs:\n    - {position_m: 0.5, mass_kg: 32.59, polar_inertia_kg_m2: 0.32914, \
                diametral_inertia_kg_m2: 0.17808}\n    - {position_m: 1.0, mass_kg: 51.475, polar_inertia_kg_m2: \
                0.80431, diametral_inertia_kg_m2: 0.42326}\nsupports:\n  - {position_m: 0, stiffness_n_per_m: \
                1.0e+6}\n  - {position_m: 1.5, stiffness_n_per_m: 1.0e+6}\n";
    let text = rotor_file([2.11e11, 7810.0, 0.299_261], &elements(1.5, [0.05, 0.0], 6, "shaft"), rest);
    let found = modes(folder.path(), &text.replace("[0.001]", "[0]"), "0,4000");
    let published = [[86.66, 86.66, 274.31, 274.31, 716.78], [85.39, 87.80, 251.78, 294.71, 600.18]];
    for (found, published) in found.iter().zip(published) {
        for (f, e) in found.iter().zip(published) {
            let rad_s = f * std::f64::consts::TAU;
            assert!((rad_s / e - 1.0).abs() < 1e-3, "{rad_s} {e}");
        }
    }
}

/// A tube of 1.3 m on cords, which its author calculates with the shear coefficient of a full section (κ = 0.886; 111.68,
/// 306.33, 596.16, 976.08 Hz), and the cylinder 300/30.08/7 mm that a finite-element code of solids gives 1536.02 Hz. A
/// hollow section has a smaller coefficient: below, by some tenths of a per cent in a short mode.
#[test]
fn free_shafts_have_the_published_frequencies() {
    let folder = tempfile::tempdir().unwrap();
    let tube = rotor_file([2.06e11, 7850.0, 0.3], &elements(1.3, [0.03516, 0.02205], 52, "bar"), "");
    let found = modes(folder.path(), &tube, "0");
    let planes: Vec<f64> = found[0].iter().step_by(2).copied().collect();
    for (f, e) in planes.iter().zip([111.7, 306.3, 596.3, 976.8]) {
        // Half a unit of the last digit above; the coefficient below, which grows with the frequency.
        assert!(*f < e + 0.05 && *f > e * (1.0 - 0.01 * e / 976.8), "{planes:?}");
    }
    // Steel of 210 GPa, the usual one of such codes.
    let cylinder = rotor_file([2.1e11, 7850.0, 0.3], &elements(0.3, [0.03008, 0.007], 40, "shaft"), "");
    let first = modes(folder.path(), &cylinder, "0")[0][0];
    assert!((first / 1536.02 - 1.0).abs() < 2e-3, "{first}");
}

/// A bar of two regions that hangs from two cords, as its file has it; `rest` stands behind its elements.
pub fn hanging_bar(rest: &str) -> String {
    rotor_file([2.06e11, 7850.0, 0.3], &bar(), &format!("{rest}{CORDS}"))
}

/// The same bar with elements that are too long for its modes.
pub fn coarse_bar() -> String {
    let [bar, end] = [(1.0, 4, "bar"), (0.3, 1, "end")]
        .map(|(length_m, count, region)| elements(length_m, [0.035, 0.022], count, region));
    rotor_file([2.06e11, 7850.0, 0.3], &format!("{bar}{end}"), CORDS)
}

/// A measurement of the bar: displacement over force with noise, as a hammer gives it, of a rotor file.
pub fn hits(folder: &Path, truth: &str, places_m: &[[f64; 2]]) {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut gauss = || -> f64 { StandardNormal.sample(&mut rng) };
    let truth = read_rotor("truth.yaml", truth).unwrap();
    let lines: Vec<f64> = (0..4200).map(|k| 50.0 + 0.25 * f64::from(k)).collect();
    let mut list = "spindle: rotor.yaml\ntool: none\nrecords:\n".to_owned();
    for (k, places) in places_m.iter().enumerate() {
        let mut text = "frequency_hz,h_re,h_im\n".to_owned();
        for (hz, h) in lines.iter().zip(truth.receptance(0.0, *places, &lines).unwrap()) {
            let h = h[0][0] * c64::new(1.0 + 0.005 * gauss(), 0.005 * gauss());
            let _ = writeln!(text, "{hz},{:e},{:e}", h.re, h.im);
        }
        std::fs::write(folder.join(format!("hit-{k}.csv")), text).unwrap();
        let [response, force] = places;
        let _ = writeln!(
            list,
            "  - {{kind: hammer, file: hit-{k}.csv, speed_rpm: 0, response_m: {response}, force_m: {force}}}"
        );
    }
    std::fs::write(folder.join("measurement.yaml"), list).unwrap();
    std::fs::write(folder.join("rotor.yaml"), hanging_bar("")).unwrap();
}

/// The bar with softer regions.
fn soft_bar() -> String {
    let text = hanging_bar("").replace("region: bar", "region: bar, modulus_scale: 0.9");
    text.replace("region: end", "region: end, modulus_scale: 0.7")
}

const CORDS: &str = "supports:\n  - {position_m: 0.3, stiffness_n_per_m: 300}\n  - \
                     {position_m: 1.0, stiffness_n_per_m: 300}\n";

fn bar() -> String {
    let end = elements(0.3, [0.035, 0.022], 6, "end");
    format!("{}{}", elements(1.0, [0.035, 0.022], 20, "bar"), end)
}

#[test]
fn a_hanging_rotor_is_updated_from_hammer_tests_alone() {
    let folder = tempfile::tempdir().unwrap();
    hits(folder.path(), &soft_bar(), &[[0.45, 0.45], [0.45, 1.2]]);
    let (code, out, err) = muspin(&["update", "--measurement", ".", "--out", "up", "--json"], folder.path());
    assert_eq!(code, 0, "{err}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    for (region, factor) in [("bar", 0.9), ("end", 0.7)] {
        let found = answer["updating"]["modulus_factors"][region].as_f64().unwrap();
        assert!((found / factor - 1.0).abs() < 0.01, "{region} {found}");
    }
    // The file that is written is a rotor again, supports included.
    let updated = std::fs::read_to_string(folder.path().join("up/spindle.yaml")).unwrap();
    let rotor = read_rotor("up.yaml", &updated).unwrap();
    assert_eq!(rotor.springs(0), [(0.3, 300.0), (1.0, 300.0)]);
    let (code, _, err) = muspin(&["check", "up/spindle.yaml", "."], folder.path());
    assert_eq!(code, 0, "{err}");
    // What needs magnets says so.
    let (code, _, err) = muspin(&["design", "--spindle", "rotor.yaml"], folder.path());
    assert!(code == 2 && err.contains("a rotor without magnets"), "{err}");
}

/// One sensor, five points that are hit: one set of modes, with the shapes of the eigenvectors.
#[test]
fn a_roving_hammer_gives_the_shapes_of_the_modes() {
    let folder = tempfile::tempdir().unwrap();
    let points = [0.05, 0.3, 0.55, 0.8, 1.2];
    hits(folder.path(), &soft_bar(), &points.map(|z| [0.45, z]));
    let (code, out, err) = muspin(&["identify", "--measurement", ".", "--out", "id", "--json"], folder.path());
    assert_eq!(code, 0, "{err}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(answer["hammers"].as_array().unwrap().len(), 1);
    let hammer = &answer["hammers"][0];
    assert_eq!(hammer["record"], "hit-0.csv, hit-1.csv, hit-2.csv, hit-3.csv, hit-4.csv");
    let rotor = read_rotor("truth.yaml", &soft_bar()).unwrap().rotor().unwrap();
    let modes = PlanarModes::new(&rotor).unwrap();
    let hz = modes.flexible_hz();
    let rows: Vec<Vec<f64>> = points.iter().map(|z| modes.amplitudes(&rotor.shape_at("point", *z).unwrap())).collect();
    let numbers = |list: &Value| list.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<f64>>();
    let found = numbers(&hammer["resonances_hz"]);
    assert_eq!(found.len(), 4, "{found:?}");
    for (k, f) in found.iter().enumerate() {
        assert!((f / hz[k] - 1.0).abs() < 1e-3, "{found:?} {hz:?}");
        let shape = &hammer["mode_shapes"][k];
        assert_eq!(numbers(&shape["position_m"]), points);
        let amplitude = numbers(&shape["amplitude"]);
        // Two rigid modes come first.
        let expected: Vec<f64> = rows.iter().map(|row| row[k + 2]).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mac = dot(&amplitude, &expected).powi(2) / (dot(&amplitude, &amplitude) * dot(&expected, &expected));
        // Noise of half a per cent of each response.
        assert!(mac > 0.999, "{f} {amplitude:?} {expected:?}");
    }
    // The table is a record of mode shapes.
    let list = "spindle: rotor.yaml\ntool: none\nrecords:\n  - {kind: mode_shapes, file: id/mode_shapes-0.csv}\n";
    std::fs::write(folder.path().join("measurement.yaml"), list).unwrap();
    let shapes = load_measurement(folder.path().to_str().unwrap()).unwrap().mode_shapes;
    assert_eq!((shapes.len(), shapes[0].points.len()), (4, 5));
}

#[test]
fn the_response_of_a_rotor_on_supports_is_that_of_its_matrices() {
    let text = rotor_file([2.06e11, 7850.0, 0.3], &elements(0.6, [0.02, 0.0], 6, "bar"), "");
    let disc =
        "  discs:\n    - {position_m: 0.2, mass_kg: 3, polar_inertia_kg_m2: 0.02, diametral_inertia_kg_m2: 0.01}\n";
    let supports = "supports:\n  - {position_m: 0.1, stiffness_n_per_m: {x: 2.0e+6, y: 1.0e+6}, \
                    damping_n_s_per_m: {x: 50}}\n  - {position_m: 0.5, stiffness_n_per_m: {x: 1.0e+6}}\n";
    let model = read_rotor("r.yaml", &format!("{text}{disc}{supports}")).unwrap();
    let (rotor, damping) = (model.rotor().unwrap(), Damping::Modal(vec![0.001; 12]));
    let speed = 800.0;
    let lines = [12.0, 90.0, 260.0, 700.0];
    let found = model.receptance(speed, [0.3, 0.6], &lines).unwrap();
    for (hz, found) in lines.iter().zip(found) {
        let expected = receptance(&rotor, &damping, &model.supports, speed, std::f64::consts::TAU * hz);
        // Nodes 3 and 6, both planes.
        let n = rotor.dofs();
        for (p, row) in found.iter().enumerate() {
            for (q, h) in row.iter().enumerate() {
                let e = expected[(p * n + 6, q * n + 12)];
                assert!((h - e).norm() < 1e-7 * expected[(6, 12)].norm(), "{hz} {p}{q} {h} {e}");
            }
        }
    }
}

#[test]
fn modes_of_a_spindle_count_its_springs() {
    let folder = tempfile::tempdir().unwrap();
    let spindle = std::fs::read_to_string(format!("{}/spindles/reference.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let lowest = |effects: &str| {
        std::fs::write(folder.path().join("s.yaml"), format!("{spindle}\neffects:\n{effects}")).unwrap();
        let (code, out, err) = muspin(&["modes", "--spindle", "s.yaml", "--json"], folder.path());
        assert_eq!(code, 0, "{err}");
        let answer: Value = serde_json::from_str(&out).unwrap();
        (answer["speeds"][0]["natural_frequencies_hz"][0].as_f64().unwrap(), answer, err)
    };
    let (free, answer, _) = lowest("  - {effect: added_mass, position_m: 0.1, mass_kg: 1.0e-6}\n");
    let (centre, mass) = (answer["centre_of_gravity_m"].as_f64().unwrap(), answer["mass_kg"].as_f64().unwrap());
    let spring = format!("  - {{effect: added_stiffness, position_m: {centre}, stiffness_n_per_m: 1.0e+4}}\n");
    let tilting = format!("{spring}  - {{effect: tilting_stiffness, position_m: 0.1, stiffness_n_m_per_rad: 10}}\n");
    let (on_spring, _, err) = lowest(&tilting);
    // A soft spring at the centre of gravity carries the whole rotor.
    let expected = (1e4 / mass).sqrt() / std::f64::consts::TAU;
    assert!(free > 100.0 && (on_spring / expected - 1.0).abs() < 1e-3, "{on_spring} {expected}");
    assert!(err.contains("tilting_stiffness is not in these modes"), "{err}");
}
