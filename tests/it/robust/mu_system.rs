//! Peak of μ over frequency against the dense reference sweeps.

use crate::robust::control_cases::{Case, block_list, system};
use muspin::augment::Block;
use muspin::linalg::Mat;
use muspin::lti::{Continuous, Response, StateSpace};
use muspin::robust::mu::peak::CERTIFICATE_SLACK;
use muspin::robust::mu::system::MuSystem;

#[test]
fn certified_peaks_match_the_dense_sweeps() {
    for case in Case::all("musys") {
        let n = system(&case.data);
        let mu = MuSystem::new(&n, &block_list(&case.data["blocks"])).unwrap();
        let peak = mu.peak(CERTIFICATE_SLACK).unwrap();
        let reference = case.reference["mu_peak"].as_f64().unwrap();
        assert!(peak.upper >= reference * (1.0 - 1e-4), "{}: {}", case.id, peak.upper);
        assert!(peak.upper <= reference * (1.0 + 1e-3), "{}: {}", case.id, peak.upper);
        assert!(peak.bounds.lower >= 0.95 * peak.upper, "{}: {}", case.id, peak.bounds.lower);
        assert!(peak.bounds.lower <= peak.upper);
    }
}

#[test]
fn branch_and_bound_finds_the_peak_of_the_full_sweep() {
    for case in Case::all("musys") {
        let n = system(&case.data);
        let mu = MuSystem::new(&n, &block_list(&case.data["blocks"])).unwrap();
        let full = mu.sweep(&mu.grid()).unwrap();
        let highest = full.iter().map(|p| p.upper).fold(0.0, f64::max);
        let (best, points) = mu.largest().unwrap();
        assert!(best.upper >= highest * (1.0 - 1e-9), "{}", case.id);
        let at_best = mu.point(best.omega_rad_s).unwrap().upper;
        assert!((best.upper / at_best - 1.0).abs() < 1e-9, "{}", case.id);
        assert_eq!(points.len(), full.len());
        for (point, optimum) in points.iter().zip(&full) {
            assert_eq!(point.omega_rad_s, optimum.omega_rad_s);
            // Every bound is proved by its scaling, up to the couplings that the reduction to connected channels leaves
            // out.
            let proved = point.scaling.bound_at(&mu.response(point.omega_rad_s));
            assert!(
                proved <= point.upper * (1.0 + 1e-5),
                "{} at {} rad/s: {proved} proved, {} stated",
                case.id,
                point.omega_rad_s,
                point.upper
            );
            assert!(point.upper <= best.upper * (1.0 + 1e-9), "{}", case.id);
        }
    }
}

#[test]
fn the_margin_of_a_spring_with_uncertain_stiffness_is_its_closed_form() {
    // q'' + 2ζ q' + q = −δ q is unstable first for δ = −1 (real); a complex δ of size 2ζ√(1 − ζ²) is enough.
    for damping in [1e-4, 1e-2, 0.3] {
        let a = Mat::from_fn(2, 2, |i, j| [[0.0, 1.0], [-1.0, -2.0 * damping]][i][j]);
        let b = Mat::from_fn(2, 1, |i, _| [0.0, -1.0][i]);
        let c = Mat::from_fn(1, 2, |_, j| [1.0, 0.0][j]);
        let n = StateSpace::new(a, b, c, Mat::zeros(1, 1), Continuous).unwrap();
        let peak = |block: Block| MuSystem::new(&n, &[block]).unwrap().peak(1e-4);
        let found = peak(Block::ComplexScalar { n: 1 }).unwrap();
        // Certified below, attained above.
        let [below, above] = [found.upper, found.bounds.lower].map(f64::recip);
        let exact = 2.0 * damping * (1.0 - damping * damping).sqrt();
        assert!(below <= exact && below > exact * (1.0 - 2e-4));
        assert!((above / exact - 1.0).abs() < 1e-6, "{damping} {above}");
        // The worst perturbation puts a pole on the axis: 1 = δ N(jω).
        let delta = found.bounds.delta[(0, 0)];
        let gain = delta * n.at(found.omega_rad_s)[(0, 0)];
        assert!((1.0 - gain).norm() < 1e-9 * (1.0 + gain.norm()), "{gain}");
        let real = peak(Block::RealScalar { n: 1 }).unwrap();
        let [below, above] = [real.upper, real.bounds.lower].map(f64::recip);
        assert!(below <= 1.0 + 1e-9 && below > 1.0 - 2e-4, "{below}");
        assert!((above - 1.0).abs() < 1e-6, "{above}");
    }
}

