//! Discretisation: responses and matrices against the references, inverse maps, exponentials, Lyapunov equations.

use crate::robust::solve_cases::{answer, cases, complex, matrix, number, refusal};
use muspin::linalg::Mat;
use muspin::linalg::exponential::exponential;
use muspin::linalg::lyapunov::{discrete_lyapunov, lyapunov, sylvester};
use muspin::linalg::schur::schur;
use muspin::lti::sample::{inverse_tustin, tustin, tustin_prewarped};
use muspin::lti::{Continuous, Discrete, Response, StateSpace};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[test]
fn responses_match_the_references() {
    for case in cases("discretise", 3) {
        let found = answer("discretise", &case.path);
        let response = &case.json["reference"]["response"];
        let period_s = number(&case.json["data"]["Ts"]);
        for kind in ["zoh", "tustin", "tustin_prewarp"] {
            let m = |name: &str| matrix(&found[kind][name]);
            let s = StateSpace::new(m("A"), m("B"), m("C"), m("D"), Discrete { period_s }).unwrap();
            for (k, w) in response["w"].as_array().unwrap().iter().enumerate() {
                let exact = complex(&response[kind]["re"][k], &response[kind]["im"][k]);
                let error = (&s.at(number(w)) - &exact).norm_l2() / exact.norm_l2();
                assert!(error < 1e-9, "{} {kind} {w}: {error:e}", case.name);
            }
            for name in ["A", "B", "C", "D"] {
                let exact = matrix(&case.json["reference"][kind][format!("{name}d")]);
                let error = (&m(name) - &exact).norm_max();
                assert!(error <= 1e-10 * exact.norm_max(), "{} {kind} {name}", case.name);
            }
        }
    }
}

fn random(rng: &mut ChaCha8Rng, rows: usize, cols: usize) -> Mat<f64> {
    Mat::from_fn(rows, cols, |_, _| rng.random_range(-1.0..1.0))
}

#[test]
fn inverse_tustin_returns_the_same_matrices() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let s = StateSpace::new(
        random(&mut rng, 6, 6),
        random(&mut rng, 6, 2),
        random(&mut rng, 3, 6),
        random(&mut rng, 3, 2),
        Continuous,
    )
    .unwrap();
    let back = inverse_tustin(&tustin(&s, 0.05).unwrap()).unwrap();
    for (x, y) in [(&s.a, &back.a), (&s.b, &back.b), (&s.c, &back.c), (&s.d, &back.d)] {
        assert!((x - y).norm_max() < 1e-12);
    }
    let omega = 17.0;
    let warped = tustin_prewarped(&s, 0.05, omega).unwrap();
    assert!((&warped.at(omega) - &s.at(omega)).norm_l2() < 1e-12 * s.at(omega).norm_l2());
}

#[test]
fn exponential_of_a_rotation_and_of_a_badly_scaled_matrix_are_closed_forms() {
    let t: f64 = 40.0;
    let e = exponential(&Mat::from_fn(2, 2, |i, j| [[0.0, t], [-t, 0.0]][i][j])).unwrap();
    assert!((e[(0, 0)] - t.cos()).abs() < 1e-12 && (e[(0, 1)] - t.sin()).abs() < 1e-12);
    // exp([a, 1e9; 0, b]) has the divided difference of exp in its corner.
    let (a, b): (f64, f64) = (-1.0, -3.0);
    let e = exponential(&Mat::from_fn(2, 2, |i, j| [[a, 1e9], [0.0, b]][i][j])).unwrap();
    let exact = 1e9 * (a.exp() - b.exp()) / (a - b);
    assert!((e[(0, 1)] / exact - 1.0).abs() < 1e-14 && (e[(0, 0)] / a.exp() - 1.0).abs() < 1e-14);
}

#[test]
fn exponentials_are_those_of_another_library() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for n in [1, 3, 9, 30, 70] {
        for size in [0.0, 1e-6, 0.1, 1.0, 7.0, 40.0] {
            let a = random(&mut rng, n, n);
            let a = &a * faer::Scale(size / a.norm_l2());
            let other = nalgebra::DMatrix::from_fn(n, n, |i, j| a[(i, j)]).exp();
            let found = exponential(&a).unwrap();
            let apart = Mat::from_fn(n, n, |i, j| found[(i, j)] - other[(i, j)]);
            // Squaring multiplies rounding by the norm.
            let allowed = 1e-14 * (1.0 + size) * n as f64 * found.norm_max();
            assert!(apart.norm_max() < allowed, "order {n}, norm {size}");
        }
    }
    let large = exponential(&Mat::from_fn(1, 1, |_, _| 1e3));
    assert!(large.is_err());
}

#[test]
fn schur_forms_lyapunov_and_sylvester_solutions_have_small_residuals() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for n in [1, 2, 3, 7, 20, 40] {
        let a = random(&mut rng, n, n);
        let (form, stable) = schur(&a).unwrap().reorder(|v| v.re < 0.0);
        assert!((&form.z * &form.t * form.z.transpose() - &a).norm_l2() < 1e-12 * (1.0 + a.norm_l2()));
        let values = form.eigenvalues();
        assert!(values[..stable].iter().all(|v| v.re < 0.0));
        assert!(values[stable..].iter().all(|v| v.re >= 0.0));
        let q = random(&mut rng, n, n);
        let q = &q * q.transpose();
        let x = lyapunov(&a, &q).unwrap();
        let rest = (a.transpose() * &x + &x * &a + &q).norm_l2();
        assert!(rest < 1e-11 * (x.norm_l2() * a.norm_l2() + q.norm_l2()), "{n}");
        let b = random(&mut rng, 5, 5);
        let c = random(&mut rng, n, 5);
        let x = sylvester(&a, &b, &c).unwrap();
        let rest = (&a * &x + &x * &b - &c).norm_l2();
        assert!(rest < 1e-11 * (x.norm_l2() * (a.norm_l2() + b.norm_l2()) + c.norm_l2()), "{n}");
        let contraction = Mat::from_fn(n, n, |i, j| a[(i, j)] / (n as f64 + 1.0));
        let x = discrete_lyapunov(&contraction, &q).unwrap();
        let rest = (contraction.transpose() * &x * &contraction - &x + &q).norm_l2();
        assert!(rest < 1e-12 * (x.norm_l2() + q.norm_l2()), "{n}");
    }
}

#[test]
fn impossible_periods_are_refused() {
    let text = refusal("discretise", r#"{"A": [[-1]], "B": [[1]], "C": [[1]], "D": [[0]], "Ts": 0}"#);
    assert!(text.contains("Ts: must be positive"), "{text}");
    let text = refusal("discretise", r#"{"A": [[-1]], "B": [[1]], "C": [[1]], "D": [[0]], "Ts": 1, "w_prewarp": 4}"#);
    assert!(text.contains("w_prewarp"), "{text}");
}
