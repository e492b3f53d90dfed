//! D-scale fits against the reference's best error per order.

use crate::robust::control_cases::{Case, number_list};
use muspin::linalg::c64;
use muspin::lti::connect::block2;
use muspin::robust::dfit::{Magnitudes, fit_quick, fit_up_to};

/// The magnitudes of a case with weight one.
fn magnitudes(case: &Case) -> Magnitudes {
    let omega = number_list(&case.data["omega"]);
    let ones = vec![1.0; omega.len()];
    Magnitudes::new(omega, number_list(&case.data["magnitude"]), ones).unwrap()
}

#[test]
fn every_order_is_at_least_as_good_as_the_references() {
    for case in Case::all("dfit") {
        let data = magnitudes(&case);
        let start = std::time::Instant::now();
        let fits = fit_up_to(&data, 6).unwrap();
        let elapsed = start.elapsed();
        let mut previous = f64::INFINITY;
        for (order, fit) in fits.iter().enumerate().skip(1) {
            let tools = case.reference["orders"][order.to_string()].as_object().unwrap();
            let best = tools.values().filter_map(|t| t["max_abs_ln_error"].as_f64()).fold(f64::INFINITY, f64::min);
            eprintln!(
                "{} order {order}: {:.6e} reference {best:.6e} ({elapsed:?} for all)",
                case.id, fit.max_abs_ln_error
            );
            assert!(
                fit.max_abs_ln_error <= best,
                "{} order {order}: {} reference {best}",
                case.id,
                fit.max_abs_ln_error
            );
            assert!(fit.max_abs_ln_error <= previous * (1.0 + 1e-9) + 1e-9);
            previous = fit.max_abs_ln_error;
            assert_eq!(fit.system.order(), order);
            stable_with_stable_inverse(&fit.system);
        }
    }
}

#[test]
fn a_quick_fit_is_as_good_as_the_careful_one() {
    for case in Case::all("dfit") {
        let data = magnitudes(&case);
        let error = |d: &dyn Fn(f64) -> f64| {
            let points = data.points().map(|(w, m, _)| (d(w) / m).ln().abs());
            points.fold(0.0, f64::max)
        };
        for (order, careful) in fit_up_to(&data, 5).unwrap().into_iter().enumerate() {
            let quick = fit_quick(&data, order).state_space().unwrap();
            let gain = |w: f64| quick.transfer(c64::new(0.0, w))[(0, 0)].norm();
            let (found, best) = (error(&gain), careful.max_abs_ln_error);
            assert!(
                // A millionth is less than a D-scale is known to.
                found <= 1.01 * best + 1e-6,
                "{} order {order}: {found} for {best}",
                case.id
            );
        }
    }
}

fn stable_with_stable_inverse(d: &muspin::lti::StateSpace<muspin::lti::Continuous>) {
    assert!(d.growth_rate().unwrap() < 0.0);
    let gain = d.d[(0, 0)];
    let n = d.order();
    let zeros = muspin::linalg::Mat::from_fn(n, n, |i, j| d.a[(i, j)] - d.b[(i, 0)] * d.c[(0, j)] / gain);
    let slowest = muspin::linalg::eigenvalues(&zeros).unwrap().iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max);
    assert!(slowest < 0.0, "zero at {slowest}");
    let _ = block2(&d.a, &d.b, &d.c, &d.d);
}
