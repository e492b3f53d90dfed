//! Reduction: Hankel values and errors against the references, bounds, weighted reduction, unstable parts.

use crate::robust::solve_cases::{answer, cases, matrix, number, refusal};
use muspin::linalg::Mat;
use muspin::lti::balance::{
    Balancing, balanced_truncation, frequency_weighted_balance, hankel_values, singular_perturbation, split,
};
use muspin::lti::connect::{add, series};
use muspin::lti::norm::{hinf_norm, linf_norm};
use muspin::lti::{Continuous, StateSpace};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn system(v: &serde_json::Value) -> StateSpace<Continuous> {
    let m = |name: &str| matrix(&v[name]);
    StateSpace::new(m("A"), m("B"), m("C"), m("D"), Continuous).unwrap()
}

fn difference(x: &StateSpace<Continuous>, y: &StateSpace<Continuous>) -> StateSpace<Continuous> {
    let p = y.outputs();
    let minus = Mat::from_fn(p, p, |i, j| if i == j { -1.0 } else { 0.0 });
    add(x, &y.scale_outputs(&minus)).unwrap()
}

#[test]
fn hankel_values_and_errors_match_the_references() {
    for case in cases("modred", 3) {
        let found = answer("reduce", &case.path);
        let reference = &case.json["reference"];
        let exact = reference.get("hsv").unwrap_or(&reference["hsv_stable_part"]);
        let (first, list) = (number(&exact[0]), exact.as_array().unwrap());
        for (k, value) in list.iter().enumerate() {
            let (h, e) = (number(&found["hsv"][k]), number(value));
            if e > 1e-12 * first {
                assert!((h / e - 1.0).abs() < 1e-8, "{} {k}: {h} {e}", case.name);
            }
        }
        let full = system(&case.json["data"]);
        for (order, errors) in reference["orders"].as_object().unwrap() {
            let best = errors
                .as_object()
                .unwrap()
                .iter()
                .filter(|(name, _)| name.ends_with("error_hinf"))
                .map(|(_, v)| number(v))
                .fold(f64::INFINITY, f64::min);
            let answer = &found["orders"][order];
            let error = number(&answer["error_hinf"]);
            assert!(error <= best * 1.001, "{} {order}: {error} {best}", case.name);
            let reduced = system(answer);
            assert_eq!(reduced.order().to_string(), *order);
            // The claimed error is that of the matrices in the file.
            let measured = linf_norm(&difference(&full, &reduced), 1e-9).unwrap().norm;
            assert!((measured / error - 1.0).abs() < 1e-6, "{} {order}", case.name);
            let unstable = |s: &StateSpace<Continuous>| s.poles().unwrap().iter().filter(|p| p.re >= 0.0).count();
            assert_eq!(unstable(&reduced), unstable(&full), "{}", case.name);
        }
    }
}

fn random_stable(rng: &mut ChaCha8Rng, n: usize) -> StateSpace<Continuous> {
    let mut r = |p, q| Mat::from_fn(p, q, |_, _| rng.random_range(-1.0..1.0));
    let mut a: Mat<f64> = r(n, n);
    for i in 0..n {
        a[(i, i)] -= 3.0;
    }
    StateSpace::new(a, r(n, 2), r(2, n), r(2, 2), Continuous).unwrap()
}

#[test]
fn errors_lie_between_the_hankel_bounds() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..8 {
        let s = random_stable(&mut rng, 9);
        let hankel = hankel_values(&s).unwrap();
        for r in 1..8 {
            let tail: f64 = 2.0 * hankel[r..].iter().sum::<f64>();
            for reduced in [balanced_truncation(&s, r).unwrap(), singular_perturbation(&s, r).unwrap()] {
                assert!(reduced.growth_rate().unwrap() < 0.0);
                let error = hinf_norm(&difference(&s, &reduced), 1e-9).unwrap().norm;
                assert!(error <= tail * (1.0 + 1e-7) && error >= hankel[r] * (1.0 - 1e-7));
            }
        }
    }
}

#[test]
fn hankel_value_of_a_first_order_lag_is_half_its_gain() {
    let m = |x: f64| Mat::from_fn(1, 1, |_, _| x);
    let lag = StateSpace::new(m(-4.0), m(3.0), m(8.0), m(1.0), Continuous).unwrap();
    let hankel = hankel_values(&lag).unwrap();
    // bc/(2|a|) = 24/8.
    assert!((hankel[0] - 3.0).abs() < 1e-15 * 3.0);
}

