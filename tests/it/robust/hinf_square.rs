//! H∞ synthesis where the control reaches every error, or the measurement sees every disturbance: with D12 square there
//! is a Riccati equation left only for the unstable zeros of P12, and its solution is the inverse of a gramian.

use muspin::augment::GeneralizedPlant;
use muspin::linalg::{Mat, max_singular_value};
use muspin::lti::connect::lower_lft;
use muspin::lti::{Continuous, StateSpace};
use muspin::robust::hinf::Limit;
use muspin::robust::{HinfSettings, synthesise};
use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn random(rows: usize, columns: usize, from: &mut ChaCha8Rng) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| from.random_range(-1.0..1.0))
}

/// Order `n`, as many disturbances and measurements as states, two errors and controls: D12 and D21 are square. P21 has
/// stable zeros, −1 each; the zeros of P12 are the eigenvalues of `zeros`. With the plant come E = B1 − B2 D12⁻¹D11 and
/// B2 D12⁻¹, through which the disturbance and the errors drive those zeros.
fn square(zeros: &DMatrix<f64>, from: &mut ChaCha8Rng) -> (GeneralizedPlant, DMatrix<f64>, DMatrix<f64>) {
    let n = zeros.nrows();
    let (b1, b2, c1) = (random(n, n, from), random(n, 2, from), random(2, n, from));
    let (d11, d12) = (random(2, n, from), DMatrix::identity(2, 2) + random(2, 2, from) * 0.3);
    let inverse = d12.clone().try_inverse().expect("near the identity");
    let a = zeros + &b2 * &inverse * &c1;
    // With D21 = I the zeros of P21 are the eigenvalues of A − B1 C2.
    let c2 = b1.clone().try_inverse().expect("random") * (&a + DMatrix::identity(n, n));
    let e = &b1 - &b2 * &inverse * &d11;
    let b = DMatrix::from_fn(n, n + 2, |i, j| if j < n { b1[(i, j)] } else { b2[(i, j - n)] });
    let c = DMatrix::from_fn(2 + n, n, |i, j| if i < 2 { c1[(i, j)] } else { c2[(i - 2, j)] });
    let d = DMatrix::from_fn(2 + n, n + 2, |i, j| match (i < 2, j < n) {
        (true, true) => d11[(i, j)],
        (true, false) => d12[(i, j - n)],
        (false, true) => f64::from(u8::from(i - 2 == j)),
        (false, false) => 0.0,
    });
    let own = |m: &DMatrix<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)]);
    let plant = GeneralizedPlant {
        system: StateSpace::new(own(&a), own(&b), own(&c), own(&d), Continuous).expect("fits"),
        controls: 2,
        measurements: n,
        blocks: vec![],
    };
    (plant, e, b2 * inverse)
}

/// W of A W + W Aᵀ = B Bᵀ, by Kronecker products.
fn gramian(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    let eye = DMatrix::identity(n, n);
    let whole = eye.kronecker(a) + a.kronecker(&eye);
    let right = b * b.transpose();
    let right = DMatrix::from_column_slice(n * n, 1, right.as_slice());
    let found = whole.lu().solve(&right).expect("no zero on the axis");
    DMatrix::from_column_slice(n, n, found.as_slice())
}

/// The transposed plant: the filter side of one is the control side of the other.
fn transposed(plant: &GeneralizedPlant) -> GeneralizedPlant {
    let s = &plant.system;
    let t = |m: &Mat<f64>| m.transpose().to_owned();
    GeneralizedPlant {
        system: StateSpace::new(t(&s.a), t(&s.c), t(&s.b), t(&s.d), Continuous).expect("fits"),
        controls: plant.measurements,
        measurements: plant.controls,
        blocks: vec![],
    }
}

/// X⁻¹ = W₂ − W₁/γ² for zeros that are all unstable, with W₂ the gramian of the control in the basis of the zeros and W₁
/// that of the disturbance: X is positive above γ² = λmax(W₁W₂⁻¹), and passes infinity there.
#[test]
fn with_unstable_zeros_the_level_is_that_of_two_gramians() {
    for seed in 0..40 {
        let mut from = ChaCha8Rng::seed_from_u64(seed);
        let n = from.random_range(1..5);
        let zeros = random(n, n, &mut from) + DMatrix::identity(n, n) * 2.5;
        let (plant, e, b) = square(&zeros, &mut from);
        let root = gramian(&zeros, &b).cholesky().expect("controllable").l();
        let half = root.solve_lower_triangular(&gramian(&zeros, &e)).expect("regular");
        let whole = root.solve_lower_triangular(&half.transpose()).expect("regular");
        let exact = whole.symmetric_eigenvalues().max().sqrt();
        for (plant, limit) in [(transposed(&plant), Limit::FilterIndefinite), (plant, Limit::ControlIndefinite)] {
            let found = synthesise(&plant, &HinfSettings::default()).expect("solvable");
            let error = found.gamma_opt / exact - 1.0;
            // X grows without limit there, and its equation is not solved to the last millionths.
            assert!(error.abs() < 2e-5, "{seed} {limit:?}: {error:e}");
            assert_eq!(found.certificate.limit, Some(limit), "{seed}");
            assert!(found.closed_loop_norm <= 1.0011 * exact, "{seed}");
        }
    }
}

/// With stable zeros the controller cancels the plant: the infimum of the level is zero.
#[test]
fn a_plant_that_can_be_cancelled_has_a_controller_at_rounding_level() {
    for seed in 0..20 {
        let mut from = ChaCha8Rng::seed_from_u64(seed);
        let zeros = random(3, 3, &mut from) - DMatrix::identity(3, 3) * 2.5;
        let (plant, ..) = square(&zeros, &mut from);
        let found = synthesise(&plant, &HinfSettings::default()).expect("solvable");
        assert_eq!(found.certificate.limit, Some(Limit::Rounding), "{seed}");
        let size = max_singular_value(&plant.system.d);
        assert!(found.closed_loop_norm <= found.gamma, "{seed}");
        assert!(found.gamma < 1e-9 * size, "{seed}: {:e}", found.gamma);
        let closed = lower_lft(&plant.system, &found.controller).expect("well posed");
        assert!(closed.growth_rate().expect("eigenvalues") < 0.0, "{seed}");
    }
}
