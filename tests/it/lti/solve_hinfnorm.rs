//! H∞ norms: references, closed forms, bounds on random systems, sampled time.

use crate::robust::solve_cases::{answer, cases, number, refusal};
use muspin::linalg::{Mat, max_singular_value_complex};
use muspin::lti::norm::{NormError, hinf_norm, hinf_norm_discrete};
use muspin::lti::sample::zoh;
use muspin::lti::{Continuous, FrequencyResponder, Response, StateSpace};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[test]
fn norm_and_certificate_match_the_references() {
    for case in cases("hinfnorm", 7) {
        let found = answer("hinfnorm", &case.path);
        let reference = &case.json["reference"];
        let (norm, exact) = (number(&found["norm"]), number(&reference["norm"]));
        assert!((norm / exact - 1.0).abs() < 1e-8, "{}: {norm} {exact}", case.name);
        let upper = number(&found["upper"]);
        assert!(upper >= exact * (1.0 - 1e-12) && upper <= exact * (1.0 + 1e-8), "{}", case.name);
        if let Some(omega) = reference["peak_freq_rad_s"].as_f64() {
            let peak = number(&found["peak_freq_rad_s"]);
            assert!((peak - omega).abs() <= 1e-5 * omega, "{}: {peak} {omega}", case.name);
        }
    }
}

fn system(a: &[f64], b: &[f64], c: &[f64], d: f64) -> StateSpace<Continuous> {
    let n = b.len();
    StateSpace::new(
        Mat::from_fn(n, n, |i, j| a[n * i + j]),
        Mat::from_fn(n, 1, |i, _| b[i]),
        Mat::from_fn(1, n, |_, j| c[j]),
        Mat::from_fn(1, 1, |_, _| d),
        Continuous,
    )
    .unwrap()
}

#[test]
fn peak_of_a_mode_is_its_closed_form() {
    for zeta in [0.3, 1e-2, 1e-4, 1e-6] {
        let w = 250.0;
        let mode = system(&[0.0, w, -w, -2.0 * zeta * w], &[0.0, w], &[1.0, 0.0], 0.0);
        let found = hinf_norm(&mode, 1e-10).unwrap();
        let exact = 1.0 / (2.0 * zeta * f64::sqrt(1.0 - zeta * zeta));
        // The damping of the data is known to ε/ζ only.
        assert!((found.norm / exact - 1.0).abs() < 1e-14 / zeta + 1e-12, "{zeta}");
        let peak = w * f64::sqrt(1.0 - 2.0 * zeta * zeta);
        assert!((found.peak_omega_rad_s / peak - 1.0).abs() < 1e-6, "{zeta}");
    }
}

#[test]
fn peaks_at_dc_and_at_infinity_and_flat_gains_are_found() {
    let low = hinf_norm(&system(&[-1.0], &[1.0], &[1.0], 5.0), 1e-10).unwrap();
    assert_eq!((low.norm, low.peak_omega_rad_s), (6.0, 0.0));
    let high = hinf_norm(&system(&[-1.0], &[1.0], &[-1.0], 5.0), 1e-10).unwrap();
    assert_eq!((high.norm, high.peak_omega_rad_s), (5.0, f64::INFINITY));
    let flat = hinf_norm(&system(&[-1.0], &[1.0], &[-2.0], 1.0), 1e-10).unwrap();
    assert!((flat.norm - 1.0).abs() < 1e-12 && flat.upper >= 1.0);
    let none = hinf_norm(&system(&[-1.0], &[0.0], &[1.0], 0.0), 1e-10).unwrap();
    assert_eq!(none.norm, 0.0);
}

