//! The rotor model against an independent FE code, exact beam theory and textbook values (tests/data/rotor).

use crate::rotor::rotor_cases::*;
use muspin::linalg::{Mat, c64};
use muspin::rotor::modes::RIGID;
use muspin::rotor::zeros::zeros_hz;
use muspin::rotor::{Damping, PlanarModes, Rotor, Section, Support};
use serde_json::Value;
use std::f64::consts::TAU;

const ROTORS: [&str; 6] = [
    "r01_uniform_free",
    "r02_spindle_a_nominal",
    "r03_spindle_a_on_ambs",
    "r04_two_disc_anisotropic",
    "r05_tapered_overhung_tool",
    "r06_open_loop_magnets",
];

/// What the independent code supports with its 12 printed digits and rounding of its own eigensolver.
const FREQUENCY: f64 = 1e-8;

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    let scale = expected.abs().max(f64::MIN_POSITIVE);
    let error = (found - expected).abs() / scale;
    assert!(error <= tolerance, "{what}: found {found}, expected {expected}, relative error {error:.1e}");
}

#[test]
fn mass_properties_agree_with_the_independent_code() {
    for name in ROTORS {
        let case = load(name);
        let found = rotor(&case["model"]).mass_properties();
        let e = &case["expected"]["properties"];
        close(found.mass_kg, number(e, "mass_kg"), 1e-11, name);
        close(found.centre_of_gravity_m, number(e, "cg_z_m"), 1e-11, name);
        close(found.polar_inertia_kg_m2, number(e, "Ip_kgm2"), 1e-11, name);
        let diametral = number(e, "Id_cg_kgm2");
        close(found.diametral_inertia_kg_m2, diametral, 1e-11, name);
    }
}

#[test]
fn whirl_modes_at_four_speeds_agree_with_the_independent_code() {
    for name in ROTORS {
        let case = load(name);
        let model = &case["model"];
        let (rotor, damping, supports) = (rotor(model), damping(model), supports(model));
        for speed in case["expected"]["speeds"].as_array().unwrap() {
            let rpm = number(speed, "rpm");
            let found = rotor.whirl(rpm * TAU / 60.0, &damping, &supports, 6000.0).unwrap();
            let expected = speed["modes"].as_array().unwrap();
            assert_eq!(found.modes.len(), expected.len(), "{name} at {rpm} rpm");
            for (f, e) in found.modes.iter().zip(expected) {
                let what = format!("{name} at {rpm} rpm");
                close(f.natural_rad_s / TAU, number(e, "wn_hz"), FREQUENCY, &what);
                close(f.damped_rad_s / TAU, number(e, "wd_hz"), FREQUENCY, &what);
                let zeta = number(e, "zeta");
                // The reference's own rounding shows in the damping of the slow precession: 2e-8.
                assert!((f.damping_ratio - zeta).abs() < 1e-7, "{what}: ζ {zeta}");
                let whirl = number(e, "whirl");
                assert!((f.whirl - whirl).abs() < 1e-6, "{what}: whirl {whirl}, {}", f.whirl);
            }
            let poles = numbers(&speed["unstable_real_poles_rad_s"]);
            assert_eq!(found.unstable_real_poles_rad_s.len(), poles.len(), "{name}");
            for (f, e) in found.unstable_real_poles_rad_s.iter().zip(poles) {
                close(*f, e, FREQUENCY, name);
            }
        }
    }
}

#[test]
fn planar_mode_shapes_agree_with_the_independent_code() {
    for name in ROTORS {
        let case = load(name);
        let planar = &case["expected"]["planar_modes_0rpm"];
        if planar.is_null() {
            continue;
        }
        let modes = PlanarModes::new(&rotor(&case["model"])).unwrap();
        for (f, e) in modes.flexible_hz().iter().zip(numbers(&planar["f_hz"])) {
            close(*f, e, FREQUENCY, name);
        }
        let shapes = planar["w_mass_normalised_by_mode"].as_array().unwrap();
        for (k, shape) in shapes.iter().enumerate() {
            let expected = numbers(shape);
            let largest = expected.iter().fold(0.0f64, |m, w| m.max(w.abs()));
            for (node, w) in expected.iter().enumerate() {
                let found = modes.shapes[(2 * node, k + RIGID)];
                assert!((found - w).abs() < 1e-7 * largest, "{name} mode {k} node {node}");
            }
        }
    }
}

