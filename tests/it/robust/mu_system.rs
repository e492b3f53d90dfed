//! Peak of μ over frequency against the dense reference sweeps.

use crate::robust::control_cases::{Case, block_list, system};
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
            let proved = point.scaling.bound(&mu.response(point.omega_rad_s));
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
    use muspin::augment::Block;
    use muspin::linalg::Mat;
    use muspin::lti::{Continuous, Response, StateSpace};
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
