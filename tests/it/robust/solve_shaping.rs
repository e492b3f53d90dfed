//! Loop shaping, disc margins, mixed sensitivity, LQG and weighted reduction: closed forms and identities.

use crate::robust::solve_cases::{number, refusal};
use crate::robust::solve_peers::answered;
use muspin::robust::disc_margin::DiscMargin;
use serde_json::{Value, json};

fn near(found: &Value, expected: f64, tolerance: f64) {
    let found = number(found);
    assert!((found / expected - 1.0).abs() < tolerance, "{found} for {expected}");
}

#[test]
fn the_margin_of_coprime_factors_has_its_closed_form() {
    // k/s: X = 1/k, Z = k, γ = √2 whatever k; 1/(s − 1): x² − 2x − 1 = 0, γ² = 1 + (1 + √2)².
    for k in [1e-3, 1.0, 1e4] {
        let found = answered("ncfsyn", &json!({"G": {"num": k, "den": [1, 0]}}));
        near(&found["gamma_opt"], std::f64::consts::SQRT_2, 1e-12);
        near(&found["margin"], 0.5f64.sqrt(), 1e-12);
        assert!(number(&found["closed_loop_norm"]) <= number(&found["gamma"]) * (1.0 + 1e-6), "{found}");
    }
    let unstable = json!({"A": 1, "B": 1, "C": 1, "D": 0});
    near(&answered("ncfsyn", &json!({"G": unstable}))["gamma_opt"], (4.0 + 8.0f64.sqrt()).sqrt(), 1e-12);
    // The bilinear map keeps the margin: z = (1 + s/2)/(1 − s/2) with T = 1.
    let image = &answered("discretise", &json!({"A": 1, "B": 1, "C": 1, "D": 0, "Ts": 1}))["tustin"];
    let found = answered("ncfsyn", &json!({"G": image, "Ts": 1}));
    near(&found["gamma_opt"], (4.0 + 8.0f64.sqrt()).sqrt(), 1e-11);
    assert_eq!(found["controller"]["Ts"], json!(1.0));
    // Weights are part of the plant, and of the controller.
    let shaped =
        answered("ncfsyn", &json!({"G": {"num": 1, "den": [1, 1]}, "W1": {"num": [1, 1], "den": [1, 0]}, "W2": 5}));
    near(&shaped["gamma_opt"], std::f64::consts::SQRT_2, 1e-9);
    let direct =
        json!({"A": [[-1, 2], [0, 0.5]], "B": [[1, 0], [1, 1]], "C": [[1, 1], [0, 2]], "D": [[0.5, 0.1], [-0.3, 2]]});
    let found = answered("ncfsyn", &json!({"G": direct}));
    assert!(number(&found["closed_loop_norm"]) <= number(&found["gamma"]) * (1.0 + 1e-6), "{found}");
    assert!(number(&found["gamma"]) <= number(&found["gamma_opt"]) * 1.0011, "{found}");
    let told = refusal("ncfsyn", r#"{"G": {"num": 1, "den": [1, 0]}, "gamma": 1.4}"#);
    assert!(told.contains("no controller achieves gamma"), "{told}");
}

/// f = (2 + 3δ)/(2 + δ), |δ| < 4: its pole −2 lies in the disc, so that factors reach −∞; δ = 4 gives the largest, 7/3.
#[test]
fn a_disc_with_a_pole_of_the_factor_has_no_least_factor() {
    let margin = DiscMargin { skew: -2.0, alpha: 4.0, alpha_upper: 4.0, omega_rad_s: 1.0 };
    let (least, largest) = margin.gain_margin();
    assert!(least == f64::NEG_INFINITY && (largest - 7.0 / 3.0).abs() < 1e-12, "{least} {largest}");
}

#[test]
fn disc_margins_of_an_integrator_and_of_two_channels() {
    // L = k/s: S = s/(s + k), T = k/(s + k), (S − T)/2 of modulus 1/2.
    let found = answered("diskmargin", &json!({"A": 0, "B": 3, "C": 1, "D": 0}));
    for (k, alpha) in [(0, 1.0), (1, 1.0), (2, 2.0)] {
        near(&found["channels"][0][k]["alpha"], alpha, 1e-6);
        near(&found["multiloop"][k]["alpha"], alpha, 1e-3);
    }
    // S: |f⁻¹ − 1| < 1, factors above 1/2, 60 degrees; T: |f − 1| < 1; S − T: all factors, 90 degrees.
    let sides: Vec<&Value> = found["channels"][0].as_array().unwrap().iter().collect();
    near(&sides[0]["gain_margin"][0], 0.5, 1e-6);
    near(&sides[0]["phase_margin_deg"], 60.0, 1e-6);
    near(&sides[1]["gain_margin"][1], 2.0, 1e-6);
    near(&sides[1]["phase_margin_deg"], 60.0, 1e-6);
    near(&sides[2]["phase_margin_deg"], 90.0, 1e-6);
    // Positive feedback of −L is the same loop, and so is the image of L in z.
    let other = answered("diskmargin", &json!({"A": 0, "B": -3, "C": 1, "D": 0, "sign": 1}));
    assert_eq!(found["channels"], other["channels"]);
    let image = answered("discretise", &json!({"A": 0, "B": 3, "C": 1, "D": 0, "Ts": 0.1}))["tustin"].clone();
    let sampled =
        answered("diskmargin", &json!({"A": image["A"], "B": image["B"], "C": image["C"], "D": image["D"], "Ts": 0.1}));
    near(&sampled["channels"][0][2]["alpha"], 2.0, 1e-8);
    // Spinning satellite (Doyle): each channel alone is perfect, both at once are fragile.
    let spin = json!({"A": [[0, 10], [-10, 0]], "B": [[1, 0], [0, 1]], "C": [[1, 10], [-10, 1]], "D": [[0, 0], [0, 0]], "skew": 0});
    let found = answered("diskmargin", &spin);
    near(&found["channels"][0][0]["alpha"], 2.0, 1e-6);
    let together = number(&found["multiloop"][0]["alpha"]);
    assert!(together < 0.2 && together <= number(&found["multiloop"][0]["alpha_upper"]) * (1.0 + 1e-9), "{found}");
    assert!(refusal("diskmargin", r#"{"A": 1, "B": 1, "C": 0.5, "D": 0}"#).contains("unstable"));
    assert!(refusal("diskmargin", r#"{"A": 0, "B": 1, "C": 1, "D": -1}"#).contains("not well posed"));
}

#[test]
fn mixed_sensitivity_takes_plants_and_weights_in_every_form() {
    let forms = [
        json!({"A": [[-1, 1], [0, -2]], "B": [0, 1], "C": [1, 0], "D": 0}),
        json!({"num": [0, 1], "den": [1, 3, 2]}),
        json!({"z": [], "p": [-1, -2], "k": 1}),
        json!({"A": [[-2, 2], [0, -4]], "B": [0, 2], "C": [1, 0], "D": 0, "E": [[2, 0], [0, 2]]}),
    ];
    let w1 = json!({"num": [0.5, 1], "den": [1, 0.01]});
    let mut levels = vec![];
    for plant in &forms {
        let problem = json!({"G": plant, "W1": w1, "W2": 0.1, "W3": {"z": [-1], "p": {"re": [-30, -30], "im": [5, -5]}, "k": 20}});
        let whole = answered("mixsyn", &problem);
        let posed = answered("augw", &problem);
        assert_eq!([&posed["m1"], &posed["m2"], &posed["p1"], &posed["p2"]], [1, 1, 3, 1]);
        near(&answered("hinfsyn", &posed)["gamma_opt"], number(&whole["gamma_opt"]), 1e-6);
        levels.push(number(&whole["gamma_opt"]));
    }
    assert!(levels.iter().all(|level| (level / levels[0] - 1.0).abs() < 1e-6), "{levels:?}");
    // A scalar weight stands in each channel.
    let two = json!({"A": [[-1, 0], [0, -2]], "B": [[1, 0], [0, 1]], "C": [[1, 1], [0, 1]], "D": [[0, 0], [0, 0]]});
    let found = answered("augw", &json!({"G": two, "W1": w1, "W2": [[1, 0], [0, 1]], "Ts": 0.1}));
    assert_eq!([&found["p1"], &found["m1"]], [4, 2]);
    assert_eq!((found["A"].as_array().unwrap().len(), &found["Ts"]), (4, &json!(0.1)));
    for (text, words) in [
        (r#"{"G": {"num": [1, 2, 3], "den": [1, 1]}, "W1": 1}"#, "G.num: has degree 2"),
        (r#"{"G": {"num": 1, "den": [0, 0]}, "W1": 1}"#, "G.den: is zero"),
        (r#"{"G": {"nom": 1, "den": [1, 1]}, "W1": 1}"#, "did you mean `num`"),
        (r#"{"G": {"num": 1, "k": 1}, "W1": 1}"#, "do not go together"),
        (r#"{"G": {"z": {"re": [1], "im": [1]}, "p": [1, 2], "k": 1}, "W1": 1}"#, "no conjugate"),
        (r#"{"G": {"num": 1, "den": [1, 1]}}"#, "at least one of W1, W2, W3"),
        (r#"{"G": {"num": 1, "den": [1, 1]}, "W1": [[1, 2]]}"#, "expected 1 inputs"),
        (r#"{"G": {"num": 1, "den": [1, 1]}, "W4": 1}"#, "did you mean `W"),
    ] {
        let told = refusal("mixsyn", text);
        assert!(told.contains(words), "{text}: {told}");
    }
}

#[test]
fn lqg_of_a_scalar_has_its_closed_form_in_both_times() {
    // Continuous: x = y = a + √(a² + 1), J = x w + f² y with f = x, w = 1.
    for a in [-2.0, 0.5, 3.0f64] {
        let found = answered("lqg", &json!({"A": a, "B": 1, "C": 1, "D": 0, "Q": 1, "R": 1, "W": 1, "V": 1}));
        let x = a + (a * a + 1.0).sqrt();
        near(&found["norm"], (x + x * x * x).sqrt(), 1e-10);
        near(&found["F"][0][0], x, 1e-12);
        // K = −f l/(s − a + f + l).
        near(&found["controller"]["A"][0][0], a - 2.0 * x, 1e-12);
        let gain = number(&found["controller"]["B"][0][0]) * number(&found["controller"]["C"][0][0]);
        assert!((gain / -(x * x) - 1.0).abs() < 1e-12, "{found}");
    }
    // Sampled, with the measurement of the same instant: x = y = (a² + √(a⁴ + 4))/2, J = x + (1 + x) f² y/(1 + y).
    for a in [0.3, 1.0, 2.0f64] {
        let problem = json!({"A": a, "B": 1, "C": 1, "D": 0.7, "Q": 1, "R": 1, "W": 1, "V": 1, "Ts": 0.01});
        let found = answered("lqg", &problem);
        let x = (a * a + (a.powi(4) + 4.0).sqrt()) / 2.0;
        let f = a * x / (1.0 + x);
        near(&found["norm"], (x + (1.0 + x) * f * f * x / (1.0 + x)).sqrt(), 1e-10);
        near(&found["norm_opt"], number(&found["norm"]), 1e-8);
    }
    let told = refusal("lqg", r#"{"A": 1, "B": 1, "C": 1, "D": 0, "Q": -1, "R": 1, "W": 1, "V": 1}"#);
    assert!(told.contains("negative eigenvalue"), "{told}");
    let told = refusal("lqg", r#"{"A": 1, "B": 1, "C": 0, "D": 0, "Q": 1, "R": 1, "W": 1, "V": 1}"#);
    assert!(told.contains("filter") && told.contains("not stabilisable"), "{told}");
    let told = refusal("lqg", r#"{"A": 1, "B": 1, "C": 1, "D": 0, "Q": 1, "R": 1, "W": 1, "V": 0}"#);
    assert!(told.contains("filter") && told.contains("R: singular"), "{told}");
}

#[test]
fn weights_move_the_error_of_a_reduction_out_of_their_band() {
    let plant = json!({"A": [[-0.1, 1, 0, 0], [-1, -0.1, 0, 0], [0, 0, -1, 10], [0, 0, -10, -1]],
        "B": [1, 0, 1, 0], "C": [1, 0, 1, 0], "D": 0, "orders": 2});
    let plain = answered("reduce", &plant);
    // Without a weight the mode at 1 rad/s, whose Hankel value is larger, stays; with one round 10 rad/s the other.
    let mut weighted = plant.clone();
    weighted["Wo"] = json!({"num": [0.5, 0], "den": [1, 0.5, 100]});
    let found = answered("reduce", &weighted);
    let mode = |answer: &Value| {
        let a = &answer["orders"]["2"]["A"];
        let entry = |i: usize, j: usize| number(&a[i][j]);
        (entry(0, 0) * entry(1, 1) - entry(0, 1) * entry(1, 0)).sqrt()
    };
    assert!((mode(&plain) - 1.0).abs() < 0.2 && mode(&found) > 5.0, "{} {}", mode(&plain), mode(&found));
    assert!(number(&found["orders"]["2"]["error_hinf"]) < 0.2, "{found}");
    weighted["Wo"] = json!({"num": 1, "den": [1, -1]});
    assert!(refusal("reduce", &weighted.to_string()).contains("not stable"));
}

#[test]
fn coprime_factors_reduce_unstable_poles_within_twice_the_cut_values() {
    let plant = json!({"A": [[0.5, 1, 0], [-1, 0.5, 0], [0, 0, -20]], "B": [1, 0, 1], "C": [1, 0, 0.5], "D": 0.1,
        "orders": [3, 2, 1], "coprime": true});
    let found = answered("reduce", &plant);
    let hankel: Vec<f64> = found["hsv"].as_array().unwrap().iter().map(number).collect();
    // ε² = 1 − ‖[N M]‖²: the margin of loop shaping by another road.
    let margin = number(
        &answered("ncfsyn", &json!({"G": {"A": plant["A"], "B": plant["B"], "C": plant["C"], "D": 0.1}}))["margin"],
    );
    assert!((margin * margin + hankel[0] * hankel[0] - 1.0).abs() < 1e-10, "{margin} {hankel:?}");
    for (order, cut) in [("3", 0.0), ("2", 2.0 * hankel[2]), ("1", 2.0 * (hankel[1] + hankel[2]))] {
        let error = number(&found["orders"][order]["error_factors"]);
        assert!(error <= cut * (1.0 + 1e-9) + 1e-12, "{order}: {error} {cut}");
    }
    // Two states keep the unstable pair.
    let a = &found["orders"]["2"]["A"];
    assert!((number(&a[0][0]) + number(&a[1][1]) - 1.0).abs() < 0.05, "{a}");
}
