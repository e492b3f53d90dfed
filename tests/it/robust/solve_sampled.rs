//! Sampled problems in every kind: closed forms, and the same problem posed in the w plane.

use crate::robust::solve_cases::{number, refusal};
use crate::robust::solve_keys::answer_to;
use crate::robust::solve_peers::answered;
use serde_json::{Value, json};

/// 1/(z − a).
fn lag(a: f64, more: &str) -> String {
    format!(r#"{{"A": {a}, "B": 1, "C": 1, "D": 0, "Ts": 0.5{more}}}"#)
}

#[test]
fn closed_forms_of_a_sampled_lag() {
    // Samples 1, a, a², …: energy 1/(1 − a²).
    for a in [0.0, 0.5, -0.9, 0.999] {
        let found = answer_to("h2norm", &lag(a, ""));
        assert!((number(&found["norm"]) * f64::sqrt(1.0 - a * a) - 1.0).abs() < 1e-11, "{a}: {found}");
    }
    // The lag at rest 1/(1 − a), at the Nyquist frequency 1/(1 + a): with a complex scalar μ is the gain.
    let block = r#", "blocks": {"type": "complex_scalar", "n": 1}"#;
    let found = answer_to("musys", &lag(-0.8, block));
    assert!((number(&found["peak_upper"]) / 5.0 - 1.0).abs() < 1e-3, "{found}");
    assert!((number(&found["peak_freq_rad_s"]) / (2.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3, "{found}");
    // One Hankel value of one state: 1/(1 − a²).
    let found = answer_to("reduce", &lag(0.5, r#", "orders": [0, 1]"#));
    assert!((number(&found["hsv"][0]) - 4.0 / 3.0).abs() < 1e-11, "{found}");
    let whole = &found["orders"]["1"];
    assert!((number(&whole["A"][0][0]) - 0.5).abs() < 1e-12 && whole["Ts"] == json!(0.5), "{found}");
    for (kind, problem) in [("h2norm", lag(1.01, "")), ("musys", lag(-1.0, block)), ("reduce", lag(-1.0, ""))] {
        let told = refusal(kind, &problem);
        assert!(told.contains("unstable") || told.contains("z = -1"), "{kind}: {told}");
    }
    let told = refusal("h2norm", r#"{"A": -1, "B": 1, "C": 1, "D": 1}"#);
    assert!(told.contains("infinite"), "{told}");
}

#[test]
fn the_loop_of_a_sampled_regulator_has_the_poles_of_its_two_equations() {
    // Cost x² + r u² and noises of one on x and of v on y: u = −f x̂ and its observer leave a r/(r + x) and a v/(v + y),
    // x and y the positive roots of x² + (r − ra² − 1) x − r = 0 and of the same with v. Slow, fast and unstable plants.
    for (a, r, v) in [(0.999, 1e8, 1e6), (1.2, 1.0, 2.0), (3.0, 0.1, 0.01), (0.5, 1.0, 4.0)] {
        let pole = |r: f64| {
            let p: f64 = r - r * a * a - 1.0;
            a * r / (r + 0.5 * ((p * p + 4.0 * r).sqrt() - p))
        };
        let problem = json!({"A": a, "B": 1, "C": 1, "D": 0, "Q": 1, "R": r, "W": 1, "V": v, "Ts": 1e-3});
        let found = answered("lqg", &problem);
        let (stated, exact) = (number(&found["closed_loop_max_abs"]), pole(r).max(pole(v)));
        assert!((stated / exact - 1.0).abs() < 1e-9, "{a} {r} {v}: {stated} {exact}");
    }
}

#[test]
fn scalar_equations_of_sampled_time_have_their_closed_form() {
    // x = a²x − a²x²b²/(r + b²x) + q.
    for (a, b, q, r) in [(1.2, 1.0, 1.0, 1.0), (0.5, 2.0, 1e-6, 1e3), (3.0, 1e-2, 5.0, 1e-4), (0.0, 1.0, 2.0, 1.0)] {
        let found = answered("dare", &json!({"A": a, "B": b, "Q": q, "R": r}));
        let (b2, p): (f64, f64) = (b * b, r - r * a * a - q * b * b);
        // b²x² + (r − ra² − qb²)x − qr = 0, the root without cancellation.
        let root = (p * p + 4.0 * b2 * q * r).sqrt();
        let x = if p > 0.0 { 2.0 * q * r / (p + root) } else { (root - p) / (2.0 * b2) };
        assert!((number(&found["X"][0][0]) / x - 1.0).abs() < 1e-14, "{a} {b}: {found} {x}");
    }
    // R = 0: one step to rest.
    let found = answered("dare", &json!({"A": [[1, 1], [0, 1]], "B": [0, 1], "Q": [[1, 0], [0, 1]], "R": 0}));
    assert!(number(&found["residual"]) < 1e-14 && number(&found["closed_loop_max_abs"]) < 1.0, "{found}");
    let told = refusal("dare", r#"{"A": [[2, 0], [0, 0.5]], "B": [0, 1], "Q": [[1, 0], [0, 1]], "R": 1}"#);
    assert!(told.contains("not stabilisable") && told.contains("z = 2.0"), "{told}");
    let told = refusal("dare", r#"{"A": [[0, 1], [-1, 0]], "B": [0, 1], "Q": [[0, 0], [0, 0]], "R": 1}"#);
    assert!(told.contains("unit circle") && told.contains("not detectable"), "{told}");
    for (kind, key) in [("dare", "Q"), ("dare", "R"), ("care", "Q"), ("care", "R")] {
        let mut problem =
            json!({"A": [[0, 1], [1, 0]], "B": [[1, 0], [0, 1]], "Q": [[1, 0], [0, 1]], "R": [[1, 0], [0, 1]]});
        problem[key] = json!([[1, 0.5], [0, 1]]);
        let told = refusal(kind, &problem.to_string());
        assert!(told.contains(&format!("{key} is not symmetric")), "{told}");
    }
    assert!(refusal("care", r#"{"A": 1, "B": 1, "Q": 1, "R": 0}"#).contains("R: singular"));
    assert!(refusal("care", r#"{"A": 1, "B": 1, "G": 1, "Q": 1}"#).contains("beside G"));
    assert!(refusal("care", r#"{"A": 1, "B": 1, "Q": 1, "S": 0, "N": 0}"#).contains("another name"));
}

#[test]
fn a_descriptor_with_an_inverse_counts_and_a_singular_one_is_refused() {
    // E x' = A x + B u with E = diag(2, 1e-6): the same as the rows divided.
    let given = r#""B": [[2], [1e-6]], "C": [[1, 1]], "D": 0"#;
    let found = answer_to("hinfnorm", &format!(r#"{{"E": [[2, 0], [0, 1e-6]], "A": [[-2, 0], [0, -2e-6]], {given}}}"#));
    let plain = answer_to("hinfnorm", r#"{"A": [[-1, 0], [0, -2]], "B": [1, 1], "C": [1, 1], "D": 0}"#);
    assert!((number(&found["norm"]) / number(&plain["norm"]) - 1.0).abs() < 1e-12, "{found}");
    assert!(number(&found["descriptor_rcond"]) > 0.9 && plain.get("descriptor_rcond").is_none());
    for e in ["[[1, 1], [1, 1]]", "[[1, 0], [0, 0]]", "[[1, 1], [1, 1.0000000001]]"] {
        let told = refusal("hinfnorm", &format!(r#"{{"E": {e}, "A": [[-2, 0], [0, -1]], {given}}}"#));
        assert!(told.contains("E: is singular") && told.contains("descriptor"), "{told}");
    }
    // X of the equation with E: A'XE + E'XA − E'XBB'XE + Q = 0, here 2·a·e·x − e²x² + q = 0.
    let found = answered("care", &json!({"A": 1, "B": 1, "Q": 3, "R": 1, "E": 2}));
    assert!((number(&found["X"][0][0]) - 1.5).abs() < 1e-13, "{found}");
    let found = answered("dare", &json!({"A": 1, "B": 1, "Q": 3, "R": 1, "E": 2}));
    let x = number(&found["X"][0][0]);
    assert!((x - 4.0 * x - x * x / (1.0 + x) + 3.0).abs() < 1e-13, "{found}");
}

/// A plant of two masses in continuous time, u and w on the first, with its image z = (1 + sT/2)/(1 − sT/2).
fn both_times(period: f64) -> [Value; 2] {
    let a = json!([[0, 1, 0, 0], [-2, -0.02, 1, 0.01], [0, 0, 0, 1], [1, 0.01, -1, -0.01]]);
    let b = json!([[0, 0, 0], [1, 0, 1], [0, 0, 0], [0.3, 0, 0]]);
    let c = json!([[0, 0, 1, 0], [0, 0, 0, 0], [1, 0, 0, 0]]);
    let d = json!([[0, 0, 0], [0, 0, 0.5], [0, 0.1, 0]]);
    let sampled = answered("discretise", &json!({"A": a, "B": b, "C": c, "D": d, "Ts": period}));
    let image = &sampled["tustin"];
    [
        json!({"A": a, "B": b, "C": c, "D": d, "m1": 2, "m2": 1, "p1": 2, "p2": 1}),
        json!({"A": image["A"], "B": image["B"], "C": image["C"], "D": image["D"], "Ts": period,
            "m1": 2, "m2": 1, "p1": 2, "p2": 1}),
    ]
}

#[test]
fn levels_are_those_of_the_image_in_the_w_plane() {
    for period in [1e-4, 0.3] {
        let [continuous, sampled] = both_times(period);
        let (one, other) = (answered("hinfsyn", &continuous), answered("hinfsyn", &sampled));
        let ratio = number(&other["gamma_opt"]) / number(&one["gamma_opt"]);
        assert!((ratio - 1.0).abs() < 1e-6, "{period}: {ratio}");
        assert!(number(&other["closed_loop_norm"]) <= number(&other["gamma"]) * (1.0 + 1e-9));
    }
    // Without noise the plant is singular in either time.
    let [_, mut singular] = both_times(0.3);
    for row in 0..3 {
        singular["D"][row][1] = json!(0);
        singular["B"][row][1] = json!(0);
    }
    singular["B"][3][1] = json!(0);
    let found = answered("hinfsyn", &singular);
    assert!(found["regularisation"]["reason"].as_str().unwrap().contains("D21"), "{found}");
    assert!(number(&found["closed_loop_norm"]) <= number(&found["gamma"]) * 1.01, "{found}");
}

#[test]
fn the_iteration_of_d_and_k_takes_sampled_and_singular_plants() {
    let blocks =
        json!([{"type": "complex_full", "rows": 1, "cols": 1}, {"type": "complex_full", "rows": 1, "cols": 1}]);
    let [mut continuous, mut sampled] = both_times(0.3);
    for plant in [&mut continuous, &mut sampled] {
        plant["blocks"] = blocks.clone();
        plant["max_d_order"] = json!(1);
    }
    let (one, other) = (answered("dksyn", &continuous), answered("dksyn", &sampled));
    let (a, b) = (number(&one["mu_peak"]), number(&other["mu_peak"]));
    assert!((a / b - 1.0).abs() < 1e-2, "{a} {b}");
    assert!(number(&other["mu_lower_peak"]) <= b && other["controller"]["Ts"] == json!(0.3), "{other}");
    // Without noise D21 has no rank.
    continuous["D"][2][1] = json!(0);
    let found = answered("dksyn", &continuous);
    assert!(found["regularisation"]["reason"].as_str().unwrap().contains("D21"), "{found}");
    assert!(number(&found["mu_peak"]) <= number(&found["regularisation"]["perturbed_norm"]) * (1.0 + 1e-3), "{found}");
}

#[test]
fn magnitudes_on_the_unit_circle_are_fitted_in_z() {
    // |1/(z − 0.5)| at the frequencies given.
    let omega: Vec<f64> = (1..40).map(|k| 0.15 * f64::from(k)).collect();
    let gain = |w: &f64| (1.25 - (0.5 * w).cos()).sqrt().recip();
    let magnitude: Vec<f64> = omega.iter().map(gain).collect();
    let problem = json!({"omega": omega, "magnitude": magnitude, "orders": 1, "Ts": 0.5});
    let found = &answered("dfit", &problem)["orders"]["1"];
    assert!(number(&found["max_abs_ln_error"]) < 1e-5 && (number(&found["A"][0][0]) - 0.5).abs() < 1e-4, "{found}");
    let told = refusal("dfit", r#"{"omega": [1, 7], "magnitude": [1, 1], "orders": 0, "Ts": 0.5}"#);
    assert!(told.contains("omega[1]") && told.contains("Nyquist"), "{told}");
}