#[test]
fn bounds_enclose_a_dense_search_on_random_systems() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for k in 0..20 {
        let modes = rng.random_range(1..8);
        let n = 2 * modes;
        let mut a = Mat::<f64>::zeros(n, n);
        for i in 0..modes {
            let w = 10f64.powf(rng.random_range(-1.0..3.0));
            let z = 10f64.powf(rng.random_range(-4.0..-0.5));
            a[(2 * i, 2 * i + 1)] = w;
            a[(2 * i + 1, 2 * i)] = -w;
            a[(2 * i + 1, 2 * i + 1)] = -2.0 * z * w;
        }
        let mut r = |p, q| Mat::from_fn(p, q, |_, _| rng.random_range(-1.0..1.0));
        let (b, c) = (r(n, 2), r(3, n));
        let d = if k % 2 == 0 { r(3, 2) } else { Mat::zeros(3, 2) };
        let s = StateSpace::new(a, b, c, d, Continuous).unwrap();
        let found = hinf_norm(&s, 1e-10).unwrap();
        let poles = s.poles().unwrap();
        let mut best: f64 = 0.0;
        for p in &poles {
            for step in -40..=40 {
                let w = (p.im + 0.1 * f64::from(step) * p.re).abs();
                best = best.max(max_singular_value_complex(&s.at(w)));
            }
        }
        assert!(found.upper >= best * (1.0 - 1e-12), "{k}");
        assert!(found.norm <= found.upper && found.norm >= best * (1.0 - 1e-9), "{k}");
        let attained = max_singular_value_complex(&s.at(found.peak_omega_rad_s));
        if found.peak_omega_rad_s.is_finite() {
            assert!((attained / found.norm - 1.0).abs() < 1e-9, "{k}");
        }
    }
}

#[test]
fn sampled_norm_is_attained_on_the_unit_circle() {
    let w = 300.0;
    let mode = system(&[0.0, w, -w, -2e-3 * w], &[0.0, w], &[1.0, 0.0], 0.2);
    let sampled = zoh(&mode, 1e-3).unwrap();
    let found = hinf_norm_discrete(&sampled, 1e-10).unwrap();
    let at_peak = max_singular_value_complex(&sampled.at(found.peak_omega_rad_s));
    assert!((at_peak / found.norm - 1.0).abs() < 1e-8);
    for k in 0..2000 {
        let omega = f64::from(k) * std::f64::consts::PI / 1e-3 / 2000.0;
        assert!(max_singular_value_complex(&sampled.at(omega)) <= found.upper * (1.0 + 1e-9));
    }
}

#[test]
fn hessenberg_evaluation_agrees_with_the_direct_solve() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for (n, m, p) in [(17, 3, 2), (1, 1, 1), (2, 9, 4), (40, 4, 4), (23, 5, 1), (30, 12, 8), (0, 2, 2)] {
        // Whole, and with small entries off the diagonal or on it, so that either column is the pivot.
        for scale in [1.0, 1e-3, 1e3] {
            let mut r = |p, q| Mat::from_fn(p, q, |_, _| rng.random_range(-1.0..1.0));
            let (a, b, c, d) = (r(n, n), r(n, m), r(p, n), r(p, m));
            let a = Mat::from_fn(n, n, |i, j| if i == j { scale * a[(i, j)] } else { a[(i, j)] });
            let s = StateSpace::new(a, b, c, d, Continuous).unwrap();
            let fast = FrequencyResponder::new(&s);
            for omega in [0.0, 0.1, 1.0, 7.0, 1e3] {
                let (x, y) = (s.at(omega), fast.at(omega));
                assert!((&x - &y).norm_l2() <= 1e-11 * x.norm_l2(), "{n} {m} {p} {omega}");
            }
        }
    }
}

#[test]
fn unstable_systems_are_refused_by_name() {
    let error = hinf_norm(&system(&[1.0], &[1.0], &[1.0], 0.0), 1e-10).unwrap_err();
    assert!(matches!(error, NormError::Unstable { growth_rate } if growth_rate == 1.0));
    let text = refusal("hinfnorm", r#"{"A": [[0]], "B": [[1]], "C": [[1]], "D": [[0]]}"#);
    assert!(text.contains("unstable") && text.contains("hint"), "{text}");
    let text = refusal("hinfnorm", r#"{"A": [[-1]], "B": [[1]], "C": [[1, 2]], "D": [[0]]}"#);
    assert!(text.contains("C: expected a 1 x 1 matrix"), "{text}");
}
