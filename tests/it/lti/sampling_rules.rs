//! Rules of sampling beside hold and Tustin, delays of inputs, and reduction to a tolerance: SciPy and closed forms.

use crate::robust::solve_cases::{answer, matrix, number, refusal};
use muspin::linalg::{Mat, c64};
use muspin::lti::matched::match_roots;
use muspin::lti::sample::zoh_with_delay;
use muspin::lti::{Continuous, Discrete, StateSpace};
use serde_json::Value;

fn solved(kind: &str, problem: &str) -> Value {
    let mut file = tempfile::Builder::new().suffix(".json").tempfile().unwrap();
    std::io::Write::write_all(&mut file, problem.as_bytes()).unwrap();
    answer(kind, file.path())
}

fn sampled(found: &Value, rule: &str, period_s: f64) -> StateSpace<Discrete> {
    let m = |name: &str| matrix(&found[rule][name]);
    StateSpace::new(m("A"), m("B"), m("C"), m("D"), Discrete { period_s }).unwrap()
}

fn is_near(found: &Mat<f64>, exact: &[&[f64]]) {
    for (i, row) in exact.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            assert!((found[(i, j)] - value).abs() < 1e-13, "{i} {j}: {} {value}", found[(i, j)]);
        }
    }
}

/// scipy.signal.cont2discrete, SciPy 1.11 and later, method 'foh' and 'impulse', dt = 0.1.
#[test]
fn first_order_hold_and_impulse_invariance_are_those_of_scipy() {
    let found = |d: f64| {
        solved(
            "discretise",
            &format!(r#"{{"A": [[0, 1], [-4, -0.8]], "B": [[0], [1]], "C": [[3, 0.5]], "D": [[{d}]], "Ts": 0.1}}"#),
        )
    };
    let with_feedthrough = found(2.0);
    let foh = sampled(&with_feedthrough, "foh", 0.1);
    is_near(&foh.a, &[&[0.9805873246013307, 0.09546521821339093], &[-0.38186087285356374, 0.9042151500306179]]);
    is_near(&foh.b, &[&[0.009454602448265534], &[0.09019394896996821]]);
    is_near(&foh.c, &[&[3.0, 0.5]]);
    is_near(&foh.d, &[&[2.029157694549901]]);
    assert!(with_feedthrough.get("impulse").is_none());
    let notes = with_feedthrough["notes"].to_string();
    assert!(notes.contains("impulse") && notes.contains("feedthrough"), "{notes}");
    let impulse = sampled(&found(0.0), "impulse", 0.1);
    is_near(&impulse.a, &[&[0.9805873246013307, 0.09546521821339093], &[-0.3818608728535637, 0.9042151500306179]]);
    is_near(&impulse.b, &[&[0.009546521821339094], &[0.0904215150030618]]);
    is_near(&impulse.c, &[&[3.0, 0.5]]);
    is_near(&impulse.d, &[&[0.05]]);
}

#[test]
fn matched_roots_are_their_images_and_keep_the_gain_at_low_frequency() {
    let (t, e) = (0.2, |s: f64| (0.2 * s).exp());
    let system = |a: &[f64], b: &[f64], c: &[f64]| {
        let n = b.len();
        let row = |v: &[f64], i: usize, j: usize| v[i * n + j];
        let a = Mat::from_fn(n, n, |i, j| row(a, i, j));
        let b = Mat::from_fn(n, 1, |i, _| b[i]);
        let c = Mat::from_fn(1, n, |_, j| c[j]);
        match_roots(&StateSpace::new(a, b, c, Mat::zeros(1, 1), Continuous).unwrap(), t).unwrap()
    };
    type Exact<'a> = &'a dyn Fn(c64) -> c64;
    // 1/(s + 1): nothing else than the hold.
    let lag: Exact = &|z| c64::new(1.0 - e(-1.0), 0.0) / (z - e(-1.0));
    // (s + 2)/((s + 1)(s + 3)), 2/3 at rest.
    let gain = 2.0 / 3.0 * (1.0 - e(-1.0)) * (1.0 - e(-3.0)) / (1.0 - e(-2.0));
    let lead: Exact = &|z| gain * (z - e(-2.0)) / ((z - e(-1.0)) * (z - e(-3.0)));
    // 1/(s (s + 1)): one of two zeros at infinity goes to −1; s G → 1.
    let half = 0.5 * t * (1.0 - e(-1.0));
    let integrator: Exact = &|z| half * (z + 1.0) / ((z - 1.0) * (z - e(-1.0)));
    // s/(s² + 2s + 5), poles −1 ± 2j; G/s → 1/5.
    let pole = c64::new(-t, 2.0 * t).exp();
    let pair = |z: c64| (z - pole) * (z - pole.conj());
    let slope = pair(c64::new(1.0, 0.0)).re / (5.0 * t);
    let washout: Exact = &|z| slope * (z - 1.0) / pair(z);
    let cases = [
        (system(&[-1.0], &[1.0], &[1.0]), lag),
        (system(&[-4.0, -3.0, 1.0, 0.0], &[1.0, 0.0], &[1.0, 2.0]), lead),
        (system(&[-1.0, 0.0, 1.0, 0.0], &[1.0, 0.0], &[0.0, 1.0]), integrator),
        (system(&[-2.0, -5.0, 1.0, 0.0], &[1.0, 0.0], &[1.0, 0.0]), washout),
    ];
    for (k, (found, exact)) in cases.iter().enumerate() {
        for z in [c64::new(0.3, 0.9), c64::new(-0.5, 0.2), c64::new(1.001, 0.0)] {
            let (found, exact) = (found.transfer(z)[(0, 0)], exact(z));
            assert!((found - exact).norm() < 1e-11 * exact.norm(), "{k} {z}: {found} {exact}");
        }
    }
}

#[test]
fn delayed_inputs_are_late_by_whole_samples_or_by_a_split_hold() {
    let problem = |delay: f64| {
        format!(r#"{{"A": [[-2]], "B": [[1]], "C": [[3]], "D": [[0.5]], "Ts": 0.1, "input_delay_s": {delay}}}"#)
    };
    let (now, late) = (solved("discretise", &problem(0.0)), solved("discretise", &problem(0.2)));
    let z = c64::new(0.6, 0.7);
    for rule in ["zoh", "foh", "tustin", "matched"] {
        let [now, late] = [&now, &late].map(|found| sampled(found, rule, 0.1).transfer(z)[(0, 0)]);
        assert!((late * z * z - now).norm() < 1e-13 * now.norm(), "{rule}: {late} {now}");
    }
    // A quarter of a sample: u(k − 1) acts for the first quarter of the sample, u(k) for the rest.
    let part = |from: f64, to: f64| 0.5 * ((-2.0 * from).exp() - (-2.0 * to).exp());
    let a = (-0.2f64).exp();
    let exact = (z.inv() * part(0.075, 0.1) + part(0.0, 0.075)) / (z - a) * 3.0 + z.inv() * 0.5;
    let quarter = solved("discretise", &problem(0.025));
    let found = sampled(&quarter, "zoh", 0.1).transfer(z)[(0, 0)];
    assert!((found - exact).norm() < 1e-13, "{found} {exact}");
    assert!(quarter.get("tustin").is_none() && quarter["notes"].to_string().contains("0.25"));
    let text = refusal("discretise", &problem(-1.0));
    assert!(text.contains("input_delay_s"), "{text}");
    // In coordinates of another size the same.
    let stiff = Mat::from_fn(2, 2, |i, j| [[-3e6, -2e12], [1.0, 0.0]][i][j]);
    let column = |first: f64, second: f64| Mat::from_fn(2, 1, |i, _| [first, second][i]);
    let row = Mat::from_fn(1, 2, |_, j| [0.0, 2e12][j]);
    let system = StateSpace::new(stiff, column(1.0, 0.0), row, Mat::zeros(1, 1), Continuous).unwrap();
    let late = zoh_with_delay(&system, 1e-6, 1.5e-6).unwrap();
    let gain = late.transfer(c64::new(1.0, 0.0))[(0, 0)];
    assert!((gain - c64::new(1.0, 0.0)).norm() < 1e-12, "{gain}");
}

#[test]
fn reduction_keeps_the_dc_gain_and_meets_a_tolerance() {
    // Lags whose parts of the DC gain fall from 1 to 1e-3.
    let problem = |more: &str| {
        format!(
            r#"{{"A": [[-1,0,0,0],[0,-3,0,0],[0,0,-9,0],[0,0,0,-27]], "B": [[1],[1],[1],[1]],
                "C": [[1,0.3,0.09,0.027]], "D": [[0]], {more}}}"#
        )
    };
    let dc = 1.0 + 0.1 + 0.01 + 0.001;
    let found = solved("reduce", &problem(r#""orders": [1, 2], "match_dc": true"#));
    for order in ["1", "2"] {
        let r = &found["orders"][order];
        assert_eq!(r["method"], "singular_perturbation");
        let m = |name: &str| matrix(&r[name]);
        let s = StateSpace::new(m("A"), m("B"), m("C"), m("D"), Continuous).unwrap();
        let gain = s.transfer(c64::new(0.0, 0.0))[(0, 0)].re;
        assert!((gain / dc - 1.0).abs() < 1e-12, "{order}: {gain}");
    }
    let errors: Vec<f64> = {
        let all = solved("reduce", &problem(r#""orders": [0, 1, 2, 3]"#));
        (0..4).map(|k| number(&all["orders"][k.to_string()]["error_hinf"])).collect()
    };
    for (order, error) in errors.iter().enumerate().skip(1) {
        // Just at the error of an order that order serves, and no smaller one does.
        let found = solved("reduce", &problem(&format!(r#""max_error": {:e}"#, error * 1.000_001)));
        assert_eq!(found["order_within_max_error"], order, "{errors:?}");
        assert!(number(&found["orders"][order.to_string()]["error_hinf"]) <= error * 1.000_001);
        assert!(errors[order - 1] > *error);
    }
    let text = refusal("reduce", &problem(r#""max_error": 0"#));
    assert!(text.contains("max_error: must be positive"), "{text}");
    let text = refusal("reduce", &problem(r#""orders": [1], "match_dc": 1"#));
    assert!(text.contains("true or false"), "{text}");
}
