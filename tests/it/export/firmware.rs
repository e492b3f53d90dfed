//! Realisations and firmware: transfer kept, C compiled and run against the vectors, Q31 within its derived bound.

use muspin::controller::arithmetic::{float32, q31};
use muspin::controller::continuous::continuous_fit;
use muspin::controller::realise::modal_form;
use muspin::controller::scaling::{SignalLimits, scale_realisation};
use muspin::controller::sections::second_order_sections;
use muspin::controller::{ControllerError, Realisation};
use muspin::linalg::{Mat, c64};
use muspin::lti::connect::block2;
use muspin::lti::{Discrete, StateSpace};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

pub(crate) const TIME: Discrete = Discrete { period_s: 5e-5 };
pub(crate) const LIMITS: SignalLimits = SignalLimits { input_m: 2.54e-4, output_a: 3.0 };

/// Block-diagonal system from pole blocks, hidden behind a random similarity.
pub(crate) fn hidden(blocks: &[Mat<f64>], inputs: usize, outputs: usize, seed: u64) -> StateSpace<Discrete> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut a = Mat::zeros(0, 0);
    for block in blocks {
        a = block2(&a, &Mat::zeros(a.nrows(), block.ncols()), &Mat::zeros(block.nrows(), a.ncols()), block);
    }
    let n = a.nrows();
    let mut draw = |r, c, scale: f64| Mat::from_fn(r, c, |_, _| scale * random.random_range(-1.0..1.0));
    let t = Mat::<f64>::identity(n, n) + draw(n, n, 0.5);
    let inverse = muspin::linalg::solve(&t, &Mat::identity(n, n)).unwrap();
    let (b, c, d) = (draw(n, inputs, 300.0), draw(outputs, n, 1.0), draw(outputs, inputs, 1000.0));
    StateSpace::new(&t * &a * &inverse, &t * &b, &c * &inverse, d, TIME).unwrap()
}

pub(crate) fn pair(frequency_hz: f64, damping: f64) -> Mat<f64> {
    let w = TAU * frequency_hz * TIME.period_s;
    let z = c64::from_polar((-damping * w).exp(), w * (1.0 - damping * damping).sqrt());
    Mat::from_fn(2, 2, |i, j| match (i, j) {
        (0, 1) => z.im,
        (1, 0) => -z.im,
        _ => z.re,
    })
}

pub(crate) fn real(pole: f64) -> Mat<f64> {
    Mat::from_fn(1, 1, |_, _| pole)
}

fn largest_difference(first: &StateSpace<Discrete>, second: &StateSpace<Discrete>) -> f64 {
    let (mut peak, mut change) = (0.0f64, 0.0f64);
    for k in 1..400 {
        let z = c64::from_polar(1.0, PI * (k as f64 / 400.0).powi(3));
        let (g, h) = (first.transfer(z), second.transfer(z));
        peak = peak.max(g.norm_l2());
        change = change.max((&g - &h).norm_l2());
    }
    change / peak
}

pub(crate) fn typical() -> StateSpace<Discrete> {
    let mut blocks = vec![real(0.99), real(0.2), real(-0.3), real(0.9997)];
    blocks.extend([90.0, 400.0, 1069.0, 1955.0, 3210.0, 5200.0].iter().map(|f| pair(*f, 0.05)));
    hidden(&blocks, 4, 4, 1)
}

#[test]
fn modal_form_keeps_the_transfer_and_separates_every_pole() {
    let k = typical();
    let realisation = modal_form(&k).unwrap();
    assert!(largest_difference(&k, &realisation.to_state_space().unwrap()) < 1e-10);
    let mut blocks = realisation.blocks.clone();
    blocks.sort_unstable();
    assert_eq!(blocks, [1, 1, 1, 1, 2, 2, 2, 2, 2, 2]);
    assert!(realisation.notes.is_empty());
}

#[test]
fn repeated_and_defective_poles_share_a_larger_block() {
    let jordan = Mat::from_fn(3, 3, |i, j| match (i, j) {
        (i, j) if i == j => 0.95,
        (0, 1) | (1, 2) => 0.05,
        _ => 0.0,
    });
    let near = Mat::from_fn(2, 2, |i, j| match (i, j) {
        (0, 1) => 0.3,
        (1, 0) => -1e-12,
        _ => 0.6,
    });
    let twice = pair(700.0, 0.02);
    for (name, blocks) in [
        ("Jordan block of three", vec![jordan, real(0.1), pair(500.0, 0.1)]),
        ("near-defective pair", vec![near, real(-0.2), pair(2000.0, 0.3)]),
        ("two equal pairs", vec![twice.clone(), twice, real(0.4)]),
        ("one equal pole in four", vec![real(0.7), real(0.7), real(0.7), real(0.7)]),
        ("poles at zero", vec![real(0.0), real(0.0), pair(100.0, 0.5)]),
        ("integrators", vec![real(1.0), real(1.0), real(0.5)]),
    ] {
        let k = hidden(&blocks, 2, 2, 7);
        let realisation = modal_form(&k).unwrap_or_else(|e| panic!("{name}: {e}"));
        let back = realisation.to_state_space().unwrap();
        assert!(largest_difference(&k, &back) < 1e-8, "{name}");
        assert_eq!(realisation.blocks.iter().sum::<usize>(), k.order(), "{name}");
    }
}

