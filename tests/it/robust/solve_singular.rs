//! Singular H∞ problems: the level against closed forms, the norm of the plant as given, what the answer states.

use crate::robust::solve_cases::{matrix, number};
use crate::robust::solve_keys::answer_to;
use muspin::lti::connect::lower_lft;
use muspin::lti::norm::hinf_norm;
use muspin::lti::{Continuous, StateSpace};
use serde_json::{Value, json};

fn system(value: &Value) -> StateSpace<Continuous> {
    let part = |name: &str| matrix(&value[name]);
    StateSpace::new(part("A"), part("B"), part("C"), part("D"), Continuous).unwrap()
}

/// The answer to a plant whose infimum is known, after the checks that hold for every singular plant.
fn solved(plant: &Value, infimum: f64, reason: &str) -> Value {
    let found = answer_to("hinfsyn", &plant.to_string());
    let told = &found["regularisation"];
    assert!(told["reason"].as_str().unwrap().contains(reason), "{told}");
    assert!(told["settled"].as_bool().unwrap() && number(&told["share"]) <= 1e-2, "{told}");
    assert!(number(&told["gamma_change"]) <= 1e-3, "{told}");
    let opt = number(&found["gamma_opt"]);
    assert!(opt >= infimum * (1.0 - 1e-6) && opt <= infimum * 1.002, "{opt} {infimum}");
    // The norm is that of the plant as given, below the level.
    let closed = lower_lft(&system(plant), &system(&found["controller"])).unwrap();
    let norm = hinf_norm(&closed, 1e-9).unwrap().norm;
    assert!((number(&found["closed_loop_norm"]) / norm - 1.0).abs() < 1e-6, "{found}");
    assert!(norm <= number(&found["gamma"]) * (1.0 + 1e-8), "{norm}");
    assert!(norm <= number(&told["perturbed_norm"]) * (1.0 + 1e-8), "{norm} {told}");
    found
}

/// ẋ = x + w + s u, z = x/e, y = x + n/10: a high gain makes x = −n/10, and nothing goes below.
fn free_control(unit: f64, error_unit: f64) -> Value {
    json!({
        "A": [[1.0]], "B": [[1.0, 0.0, unit]], "C": [[1.0 / error_unit], [1.0]],
        "D": [[0.0, 0.0, 0.0], [0.0, 0.1, 0.0]], "m1": 2, "m2": 1, "p1": 1, "p2": 1,
    })
}

#[test]
fn a_control_without_cost_comes_close_to_the_infimum_in_any_units() {
    let plain = solved(&free_control(1.0, 1.0), 0.1, "D12");
    let added = |found: &Value| number(&found["regularisation"]["controls"][0]);
    for (unit, error_unit) in [(1e-4, 1.0), (1e3, 1e5)] {
        let found = solved(&free_control(unit, error_unit), 0.1 / error_unit, "D12");
        let levels = number(&found["gamma_opt"]) * error_unit / number(&plain["gamma_opt"]);
        assert!((levels - 1.0).abs() < 1e-6, "{unit}: {levels}");
        let sizes = added(&found) * error_unit / unit / added(&plain);
        assert!((sizes - 1.0).abs() < 1e-6, "{unit}: {sizes}");
    }
    // The dual: measurements without noise.
    let dual = json!({
        "A": [[1.0]], "B": [[1.0, 1.0]], "C": [[1.0], [0.0], [1.0]],
        "D": [[0.0, 0.0], [0.0, 0.1], [0.0, 0.0]], "m1": 1, "m2": 1, "p1": 2, "p2": 1,
    });
    let found = solved(&dual, 0.1, "D21");
    assert!(found["regularisation"].get("controls").is_none(), "{found}");
}

#[test]
fn an_undamped_mode_that_no_error_sees_is_no_obstacle() {
    // The first state as the integrator of [`optimum_of_an_integrator_is_root_two`]; beside it an oscillator that its
    // own control and measurement damp, and that no error and no disturbance knows of.
    let plant = json!({
        "A": [[0, 0, 0], [0, 0, 5], [0, -5, 0]],
        "B": [[1, 0, 0, 1, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 1]],
        "C": [[1, 0, 0], [0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 0, 1]],
        "D": [[0, 0, 0, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 1], [0, 1, 0, 0, 0], [0, 0, 1, 0, 0]],
        "m1": 3, "m2": 2, "p1": 3, "p2": 2,
    });
    let found = solved(&plant, f64::sqrt(2.0), "zero on the imaginary axis");
    let told = &found["regularisation"];
    assert_eq!(told["state_errors"].as_array().unwrap().len(), 3, "{told}");
    assert!(told.get("controls").is_none() && told.get("measurements").is_none(), "{told}");
}

#[test]
fn an_infimum_of_zero_is_said_not_to_have_settled() {
    // ẋ = −x + w + u, z = x, y = x: a high gain brings z down without end.
    let plant = json!({
        "A": -1, "B": [1, 1], "C": [1, 1], "D": [[0, 0], [0, 0]], "m1": 1, "m2": 1, "p1": 1, "p2": 1,
    });
    let found = answer_to("hinfsyn", &plant.to_string());
    let told = &found["regularisation"];
    assert_eq!(told["settled"], json!(false), "{told}");
    assert!(number(&found["gamma"]) < 1e-3 && number(&told["gamma_change"]) > 0.1, "{found}");
    // A level that is asked for is given with the first channels that reach it.
    let mut asked = plant;
    asked["gamma"] = json!(0.3);
    let found = answer_to("hinfsyn", &asked.to_string());
    assert!(number(&found["closed_loop_norm"]) <= 0.3 && found.get("gamma_opt").is_none(), "{found}");
    assert!(number(&found["regularisation"]["share"]) >= 1e-4, "{found}");
}

#[test]
fn a_regular_plant_has_no_regularisation() {
    let plant = json!({
        "A": 0, "B": [1, 0, 1], "C": [1, 0, 1], "D": [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
        "m1": 2, "m2": 1, "p1": 2, "p2": 1,
    });
    assert!(answer_to("hinfsyn", &plant.to_string()).get("regularisation").is_none());
}
