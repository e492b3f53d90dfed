//! `muspin solve` against SLICOT, SciPy in many digits and direct minimisation: `tests/data/control/peers`, whose files
//! name their source.

use crate::robust::solve_cases::{matrix, number};
use crate::robust::solve_keys::answer_to;
use serde_json::{Value, json};
use std::path::Path;

/// The cases of a file.
pub fn peers(name: &str) -> Vec<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/control/peers");
    let file: Value = serde_json::from_str(&std::fs::read_to_string(folder.join(name)).unwrap()).unwrap();
    file["cases"].as_array().unwrap().clone()
}

/// The answer to a problem.
pub fn answered(kind: &str, problem: &Value) -> Value {
    answer_to(kind, &problem.to_string())
}

/// A case without its reference numbers.
fn without(case: &Value, names: &[&str]) -> Value {
    let mut problem = case.clone();
    for name in names {
        problem.as_object_mut().unwrap().remove(*name);
    }
    problem
}

#[test]
fn riccati_solutions_of_both_times_are_exact_at_every_size_of_r() {
    for case in peers("riccati.json") {
        let (kind, id) = (case["kind"].as_str().unwrap(), &case["id"]);
        let found = answered(kind, &case["data"]);
        let (x, exact) = (matrix(&found["X"]), matrix(&case["X"]));
        let error = (&x - &exact).norm_l2() / exact.norm_l2();
        // Rounding of the data by the balancing and of the answer; SciPy is off by up to 1e-10.
        assert!(error < 1e-14, "{id}: {error:e}");
        // What rounding X to doubles leaves, raised by a cheap control.
        assert!(number(&found["residual"]) < 1e-13, "{id}: {found}");
        let gain = matrix(&found["F"]);
        let (a, b) = (matrix(&case["data"]["A"]), matrix(&case["data"]["B"]));
        let poles = muspin::linalg::eigenvalues(&(a - b * gain)).unwrap();
        let is_stable = |p: &muspin::linalg::c64| if kind == "dare" { p.norm() < 1.0 } else { p.re < 0.0 };
        assert!(poles.iter().all(is_stable), "{id}");
        assert_eq!(found["closed_loop_poles"]["re"].as_array().unwrap().len(), poles.len());
        // N is another name of the cross term.
        let mut renamed = case["data"].clone();
        let cross = renamed.as_object_mut().unwrap().remove("S").unwrap();
        renamed["N"] = cross;
        assert_eq!(answered(kind, &renamed), found, "{id}");
    }
}

#[test]
fn norms_of_both_times_are_those_of_slicot() {
    for case in peers("norms.json") {
        let problem = without(&case, &["h2", "hinf"]);
        let found = answered("h2norm", &problem);
        assert!((number(&found["norm"]) / number(&case["h2"]) - 1.0).abs() < 1e-9, "{found} {}", case["h2"]);
        assert!(number(&found["residual"]) < 1e-10, "{found}");
        let found = answered("hinfnorm", &problem);
        assert!((number(&found["norm"]) / number(&case["hinf"]) - 1.0).abs() < 1e-7, "{found} {}", case["hinf"]);
    }
}

#[test]
fn h2_controllers_reach_what_slicot_and_direct_minimisation_reach() {
    for case in peers("synthesis.json") {
        let problem = without(&case, &["h2", "gamma_feasible"]);
        let found = answered("h2syn", &problem);
        let (norm, optimum) = (number(&found["norm"]), number(&found["norm_opt"]));
        assert!((norm / optimum - 1.0).abs() < 1e-8, "{norm} {optimum}");
        if let Some(best) = case["h2"].as_f64() {
            // Nothing lies below the optimum, and the references end within 1e-6 of it.
            assert!(optimum <= best * (1.0 + 1e-8) && optimum >= best * (1.0 - 1e-6), "{optimum} {best}");
        }
        let stability = if number(&case["Ts"]) > 0.0 { "closed_loop_max_abs" } else { "closed_loop_max_real" };
        assert!(found.get(stability).is_some(), "{found}");
    }
}