#[test]
fn a_gain_without_states_is_realised() {
    let k = StateSpace::gain(Mat::from_fn(4, 4, |i, j| (i * 4 + j) as f64 - 7.5), TIME);
    let realisation = modal_form(&k).unwrap();
    assert_eq!(largest_difference(&k, &realisation.rounded_f32().unwrap()), 0.0);
}

pub(crate) fn pid_like() -> StateSpace<Discrete> {
    let mut axes = Vec::new();
    for (kp, f1, f2) in [(-11_000.0, 1400.0, 2500.0), (-9000.0, 900.0, 3000.0)] {
        let a = block2(
            &block2(&real(0.9997), &Mat::zeros(1, 1), &Mat::zeros(1, 1), &real(0.3)),
            &Mat::zeros(2, 4),
            &Mat::zeros(4, 2),
            &block2(&pair(f1, 0.3), &Mat::zeros(2, 2), &Mat::zeros(2, 2), &pair(f2, 0.2)),
        );
        let b = Mat::from_fn(6, 1, |i, _| 0.5 + 0.1 * i as f64);
        let c = Mat::from_fn(1, 6, |_, j| kp * [1e-4, -0.8, 0.3, -0.2, 0.4, 0.1][j]);
        axes.push(StateSpace::new(a, b, c, Mat::from_fn(1, 1, |_, _| 2.0 * kp), TIME).unwrap());
    }
    let two = muspin::lti::connect::append(&axes[0], &axes[1]);
    muspin::lti::connect::append(&two, &two).select(&[0, 2, 1, 3], &[0, 2, 1, 3])
}

#[test]
fn second_order_sections_keep_the_transfer_and_refuse_coupled_axes() {
    let k = pid_like();
    let sections = second_order_sections(&k).unwrap();
    assert!(largest_difference(&k, &sections.to_state_space().unwrap()) < 1e-8);
    assert_eq!(sections.order(), k.order());
    // Strictly proper: one zero of each axis lies at infinity.
    let mut proper = pid_like();
    proper.d = Mat::zeros(4, 4);
    let sections = second_order_sections(&proper).unwrap();
    assert!(largest_difference(&proper, &sections.to_state_space().unwrap()) < 1e-8);
    assert!(matches!(second_order_sections(&typical()), Err(ControllerError::NotDecentralised { .. })));
}

#[test]
fn scaled_states_never_leave_their_range_for_inputs_within_the_limit() {
    let k = typical();
    let rows = scale_realisation(&modal_form(&k).unwrap(), LIMITS).unwrap();
    let system = rows.rows.to_state_space().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut x = vec![0.0f64; system.order()];
    let mut y = [0.0; 4];
    for sample in 0..20_000 {
        if sample % 37 == 0 {
            y = std::array::from_fn(|_| if random.random::<bool>() { 1.0 } else { -1.0 });
        }
        x = (0..x.len())
            .map(|i| {
                (0..x.len()).map(|j| system.a[(i, j)] * x[j]).sum::<f64>()
                    + (0..4).map(|j| system.b[(i, j)] * y[j] * LIMITS.input_m).sum::<f64>()
            })
            .collect();
        for (i, value) in x.iter().enumerate() {
            assert!(rows.anti_windup[i] || value.abs() <= 1.0 + 1e-9, "state {i}: {value}");
        }
    }
}

fn rounding_is_small(realisation: &Realisation, k: &StateSpace<Discrete>) {
    let rows = scale_realisation(realisation, LIMITS).unwrap();
    let single = rows.rows.rounded_f32().unwrap();
    let change = largest_difference(k, &single);
    // Both forms hold the distance of slow poles from one, not the poles.
    assert!(change < 5e-6, "{change:e}");
    let fixed = q31(&rows).unwrap();
    assert!(largest_difference(k, &fixed.to_rounded_system().unwrap()) < 1e-5);
}

#[test]
fn rounded_coefficients_keep_the_transfer() {
    rounding_is_small(&modal_form(&typical()).unwrap(), &typical());
    rounding_is_small(&modal_form(&pid_like()).unwrap(), &pid_like());
    rounding_is_small(&second_order_sections(&pid_like()).unwrap(), &pid_like());
}

