//! Riccati equations: the multi-precision references, closed forms, and what must be refused.

use crate::robust::solve_cases::{answer, cases, matrix, number, refusal};
use muspin::linalg::riccati::{RiccatiEffort, RiccatiError, care, care_with};
use muspin::linalg::{Mat, eigenvalues};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[test]
fn error_is_at_most_ten_times_the_better_of_scipy_and_slicot() {
    for case in cases("care", 14) {
        let found = answer("care", &case.path);
        let reference = &case.json["reference"];
        let (x, exact) = (matrix(&found["X"]), matrix(&reference["X"]));
        let error = (&x - &exact).norm_l2() / exact.norm_l2();
        let best = ["scipy", "slicot_sb02md", "slicot_sb02rd"]
            .iter()
            .filter_map(|tool| reference["solver_relative_error"][tool].as_f64())
            .fold(f64::INFINITY, f64::min);
        assert!(error <= 10.0 * best, "{}: {error:e} against {best:e}", case.name);
        // Residuals in f64 reach the noise of their own evaluation, which carex_2_2 raises.
        assert!(number(&found["residual"]) < 1e-14, "{}", case.name);
        let growth = number(&found["closed_loop_max_real"]);
        let expected = number(&reference["closed_loop_max_real"]);
        assert!((growth / expected - 1.0).abs() < 1e-6, "{}: {growth}", case.name);
    }
}

fn random(rng: &mut ChaCha8Rng, rows: usize, cols: usize) -> Mat<f64> {
    Mat::from_fn(rows, cols, |_, _| rng.random_range(-1.0..1.0))
}

#[test]
fn random_equations_have_small_residual_symmetric_solution_and_stable_loop() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for k in 0..40 {
        let n = rng.random_range(1..25);
        let a = random(&mut rng, n, n);
        let (b, c) = (random(&mut rng, n, 3), random(&mut rng, 4, n));
        let w = random(&mut rng, n, 2);
        // Every third equation has an indefinite G, as at a finite H-infinity level.
        let level = if k % 3 == 0 { 0.01 } else { 0.0 };
        let g = &b * b.transpose() - faer_scaled(&(&w * w.transpose()), level);
        let q = c.transpose() * &c;
        for effort in [RiccatiEffort::Fast, RiccatiEffort::Full] {
            let found = care_with(&a, &g, &q, effort).unwrap();
            let x = &found.x;
            let ax = a.transpose() * x;
            let rest = (&ax + ax.transpose() - x * &g * x + &q).norm_l2();
            let size = 2.0 * ax.norm_l2() + (x * &g * x).norm_l2() + q.norm_l2();
            assert!(rest <= 1e-9 * size, "{k} {effort:?}: {:e}", rest / size);
            assert!((x - x.transpose()).norm_max() == 0.0);
            let poles = eigenvalues(&(&a - &g * x)).unwrap();
            assert!(poles.iter().all(|p| p.re < 0.0), "{k} {effort:?}");
        }
    }
}

fn faer_scaled(m: &Mat<f64>, factor: f64) -> Mat<f64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| factor * m[(i, j)])
}

#[test]
fn identical_channels_and_scaled_states_are_solved() {
    // Four equal lightly damped modes: eigenvectors of the Hamiltonian are not defined, its stable subspace is.
    let n = 8;
    let a = Mat::from_fn(n, n, |i, j| match (i / 2 == j / 2, i % 2, j % 2) {
        (true, 0, 1) => 1.0e3,
        (true, 1, 0) => -1.0e9,
        (true, 1, 1) => -0.2,
        _ => 0.0,
    });
    let g = Mat::from_fn(n, n, |i, j| if i == j && i % 2 == 1 { 4.0 } else { 0.0 });
    let q = Mat::from_fn(n, n, |i, j| if i == j && i % 2 == 0 { 1e6 } else { 0.0 });
    let found = care(&a, &g, &q).unwrap();
    assert!(found.residual < 1e-14 && found.closed_loop_max_real < 0.0);
    for i in 0..n {
        for j in 0..n {
            if i / 2 != j / 2 {
                assert_eq!(found.x[(i, j)], 0.0);
            }
        }
    }
}

#[test]
fn scalar_solution_is_the_closed_form() {
    // 2ax − gx² + q = 0, x = (a + √(a² + gq))/g.
    let m = |x: f64| Mat::from_fn(1, 1, |_, _| x);
    for (a, g, q) in [(1.0, 2.0, 3.0), (-1.0, 1e-8, 5.0), (3.0, 1e6, 1e-6), (-1.0, -1.0, 0.5)] {
        let found = care(&m(a), &m(g), &m(q)).unwrap();
        let root: f64 = f64::sqrt(a * a + g * q);
        // The branch without cancellation.
        let expected = if a < 0.0 { q / (root - a) } else { (a + root) / g };
        assert!((found.x[(0, 0)] / expected - 1.0).abs() < 4.0 * f64::EPSILON);
    }
}

#[test]
fn equations_without_stabilising_solution_are_refused_by_name() {
    let two = |v: [f64; 4]| Mat::from_fn(2, 2, |i, j| v[2 * i + j]);
    let one = two([1.0, 0.0, 0.0, 1.0]);
    let zero = two([0.0; 4]);
    let rotation = two([0.0, 1.0, -1.0, 0.0]);
    // The eigenvalue is double and defective: known to the root of the rounding error.
    let axis = care(&rotation, &zero, &one).unwrap_err();
    assert!(matches!(axis, RiccatiError::AxisEigenvalue { omega_rad_s } if (omega_rad_s - 1.0).abs() < 1e-6), "{axis}");
    let unstable = care(&two([1.0, 0.0, 0.0, -1.0]), &two([0.0, 0.0, 0.0, 1.0]), &one);
    assert!(matches!(unstable, Err(RiccatiError::NoStabilisingSolution { .. })), "{unstable:?}");
    let skew = care(&one, &rotation, &one).unwrap_err();
    assert!(matches!(skew, RiccatiError::NotSymmetric { which: "G", .. }));
}

#[test]
fn bad_problems_are_refused_with_the_field() {
    let text = refusal("care", r#"{"A": [[0, 1], [-1, 0]], "G": [[0, 0], [0, 0]], "Q": [[1, 0], [0, 1]]}"#);
    assert!(text.contains("imaginary axis"), "{text}");
    let text = refusal("care", r#"{"data": {"A": [[1, 2], [3, null]], "G": [[1]], "Q": [[1]]}}"#);
    assert!(text.contains("A[1][1]") && text.contains("null"), "{text}");
    let text = refusal("care", r#"{"A": [[1]], "G": [[1]]}"#);
    assert!(text.contains("Q: missing"), "{text}");
    let text = refusal("care", r#"{"A": [[1]], "G": [[1, 2]], "Q": [[1]]}"#);
    assert!(text.contains("G: expected a 1 x 1 matrix"), "{text}");
    let text = refusal("care", r#"{"A": [[NaN]], "G": [[1]], "Q": [[1]]}"#);
    assert!(text.contains("not valid JSON"), "{text}");
}