fn station(case: &Value, name: &str) -> f64 {
    let node = case["model"]["stations"][name].as_u64().unwrap() as usize;
    numbers(&case["model"]["node_z_m"])[node]
}

#[test]
fn antiresonances_of_the_full_and_the_truncated_model_agree_with_the_independent_code() {
    for name in ROTORS {
        let case = load(name);
        let zeros = &case["expected"]["antiresonances_hz"];
        if zeros.is_null() {
            continue;
        }
        let rotor = rotor(&case["model"]);
        let modes = PlanarModes::new(&rotor).unwrap();
        let pairs = [
            ("11", "front_actuator", "front_sensor"),
            ("33", "rear_actuator", "rear_sensor"),
            ("tool", "tool", "tool"),
        ];
        for (id, actuator, sensor) in pairs {
            let (a, s) = (station(&case, actuator), station(&case, sensor));
            let amplitudes = |z| modes.amplitudes(&rotor.shape_at("station", z).unwrap());
            let (b, c) = (amplitudes(a), amplitudes(s));
            let full = rotor.antiresonances_hz(a, s, 100.0, 5000.0).unwrap();
            let cut = RIGID + 3;
            let omega = &modes.omega_rad_s[..cut];
            let truncated = zeros_hz(omega, &b[..cut], &c[..cut], 100.0, 5000.0).unwrap();
            for (kind, found) in [("full", full), ("truncated_5_modes", truncated)] {
                let expected = numbers(&zeros[id][kind]);
                assert!(found.len() >= expected.len(), "{name} {id} {kind}: {found:?}");
                for (f, e) in found.iter().zip(&expected) {
                    close(*f, *e, FREQUENCY, &format!("{name} {id} {kind}"));
                }
            }
        }
    }
}

/// Dynamic stiffness of both planes in the dofs of the FE model: the plainest road to a receptance.
pub fn receptance(rotor: &Rotor, damping: &Damping, supports: &[Support], speed: f64, omega: f64) -> Mat<c64> {
    let m = rotor.plane_matrices();
    let n = rotor.dofs();
    let mut c = Mat::<f64>::zeros(n, n);
    match damping {
        Damping::None => {}
        Damping::Proportional { alpha, beta } => {
            c = Mat::from_fn(n, n, |i, j| alpha * m.shaft_mass[(i, j)] + beta * m.stiffness[(i, j)]);
        }
        Damping::Modal(ratios) => {
            let modes = PlanarModes::new(rotor).unwrap();
            let mv = &m.mass * &modes.shapes;
            for (k, z) in ratios.iter().enumerate() {
                let (k, w) = (k + RIGID, modes.omega_rad_s[k + RIGID]);
                c = Mat::from_fn(n, n, |i, j| c[(i, j)] + 2.0 * z * w * mv[(i, k)] * mv[(j, k)]);
            }
        }
    }
    let mut z = Mat::from_fn(2 * n, 2 * n, |i, j| {
        let (p, q, r, s) = (i / n, j / n, i % n, j % n);
        if p == q {
            c64::new(m.stiffness[(r, s)] - omega * omega * m.mass[(r, s)], omega * c[(r, s)])
        } else {
            let sign = if p == 0 { 1.0 } else { -1.0 };
            c64::new(0.0, sign * omega * speed * m.gyroscopic[(r, s)])
        }
    });
    for support in supports {
        let row = rotor.shape_at("support", support.position_m).unwrap();
        let node = row[0].0;
        for p in 0..2 {
            for q in 0..2 {
                z[(p * n + node, q * n + node)] +=
                    c64::new(support.stiffness_n_per_m[p][q], omega * support.damping_n_s_per_m[p][q]);
            }
        }
    }
    muspin::linalg::solve_complex(&z, &Mat::identity(2 * n, 2 * n))
}