#[test]
fn q31_stays_within_its_derived_bound_of_exact_arithmetic() {
    for (realisation, k) in
        [(modal_form(&typical()).unwrap(), typical()), (second_order_sections(&pid_like()).unwrap(), pid_like())]
    {
        let rows = scale_realisation(&realisation, LIMITS).unwrap();
        let mut fixed = q31(&rows).unwrap();
        let samples = 500;
        let bound = fixed.error_bound_a(samples);
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut x = vec![0.0f64; k.order()];
        let mut worst = 0.0f64;
        for _ in 0..samples {
            let y: Vec<i32> = (0..4).map(|_| fixed.encode_input(3e-6 * random.random_range(-1.0..1.0))).collect();
            let exact: Vec<f64> = y.iter().map(|v| fixed.decode_input(*v)).collect();
            let u = fixed.step(&y);
            let dot = |m: &Mat<f64>, i: usize, v: &[f64]| v.iter().enumerate().map(|(j, v)| m[(i, j)] * v).sum::<f64>();
            for (i, value) in u.iter().enumerate() {
                let expected = dot(&k.c, i, &x) + dot(&k.d, i, &exact);
                assert!(expected.abs() < LIMITS.output_a, "the comparison must be linear");
                worst = worst.max((fixed.decode_output(*value) - expected).abs());
            }
            x = (0..x.len()).map(|i| dot(&k.a, i, &x) + dot(&k.b, i, &exact)).collect();
        }
        assert!(worst <= bound, "{worst:e} A against a bound of {bound:e} A");
        assert!(bound < 1e-3, "a bound of {bound:e} A says nothing");
    }
}

#[test]
fn an_integrator_does_not_wind_up() {
    let k = StateSpace::new(real(1.0), real(1.0), real(-50.0), real(-10_000.0), TIME).unwrap();
    let rows = scale_realisation(&modal_form(&k).unwrap(), LIMITS).unwrap();
    let mut single = float32(&rows).unwrap();
    let mut last = 0.0;
    for _ in 0..1_000_000 {
        last = single.step(&[1e-4])[0];
    }
    assert_eq!(last, -3.0);
    // Once the error turns, the current must leave the stop within the time that the integrator needs on its own.
    let needed = (2.0 * 3.0 / (50.0 * 1e-4)) as usize;
    let leaves = (0..needed).any(|_| single.step(&[-1e-4])[0] > 0.0);
    assert!(leaves);
}

#[test]
fn the_continuous_fit_is_close_below_a_quarter_of_the_nyquist_frequency() {
    for k in [typical(), pid_like()] {
        let fit = continuous_fit(&k).unwrap();
        let nyquist_hz = 0.5 / TIME.period_s;
        let (low, middle) = (fit.error_to(0.1 * nyquist_hz), fit.error_to(0.25 * nyquist_hz));
        assert!(low < 0.02 && middle < 0.05, "{low} {middle}");
        // Every pole is where exp(s T) is one of the sampled poles, and the statement of the error is true.
        let (hz, stated) = fit.relative_error[200];
        let z = c64::from_polar(1.0, TAU * hz * TIME.period_s);
        let (exact, found) = (k.transfer(z), fit.law.transfer(c64::new(0.0, TAU * hz)));
        let norm = |m: &Mat<c64>| muspin::linalg::max_singular_value_complex(m);
        assert!((norm(&(&found - &exact)) / norm(&exact) - stated).abs() < 1e-9);
        let slow = fit.law.poles().unwrap().iter().map(|s| (s * TIME.period_s).exp()).collect::<Vec<_>>();
        for pole in k.poles().unwrap().iter().filter(|z| z.re > 0.0 && z.im >= 0.0) {
            assert!(slow.iter().any(|z| (z - pole).norm() < 1e-6), "{pole}");
        }
        // Tustin's rule taken back, the usual stand-in, is further off.
        let bilinear =
            |w: f64| k.transfer(c64::new(1.0, 0.5 * TIME.period_s * w) / c64::new(1.0, -0.5 * TIME.period_s * w));
        let w = TAU * 0.25 * nyquist_hz;
        let back = bilinear(w) - k.transfer(c64::from_polar(1.0, w * TIME.period_s));
        assert!(norm(&back) / norm(&k.transfer(c64::from_polar(1.0, w * TIME.period_s))) > 2.0 * middle);
    }
}

#[test]
fn mat_file_is_read_back_and_carries_no_clock() {
    let k = typical();
    let bytes = muspin::export::mat::mat_file(&[("A", &k.a), ("B", &k.b)]).unwrap();
    assert!(bytes.starts_with(b"MATLAB 5.0 MAT-file, written by muspin  "));
    let file = matrw::load_matfile_from_u8(&bytes).unwrap();
    let a: Vec<f64> = file["A"].to_vec::<f64>().unwrap();
    assert_eq!(file["A"].dim(), [16, 16]);
    assert_eq!(a[1], k.a[(1, 0)]);
    assert_eq!(a[16], k.a[(0, 1)]);
}

#[test]
fn hexadecimal_floats_are_exact() {
    use muspin::export::rows::hex_float;
    assert_eq!(hex_float(1.0), "0x1.000000p0f");
    assert_eq!(hex_float(-0.15625), "-0x1.400000p-3f");
    assert_eq!(hex_float(f32::MIN_POSITIVE / 2.0), "0x0.800000p-126f");
    assert_eq!(hex_float(0.1), "0x1.99999ap-4f");
}