#[test]
fn tiny_hankel_values_keep_their_digits() {
    // A cascade of lags: values fall by seven decades; compared with a system whose gain is scaled, which scales all
    // of them, and with its own balanced truncation, which keeps the leading ones.
    let n = 8;
    let a = Mat::from_fn(n, n, |i, j| match (i, j) {
        (i, j) if i == j => -1.0,
        (i, j) if i == j + 1 => 1.0,
        _ => 0.0,
    });
    let b = Mat::from_fn(n, 1, |i, _| f64::from(u8::from(i == 0)));
    let c = Mat::from_fn(1, n, |_, j| f64::from(u8::from(j == n - 1)));
    let s = StateSpace::new(a, b, c, Mat::zeros(1, 1), Continuous).unwrap();
    let hankel = hankel_values(&s).unwrap();
    // States in other units: a different rounding of every step, the same values.
    let scale: Vec<f64> = (0..n).map(|i| 3f64.powi(5 * i as i32 - 17)).collect();
    let scaled = hankel_values(&s.scale_states(&scale)).unwrap();
    for (x, y) in hankel.iter().zip(&scaled) {
        assert!((x / y - 1.0).abs() < 1e-9, "{x:e} {y:e}");
    }
    // Symmetric impulse response h(t) = t⁷e⁻ᵗ/7!: the trace of the cross gramian is half the DC gain,
    // so the signed sum of the values is 1/2.
    let signed: f64 = hankel.iter().enumerate().map(|(k, h)| if k % 2 == 0 { *h } else { -*h }).sum();
    assert!((signed - 0.5).abs() < 1e-12, "{signed}");
}

#[test]
fn split_keeps_the_transfer_matrix() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut s = random_stable(&mut rng, 7);
    for i in 0..7 {
        s.a[(i, i)] += 3.2;
    }
    let (stable, kept) = split(&s).unwrap();
    assert!(kept.order() > 0 && stable.growth_rate().unwrap() < 0.0);
    let error = linf_norm(&difference(&s, &add(&stable, &kept).unwrap()), 1e-6).unwrap();
    assert!(error.norm < 1e-10 * linf_norm(&s, 1e-6).unwrap().norm);
}

#[test]
fn weighted_reduction_is_better_where_the_weight_is_large() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let s = random_stable(&mut rng, 10);
    let eye = |x: f64| Mat::from_fn(2, 2, |i, j| if i == j { x } else { 0.0 });
    // Band-pass weight: low gain everywhere but near 20 rad/s.
    let (w, z) = (20.0, 0.02);
    let block = |i: usize, j: usize| match (i % 2, j % 2) {
        (0, 1) => w,
        (1, 0) => -w,
        (1, 1) => -2.0 * z * w,
        _ => 0.0,
    };
    let weight = StateSpace::new(
        Mat::from_fn(4, 4, |i, j| if i / 2 == j / 2 { block(i, j) } else { 0.0 }),
        Mat::from_fn(4, 2, |i, j| if i == 2 * j + 1 { 1.0 } else { 0.0 }),
        Mat::from_fn(2, 4, |i, j| if j == 2 * i { 1.0 } else { 0.0 }),
        eye(1e-3),
        Continuous,
    )
    .unwrap();
    let weighted = frequency_weighted_balance(&s, Some(&weight), Some(&weight)).unwrap();
    let plain = Balancing::new(&s).unwrap();
    let error = |reduced: &StateSpace<Continuous>| {
        let e = difference(&s, reduced);
        let e = series(&series(&weight, &e).unwrap(), &weight).unwrap();
        hinf_norm(&e, 1e-8).unwrap().norm
    };
    for r in [2, 4] {
        let (x, y) = (weighted.truncate_states(r).unwrap(), plain.truncate_states(r).unwrap());
        assert!(error(&x) < error(&y), "{r}: {} {}", error(&x), error(&y));
    }
}

#[test]
fn orders_that_cannot_be_met_are_refused() {
    let text = refusal("reduce", r#"{"A": [[1,0],[0,-1]], "B": [[1],[1]], "C": [[1,1]], "D": [[0]], "orders": [0]}"#);
    assert!(text.contains("orders[0]") && text.contains("1 poles"), "{text}");
    let text = refusal("reduce", r#"{"A": [[-1]], "B": [[1]], "C": [[1]], "D": [[0]], "orders": [2]}"#);
    assert!(text.contains("has 1 states"), "{text}");
}