/// Modes s²+2ζωs+ω² with a gain g at their damping: each is g·s/(s²+2ζωs+ω²), real at ω alone, where it is g/(2ζω).
fn dampers(modes: &[(f64, f64, f64)]) -> StateSpace<Continuous> {
    let n = modes.len();
    let at = |i: usize, j: usize, mode: (f64, f64, f64)| match (i % 2, j % 2) {
        (0, 1) => 1.0,
        (1, 0) => -mode.0 * mode.0,
        (1, 1) => -2.0 * mode.1 * mode.0,
        _ => 0.0,
    };
    StateSpace::new(
        Mat::from_fn(2 * n, 2 * n, |i, j| if i / 2 == j / 2 { at(i, j, modes[i / 2]) } else { 0.0 }),
        Mat::from_fn(2 * n, n, |i, j| f64::from(u8::from(i == 2 * j + 1))),
        Mat::from_fn(n, 2 * n, |i, j| if j == 2 * i + 1 { modes[i].2 } else { 0.0 }),
        Mat::zeros(n, n),
        Continuous,
    )
    .unwrap()
}

#[test]
fn a_real_parameter_meets_its_bound_at_the_one_frequency_where_the_loop_is_real() {
    for (omega, damping) in [(1.0, 1e-3), (137.0, 1e-5), (1e4, 0.2)] {
        // 25 at the resonance.
        let mode = (omega, damping, 25.0 * 2.0 * damping * omega);
        let one = MuSystem::new(&dampers(&[mode]), &[Block::RealScalar { n: 1 }]).unwrap();
        let peak = one.peak(CERTIFICATE_SLACK).unwrap();
        assert!(peak.upper >= 25.0 && peak.upper < 25.0 * 1.01, "{omega}: {}", peak.upper);
        assert!((peak.bounds.lower / 25.0 - 1.0).abs() < 1e-6, "{omega}: {}", peak.bounds.lower);
        assert!((peak.lower_omega_rad_s / omega - 1.0).abs() < 1e-6, "{omega}: {}", peak.lower_omega_rad_s);
        // The perturbation does what it says.
        let loop_gain = peak.bounds.delta[(0, 0)] * one.response(peak.lower_omega_rad_s)[(0, 0)];
        assert!((loop_gain - 1.0).norm() < 1e-6, "{omega}: {loop_gain}");
    }
}

#[test]
fn a_repeated_real_parameter_meets_the_larger_of_two_resonances() {
    let damping = 1e-4;
    let modes = [(3.0, damping, 2.0 * damping * 3.0 * 8.0), (40.0, damping, 2.0 * damping * 40.0 * 5.0)];
    let repeated = MuSystem::new(&dampers(&modes), &[Block::RealScalar { n: 2 }]).unwrap();
    let peak = repeated.peak(CERTIFICATE_SLACK).unwrap();
    assert!((peak.bounds.lower / 8.0 - 1.0).abs() < 1e-6, "{}", peak.bounds.lower);
}

#[test]
fn a_peak_between_the_poles_is_not_missed() {
    // m = (αs + β)/(s² + 2ζωs + ω²) is real at w² = ω² − 2ζωβ/α, where it is α/(2ζω); beside it μ is zero, and the value at
    // rest is far below.
    for (omega, damping, beta) in [(1.0, 1e-3, 0.3), (300.0, 2e-5, -40.0), (2.5, 6e-5, 1.7), (40.0, 1e-2, 9.0)] {
        let (alpha, width): (f64, f64) = (0.7, 2.0 * damping * omega);
        let one = StateSpace::new(
            Mat::from_fn(2, 2, |i, j| [[0.0, 1.0], [-omega * omega, -width]][i][j]),
            Mat::from_fn(2, 1, |i, _| [0.0, 1.0][i]),
            Mat::from_fn(1, 2, |_, j| [beta, alpha][j]),
            Mat::zeros(1, 1),
            Continuous,
        )
        .unwrap();
        let peak = MuSystem::new(&one, &[Block::RealScalar { n: 1 }]).unwrap().peak(CERTIFICATE_SLACK).unwrap();
        let (exact, place) = (alpha / width, (omega * omega - width * beta / alpha).sqrt());
        assert!(peak.upper >= exact * (1.0 - 1e-9) && peak.upper < exact * 1.001, "{omega}: {} {exact}", peak.upper);
        assert!((peak.bounds.lower / exact - 1.0).abs() < 1e-6, "{omega}: {} {exact}", peak.bounds.lower);
        assert!((peak.lower_omega_rad_s / place - 1.0).abs() < 1e-8, "{omega}: {}", peak.lower_omega_rad_s);
    }
}