#[test]
fn sampled_synthesis_is_at_least_as_good_as_that_of_slicot_and_certified_in_z() {
    for case in peers("synthesis.json").iter().filter(|case| number(&case["Ts"]) > 0.0) {
        let problem = without(case, &["h2", "gamma_feasible"]);
        let found = answered("hinfsyn", &problem);
        let (best, reached) = (number(&found["gamma_opt"]), number(&case["gamma_feasible"]));
        assert!(best <= reached * (1.0 + 1e-5), "{best} {reached}");
        // The loop in z, closed here, has the norm that the answer states.
        let k = &found["controller"];
        assert_eq!(k["Ts"], case["Ts"]);
        let norm = number(&answered("hinfnorm", &closed_loop(&problem, k))["norm"]);
        assert!((norm / number(&found["closed_loop_norm"]) - 1.0).abs() < 1e-6, "{norm} {found}");
        assert!(norm <= number(&found["gamma"]) * (1.0 + 1e-9), "{norm} {}", found["gamma"]);
        assert!(number(&found["gamma"]) <= best * 1.011, "{found}");
        assert!(number(&found["certificate"]["closed_loop_max_abs"]) < 1.0);
    }
}

/// The sampled loop of a plant with u = K y, for D22 = 0.
fn closed_loop(plant: &Value, k: &Value) -> Value {
    let size = |name: &str| plant[name].as_u64().unwrap() as usize;
    let (m1, m2, p1, p2) = (size("m1"), size("m2"), size("p1"), size("p2"));
    let [a, b, c, d] = ["A", "B", "C", "D"].map(|name| matrix(&plant[name]));
    let (n, dk) = (a.nrows(), matrix(&k["D"]));
    let (ak, bk, ck) = (matrix(&k["A"]), matrix(&k["B"]), matrix(&k["C"]));
    let (b1, b2) = (b.submatrix(0, 0, n, m1).to_owned(), b.submatrix(0, m1, n, m2).to_owned());
    let (c1, c2) = (c.submatrix(0, 0, p1, n).to_owned(), c.submatrix(p1, 0, p2, n).to_owned());
    let d11 = d.submatrix(0, 0, p1, m1).to_owned();
    let (d12, d21) = (d.submatrix(0, m1, p1, m2).to_owned(), d.submatrix(p1, 0, p2, m1).to_owned());
    let rows = |parts: [[muspin::linalg::Mat<f64>; 2]; 2]| -> Value {
        let line = |left: &muspin::linalg::Mat<f64>, right: &muspin::linalg::Mat<f64>, i: usize| -> Vec<f64> {
            (0..left.ncols()).map(|j| left[(i, j)]).chain((0..right.ncols()).map(|j| right[(i, j)])).collect()
        };
        let lines = parts.iter().flat_map(|[l, r]| (0..l.nrows()).map(|i| line(l, r, i)).collect::<Vec<_>>());
        json!(lines.collect::<Vec<Vec<f64>>>())
    };
    let none = |rows: usize| muspin::linalg::Mat::<f64>::zeros(rows, 0);
    let empty = |cols: usize| muspin::linalg::Mat::<f64>::zeros(0, cols);
    json!({
        "A": rows([[&a + &b2 * &dk * &c2, &b2 * &ck], [&bk * &c2, ak]]),
        "B": rows([[&b1 + &b2 * &dk * &d21, none(n)], [&bk * &d21, none(bk.nrows())]]),
        "C": rows([[&c1 + &d12 * &dk * &c2, &d12 * &ck], [empty(n), empty(ck.ncols())]]),
        "D": rows([[&d11 + &d12 * &dk * &d21, none(p1)], [empty(m1), empty(0)]]),
        "Ts": plant["Ts"],
    })
}