#[test]
fn receptances_at_rest_and_at_25_krpm_agree_with_the_independent_code() {
    for name in ROTORS {
        let case = load(name);
        let model = &case["model"];
        let (rotor, damping, supports) = (rotor(model), damping(model), supports(model));
        let frf = &case["expected"]["frf"];
        let frequencies = numbers(&frf["f_hz"]);
        // Every eighth line: each costs the inverse of the whole FE model.
        for (line, hz) in frequencies.iter().enumerate().step_by(8) {
            for rpm in [0.0, 25000.0] {
                let speed = rpm * TAU / 60.0;
                let h = receptance(&rotor, &damping, &supports, speed, TAU * hz);
                for curve in frf["data"].as_array().unwrap() {
                    if number(curve, "rpm") != rpm {
                        continue;
                    }
                    let dof = |key| 2 * curve[key].as_u64().unwrap() as usize;
                    let turned = curve["direction"] == "x->y";
                    let out = dof("out_node") + if turned { rotor.dofs() } else { 0 };
                    let found = h[(out, dof("in_node"))];
                    let part = |key: &str| curve[key][line].as_f64().unwrap();
                    let expected = c64::new(part("re"), part("im"));
                    let largest = numbers(&curve["re"]).into_iter().map(f64::abs);
                    let floor = 1e-9 * largest.fold(0.0, f64::max);
                    let error = (found - expected).norm() / (expected.norm() + floor);
                    assert!(error < 1e-6, "{name} {rpm} rpm {hz} Hz: {error:.1e}");
                }
            }
        }
    }
}

fn uniform(section: &Value, elements: usize) -> Vec<Section> {
    let length = number(section, "L") / elements as f64;
    let base = Section {
        material: material(section),
        shear: shear(&section["shear"]),
        rotary_inertia: section["rotary_inertia"].as_bool().unwrap_or(true),
        ..Section::cylinder(length, number(section, "od"), number(section, "id"), material(section))
    };
    vec![base; elements]
}

fn beam(id: &str) -> Value {
    let all = load("beams");
    let cases = all["cases"].as_array().unwrap();
    cases.iter().find(|c| c["id"] == id).unwrap().clone()
}

/// Supports so stiff that the end is held; the deflection they leave is below the tolerance.
fn held(position_m: f64) -> Support {
    Support { position_m, stiffness_n_per_m: [[1e13, 0.0], [0.0, 1e13]], damping_n_s_per_m: [[0.0; 2]; 2] }
}

#[test]
fn free_beams_converge_to_exact_theory() {
    // h² convergence with shear, h⁴ without (hint of the case file).
    for (id, elements, tolerance) in [("eb_free-free", 60, 1e-5), ("timo_free_free", 140, 2e-4)] {
        let case = beam(id);
        let rotor = Rotor::new(0.0, uniform(&case["section"], elements), &[]).unwrap();
        let found = PlanarModes::new(&rotor).unwrap().flexible_hz();
        for (f, e) in found.iter().zip(numbers(&case["f_hz"])) {
            close(*f, e, tolerance, id);
        }
    }
}

#[test]
fn a_clamped_beam_converges_to_exact_theory() {
    let case = beam("eb_clamped-free");
    let sections = uniform(&case["section"], 60);
    let l = sections[0].length_m;
    // Clamped: two stiff supports a hundredth of an element apart would spoil the mesh; double the beam instead and
    // take the symmetric modes of a beam held in the middle — its halves are clamped there by symmetry.
    let doubled = [sections.clone(), sections].concat();
    let rotor = Rotor::new(0.0, doubled, &[]).unwrap();
    let middle = 60.0 * l;
    let found = rotor.whirl(0.0, &Damping::None, &[held(middle)], 7000.0).unwrap();
    let hz: Vec<f64> = found.modes.iter().map(|m| m.damped_rad_s / TAU).collect();
    for e in numbers(&case["f_hz"]).into_iter().filter(|f| *f < 6900.0) {
        let best = hz.iter().map(|f| (f - e).abs() / e).fold(1.0, f64::min);
        // h⁴ convergence: 1.5e-5 in the fifth mode.
        assert!(best < 2e-5, "{e} Hz: {best:.1e}");
    }
}

#[test]
fn a_spinning_pinned_shaft_splits_as_the_closed_form_says() {
    let case = beam("timo_pinned_spinning");
    let sections = uniform(&case["section"], 80);
    let length = number(&case["section"], "L");
    let rotor = Rotor::new(0.0, sections, &[]).unwrap();
    for row in case["whirl"].as_array().unwrap() {
        let speed = number(row, "rpm") * TAU / 60.0;
        let supports = [held(0.0), held(length)];
        let found = rotor.whirl(speed, &Damping::None, &supports, 9000.0).unwrap();
        for (key, sign) in [("backward_hz", -1.0), ("forward_hz", 1.0)] {
            let e = number(row, key);
            let same = found.modes.iter().filter(|m| m.whirl == sign || speed == 0.0);
            let best = same.map(|m| (m.damped_rad_s / TAU - e).abs() / e).fold(1.0, f64::min);
            assert!(best < 2e-4, "{row}: {best:.1e}");
        }
    }
}

#[test]
fn a_stepped_shaft_converges_to_the_distributed_solution() {
    let case = beam("timo_stepped_free_free");
    let parts = case["sections"].as_array().unwrap();
    let sections: Vec<Section> = parts.iter().flat_map(|s| uniform(s, 60)).collect();
    let rotor = Rotor::new(0.0, sections, &[]).unwrap();
    let found = PlanarModes::new(&rotor).unwrap().flexible_hz();
    for (f, e) in found.iter().zip(numbers(&case["f_hz"])) {
        close(*f, e, 2e-4, "stepped");
    }
    for row in case["whirl"].as_array().unwrap() {
        let speed = number(row, "rpm") * TAU / 60.0;
        let found = rotor.whirl(speed, &Damping::None, &[], 8000.0).unwrap();
        for (key, sign) in [("backward_hz", -1.0), ("forward_hz", 1.0)] {
            for e in numbers(&row[key]) {
                let same = found.modes.iter().filter(|m| m.whirl == sign);
                let best = same.map(|m| (m.damped_rad_s / TAU - e).abs() / e).fold(1.0, f64::min);
                assert!(best < 2e-4, "{e} Hz: {best:.1e}");
            }
        }
    }
    let zeros = rotor.antiresonances_hz(0.03, 0.03, 100.0, 5000.0).unwrap();
    for (f, e) in zeros.iter().zip(numbers(&case["antiresonance"]["f_hz"])) {
        close(*f, e, 2e-4, "stepped antiresonance");
    }
}

#[test]
fn textbook_rotors_come_out_as_published() {
    let all = load("published");
    for case in all["cases"].as_array().unwrap() {
        let model = &case["model"];
        let (rotor, supports) = (rotor(model), supports(model));
        let id = case["id"].as_str().unwrap();
        if id.starts_with("nelson") {
            let (forward, backward) = rotor.critical_speeds_rad_s(&supports).unwrap();
            let computed = &case["computed"]["rayleigh"];
            for (key, found) in [("forward", forward), ("backward", backward)] {
                for (f, e) in found.iter().zip(numbers(&computed[key])) {
                    close(f * 60.0 / TAU, e, 1e-8, id);
                }
                for (f, e) in found.iter().zip(numbers(&case["published"][key])) {
                    close(f * 60.0 / TAU, e, number(case, "tolerance_rel"), id);
                }
            }
            continue;
        }
        for (rpm, rows) in case["computed"].as_object().unwrap() {
            let speed = rpm.parse::<f64>().unwrap() * TAU / 60.0;
            let found = rotor.whirl(speed, &Damping::None, &supports, 300.0).unwrap();
            for (f, e) in found.modes.iter().zip(rows.as_array().unwrap()) {
                close(f.damped_rad_s, number(e, "wd_rad_s"), FREQUENCY, id);
                assert!((f.whirl - number(e, "whirl")).abs() < 1e-6, "{id}");
            }
            for (f, e) in found.modes.iter().zip(numbers(&case["published"][rpm])) {
                close(f.damped_rad_s, e, 1e-3, id);
            }
        }
    }
}
